"""Colours of the floor map: the lighter, the more ways; free floor that is out of reach stands out."""

from typing import TYPE_CHECKING

import numpy as np

from ..embedding.embedding import Embedding
from ..evaluation.floor import ruled_cells
from ..report.color_scale import GREYS
from ..report.floor_colors import BLOCKED, OBSTACLE, RULED, STEP, UNREACHED, WALK, lightest_value, lightness

if TYPE_CHECKING:
    from .palettes import Scale

__all__ = [
    "BLOCKED",
    "FEWEST",
    "MOST",
    "OBSTACLE",
    "RULED",
    "STEP",
    "UNREACHED",
    "WALK",
    "displayed",
    "lightest_value",
    "lightness",
    "linear",
    "opaque_map",
    "scaled_colors",
]

FEWEST, MOST = GREYS.stops


def linear(srgb) -> np.ndarray:
    """sRGB components (0 to 1) as scene-linear ones."""
    srgb = np.asarray(srgb, dtype=float)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def displayed(colors) -> np.ndarray:
    """Scene-linear components as sRGB ones: what :func:`linear` undoes."""
    colors = np.asarray(colors, dtype=float)
    return np.where(colors <= 0.0031308, 12.92 * colors, 1.055 * np.maximum(colors, 0.0031308) ** (1 / 2.4) - 0.055)


def opaque_map(srgb: np.ndarray) -> np.ndarray:
    """(nx, ny, 4) linear RGBA of (nx, ny, 3) sRGB colours."""
    return np.concatenate([linear(srgb), np.ones((*srgb.shape[:2], 1))], axis=2)


def scaled_colors(share: np.ndarray, present: np.ndarray, embedding: Embedding, scale: "Scale") -> np.ndarray:
    """(nx, ny, 4) linear RGBA for the floor.

    ``share`` is (nx, ny), from 0 to 1: where on the scale each cell lies that is ``present`` (nx, ny). The others are
    out of reach, ruled or blocked.
    """
    colors, environment = scale.colors(share), embedding.environment
    free = environment.free_cells()
    colors[~present & free] = scale.unreached
    colors[~present & ruled_cells(environment, embedding.unrolling.sweep.classes)] = scale.ruled
    colors[~present & ~free] = scale.blocked
    return opaque_map(colors)
