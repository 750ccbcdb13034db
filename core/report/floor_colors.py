"""Colours of floor maps: the lighter, the more; free floor that is out of reach stands out."""

import numpy as np

from ..environment.environment import Environment
from ..environment.regions import RegionRule
from .drawing import Color

# sRGB, as a picture shows them.
UNREACHED: Color = (0.45, 0.13, 0.11)
BLOCKED: Color = (0.10, 0.11, 0.13)
RULED: Color = (0.47, 0.33, 0.10)
WALK: Color = (0.10, 0.78, 0.25)
OBSTACLE: Color = (0.33, 0.43, 0.56)
STEP: Color = (0.96, 0.66, 0.16)

_PERCENTILE = 99.0
"""The lightest colour stands for this percentile, so that a single busy cell does not darken all others."""


def lightest_value(values: np.ndarray) -> float:
    """The value of (nx, ny) ``values`` from which on cells are painted in the lightest colour; at least 1."""
    present = values[values > 0]
    return max(float(np.percentile(present, _PERCENTILE)), 1.0) if present.size else 1.0


def lightness(values: np.ndarray, lightest: float) -> np.ndarray:
    """0 to 1: how light cells with these values are. Square roots, because the values span several magnitudes."""
    return np.sqrt(np.clip(values / lightest, 0.0, 1.0))


def ruled_samples(environment: Environment) -> np.ndarray:
    """(4 nx, 4 ny) bool: samples in regions that require or forbid a tag."""
    ruled = np.zeros(environment.blocked.shape, dtype=bool)
    for region in environment.regions:
        if region.rule is not RegionRule.CONFINE:
            ruled |= region.mask
    return ruled
