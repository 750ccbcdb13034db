"""Colour scales: numbers as colours that everybody can tell apart."""

from dataclasses import dataclass

import numpy as np

from .drawing import Color


@dataclass(frozen=True)
class ColorScale:
    """Colours evenly spaced from the lowest to the highest value; sRGB, linear between them.

    Attributes
    ----------
    name : str
    stops : (n, 3) nested tuple
    """

    name: str
    stops: tuple[Color, ...]

    def colors(self, share: np.ndarray) -> np.ndarray:
        """(..., 3) sRGB components for shares of the way from the lowest (0) to the highest (1) value."""
        places = np.clip(share, 0.0, 1.0) * (len(self.stops) - 1)
        return np.stack(
            [np.interp(places, np.arange(len(self.stops)), channel) for channel in np.transpose(self.stops)], axis=-1
        )


#: As in the paper's figures: the lighter, the more.
GREYS = ColorScale("Greys", ((0.30, 0.30, 0.31), (0.98, 0.98, 0.97)))

#: Nuñez, Anderton and Renslow, "Optimizing colormaps with consideration for color vision deficiency", PLOS ONE 2018.
CIVIDIS = ColorScale(
    "Cividis",
    (
        (0.000, 0.135, 0.305),
        (0.081, 0.205, 0.430),
        (0.259, 0.288, 0.424),
        (0.367, 0.371, 0.432),
        (0.466, 0.456, 0.458),
        (0.571, 0.545, 0.463),
        (0.687, 0.640, 0.438),
        (0.808, 0.741, 0.379),
        (0.932, 0.847, 0.273),
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
