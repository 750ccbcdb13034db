"""Colour scales: numbers as colours (sRGB, 0 to 1) that everybody can tell apart."""

from dataclasses import dataclass

import numpy as np

Color = tuple[float, float, float]


@dataclass(frozen=True)
class ColorScale:
    """Colours from the lowest to the highest value, evenly spaced and linear in sRGB between them.

    Attributes
    ----------
    name : str
    stops : tuple of colours

    Examples
    --------
    >>> GREYS.colors(np.array([0.0, 0.5])).round(2).tolist()
    [[0.3, 0.3, 0.31], [0.64, 0.64, 0.64]]
    """

    name: str
    stops: tuple[Color, ...]

    def colors(self, share: np.ndarray) -> np.ndarray:
        """Return (..., 3) colours for shares (...) of the way from the lowest (0) to the highest (1) value."""
        at = np.linspace(0.0, 1.0, len(self.stops))
        return np.stack([np.interp(share, at, channel) for channel in np.transpose(self.stops)], axis=-1)


#: As in the paper's figures: the lighter, the more.
GREYS = ColorScale("Greys", ((0.30, 0.30, 0.31), (0.98, 0.98, 0.97)))

#: Van der Walt and Smith's viridis (CC0).
VIRIDIS = ColorScale(
    "Viridis",
    (
        (0.267, 0.005, 0.329),
        (0.283, 0.121, 0.441),
        (0.268, 0.224, 0.512),
        (0.230, 0.322, 0.546),
        (0.191, 0.407, 0.556),
        (0.158, 0.486, 0.558),
        (0.128, 0.567, 0.551),
        (0.126, 0.644, 0.525),
        (0.208, 0.719, 0.473),
        (0.369, 0.789, 0.383),
        (0.565, 0.842, 0.263),
        (0.783, 0.879, 0.125),
        (0.993, 0.906, 0.144),
    ),
)

#: Nuñez, Anderton and Renslow, "Optimizing colormaps with consideration for color vision deficiency", PLOS ONE 2018.
CIVIDIS = ColorScale(
    "Cividis",
    (
        (0.000, 0.135, 0.305),
        (0.000, 0.191, 0.441),
        (0.165, 0.248, 0.429),
        (0.264, 0.308, 0.423),
        (0.342, 0.365, 0.429),
        (0.415, 0.423, 0.445),
        (0.489, 0.485, 0.471),
        (0.567, 0.547, 0.470),
        (0.648, 0.611, 0.455),
        (0.736, 0.681, 0.424),
        (0.824, 0.751, 0.377),
        (0.914, 0.826, 0.304),
        (0.996, 0.909, 0.218),
    ),
)

#: Series of charts: Okabe and Ito's colours, told apart in every common colour vision.
SERIES: tuple[Color, ...] = (
    (0.00, 0.45, 0.70),
    (0.90, 0.45, 0.00),
    (0.00, 0.62, 0.45),
    (0.80, 0.47, 0.65),
    (0.34, 0.71, 0.91),
    (0.60, 0.50, 0.10),
)
