"""Scales of colour for maps: the paper's greys, and two that everybody can tell apart, on paper and in grey, too."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from .colors import BLOCKED, FEWEST, MOST, RULED, UNREACHED

SRGB = tuple[float, float, float]


class Palette(Enum):
    """How amounts are shown."""

    GREYS = "greys"
    VIRIDIS = "viridis"
    CIVIDIS = "cividis"


@dataclass(frozen=True)
class Scale:
    """Colours in sRGB (0 to 1).

    Attributes
    ----------
    stops : tuple of colours
        From the least to the most, evenly spaced; what lies between two is mixed from them.
    unreached, ruled, blocked : colours
        Free floor without any of what is mapped; the same where a region has a rule; floor near obstacles.
    """

    stops: tuple[SRGB, ...]
    unreached: SRGB
    ruled: SRGB
    blocked: SRGB

    def colors(self, share: np.ndarray) -> np.ndarray:
        """(..., 3) sRGB for shares (...) from 0, the least, to 1, the most."""
        stops = np.array(self.stops)
        at = np.linspace(0, 1, len(stops))
        return np.stack([np.interp(share, at, stops[:, k]) for k in range(3)], axis=-1)


# Van der Walt and Smith's viridis (CC0), and cividis after Nunez, Anderton and Renslow 2018, at 13 places.
_VIRIDIS = (
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
)
_CIVIDIS = (
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
)

# Beside colours of all lightnesses, only what is lighter and darker than any of them stands out for everybody.
_PALE, _PALE_RULED, _BLACK = (0.93, 0.93, 0.95), (0.72, 0.58, 0.84), (0.03, 0.03, 0.035)

_SCALES = {
    Palette.GREYS: Scale((FEWEST, MOST), UNREACHED, RULED, BLOCKED),
    Palette.VIRIDIS: Scale(_VIRIDIS, _PALE, _PALE_RULED, _BLACK),
    Palette.CIVIDIS: Scale(_CIVIDIS, _PALE, _PALE_RULED, _BLACK),
}


def scale_of(palette: Palette) -> Scale:
    """The colours of a palette."""
    return _SCALES[palette]
