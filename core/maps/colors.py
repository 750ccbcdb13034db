"""Colours of floor maps: the lighter, the more; free floor that is out of reach stands out."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..embedding.embedding import Embedding
from ..environment.environment import Environment
from ..environment.regions import RegionRule
from ..evaluation.floor import ruled_cells
from .scales import CIVIDIS, GREYS, VIRIDIS, Color, ColorScale

# sRGB, as a picture shows them.
UNREACHED: Color = (0.45, 0.13, 0.11)
BLOCKED: Color = (0.10, 0.11, 0.13)
RULED: Color = (0.47, 0.33, 0.10)
WALK: Color = (0.10, 0.78, 0.25)
OBSTACLE: Color = (0.33, 0.43, 0.56)
STEP: Color = (0.96, 0.66, 0.16)

_PERCENTILE = 99.0
"""The lightest colour stands for this percentile, so that a single busy cell does not darken all others."""


class Palette(Enum):
    """The scales that a floor can be painted in."""

    GREYS = "greys"
    VIRIDIS = "viridis"
    CIVIDIS = "cividis"


@dataclass(frozen=True)
class FloorScale(ColorScale):
    """A colour scale with the colours of floor beside it.

    Attributes
    ----------
    unreached, ruled, blocked : colours
        Free floor without any of what is mapped; the same where a region has a rule; floor near obstacles.
    """

    unreached: Color
    ruled: Color
    blocked: Color


# Beside colours of all lightnesses, only what is lighter and darker than any of them stands out for everybody.
_BESIDE = ((0.93, 0.93, 0.95), (0.72, 0.58, 0.84), (0.03, 0.03, 0.035))

_SCALES = {
    Palette.GREYS: FloorScale(GREYS.name, GREYS.stops, UNREACHED, RULED, BLOCKED),
    Palette.VIRIDIS: FloorScale(VIRIDIS.name, VIRIDIS.stops, *_BESIDE),
    Palette.CIVIDIS: FloorScale(CIVIDIS.name, CIVIDIS.stops, *_BESIDE),
}


def scale_of(palette: Palette) -> FloorScale:
    """Return the colours of a palette."""
    return _SCALES[palette]


def lightest_value(values: np.ndarray) -> float:
    """Return the value of (nx, ny) ``values`` from which on cells have the lightest colour; at least 1."""
    present = values[values > 0]
    return max(float(np.percentile(present, _PERCENTILE)), 1.0) if present.size else 1.0


def lightness(values: np.ndarray, lightest: float) -> np.ndarray:
    """Return places on a scale, 0 to 1, of values. Square roots, because the values span several magnitudes.

    >>> lightness(np.array([0, 1, 4, 9]), lightest=4.0).tolist()
    [0.0, 0.5, 1.0, 1.0]
    """
    return np.sqrt(np.clip(values / lightest, 0.0, 1.0))


def ruled_samples(environment: Environment) -> np.ndarray:
    """Return (4 nx, 4 ny) bool: samples in regions that require or forbid a tag."""
    ruled = np.zeros(environment.blocked.shape, dtype=bool)
    for region in environment.regions:
        if region.rule is not RegionRule.CONFINE:
            ruled |= region.mask
    return ruled


def linear(srgb) -> np.ndarray:
    """Convert sRGB components (0 to 1) to scene-linear ones."""
    srgb = np.asarray(srgb, dtype=float)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def displayed(colors) -> np.ndarray:
    """Convert scene-linear components to sRGB ones: the inverse of :func:`linear`."""
    colors = np.asarray(colors, dtype=float)
    return np.where(colors <= 0.0031308, 12.92 * colors, 1.055 * np.maximum(colors, 0.0031308) ** (1 / 2.4) - 0.055)


def opaque_map(srgb: np.ndarray) -> np.ndarray:
    """Return (nx, ny, 4) linear RGBA of (nx, ny, 3) sRGB colours."""
    return np.concatenate([linear(srgb), np.ones((*srgb.shape[:2], 1))], axis=2)


def scaled_colors(share: np.ndarray, present: np.ndarray, embedding: Embedding, scale: FloorScale) -> np.ndarray:
    """Return (nx, ny, 4) linear RGBA for the floor.

    ``share`` is (nx, ny), from 0 to 1: where on the scale each cell lies that is ``present`` (nx, ny). The others are
    out of reach, ruled or blocked.
    """
    colors, environment = scale.colors(share), embedding.environment
    free = environment.free_cells()
    colors[~present & free] = scale.unreached
    colors[~present & ruled_cells(environment, embedding.unrolling.sweep.classes)] = scale.ruled
    colors[~present & ~free] = scale.blocked
    return opaque_map(colors)
