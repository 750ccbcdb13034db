"""Colours of the floor map: the lighter, the more ways; free floor that is out of reach stands out."""

import numpy as np

from ...core.environment.environment import Environment
from ...core.environment.grid import SUBDIVISION
from ...core.environment.regions import RegionRule

# sRGB, as a picture shows them.
FEWEST, MOST = (0.30, 0.30, 0.31), (0.98, 0.98, 0.97)
UNREACHED = (0.45, 0.13, 0.11)
BLOCKED = (0.10, 0.11, 0.13)
RULED = (0.47, 0.33, 0.10)
WALK = (0.10, 0.78, 0.25)
OBSTACLE = (0.33, 0.43, 0.56)
STEP = (0.96, 0.66, 0.16)

_PERCENTILE = 99.0
"""The lightest grey stands for this percentile, so that a single busy cell does not darken all others."""


def linear(srgb) -> np.ndarray:
    """sRGB components (0 to 1) as scene-linear ones."""
    srgb = np.asarray(srgb, dtype=float)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def lightest_value(values: np.ndarray) -> float:
    """The value of (nx, ny) ``values`` from which on cells are painted in the lightest grey; at least 1."""
    present = values[values > 0]
    return max(float(np.percentile(present, _PERCENTILE)), 1.0) if present.size else 1.0


def lightness(values: np.ndarray, lightest: float) -> np.ndarray:
    """0 to 1: how light cells with these values are. Square roots, because the values span several magnitudes."""
    return np.sqrt(np.clip(values / lightest, 0.0, 1.0))


def ruled_cells(environment: Environment) -> np.ndarray:
    """(nx, ny) bool: cells whose centre may be passed with the right tags only.

    There a character can often pass without a segment ending, so that nothing is counted in them.
    """
    corner = SUBDIVISION // 2
    ruled = np.zeros(environment.blocked.shape, dtype=bool)
    for region in environment.regions:
        if region.rule is not RegionRule.CONFINE:
            ruled |= region.mask
    return ruled[corner::SUBDIVISION, corner::SUBDIVISION]


def map_colors(values: np.ndarray, environment: Environment) -> np.ndarray:
    """(nx, ny, 4) linear RGBA for the floor.

    ``values`` is (nx, ny): how much of what is mapped there is in each cell, 0 where the character cannot go.
    """
    share = lightness(values, lightest_value(values))[..., None]
    colors = (1 - share) * FEWEST + share * np.asarray(MOST)
    free = environment.free_cells()
    colors[(values <= 0) & free] = UNREACHED
    colors[(values <= 0) & free & ruled_cells(environment)] = RULED
    colors[(values <= 0) & ~free] = BLOCKED
    return np.concatenate([linear(colors), np.ones((*values.shape, 1))], axis=2)
