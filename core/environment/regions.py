"""Annotated regions: parts of the ground where only some motion may be played."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..errors import SceneError
from .grid import SUBDIVISION, Grid
from .obstacles import PolygonRaster, clip_to_heights, samples_within, strips


class RegionRule(Enum):
    """The demand of a region on the frames that are played in it."""

    REQUIRE = "require"
    FORBID = "forbid"
    CONFINE = "confine"


@dataclass(frozen=True)
class Region:
    """A region as the scene gives it.

    Attributes
    ----------
    name : str
        For messages: the object's name.
    rule : RegionRule
        REQUIRE: inside it only frames with the tag may be played. FORBID: frames with the tag may not.
        CONFINE: frames with the tag may be played inside it only (several confining regions add up).
    tag : str
    triangles : (T, 3, 3) float array
        World-space triangles in metres; the region is their shadow on the ground.
    margin : float
        Metres by which the region is grown (REQUIRE and FORBID), to keep the body clear of what stands there.
    """

    name: str
    rule: RegionRule
    tag: str
    triangles: np.ndarray
    margin: float = 0.0


@dataclass(frozen=True)
class RegionMask:
    """A region on the sample mask.

    Attributes
    ----------
    name, rule, tag : as in Region
    mask : (4 nx, 4 ny) bool array
        REQUIRE and FORBID: every sample that the grown region touches. CONFINE: samples inside it.
    """

    name: str
    rule: RegionRule
    tag: str
    mask: np.ndarray


#: Confining regions are looked at on a mask this many times finer: gaps narrower than its samples count as closed.
_FINER = 4


def rasterise_regions(regions: Sequence[Region], grid: Grid) -> tuple[RegionMask, ...]:
    """Return the regions on the grid's sample mask, rounded to the safe side of their rules.

    Regions that confine the same tag add up, also where they only meet: they become one mask.

    Raises SceneError, with the region's name, for what is not a number, a negative margin, and a region that covers
    no part of the ground.
    """
    masks = []
    for region in regions:
        if not (np.isfinite(region.margin) and region.margin >= 0):
            raise SceneError(f"The margin of the region '{region.name}' is {region.margin}; it must be zero or more.")
        if not np.isfinite(region.triangles).all():
            raise SceneError(f"The region '{region.name}' has a vertex whose position is not a number; repair it.")
        if region.rule is not RegionRule.CONFINE:
            mask = samples_within(grid, _shadow(_triangles(region)), region.margin)
            masks.append(RegionMask(region.name, region.rule, region.tag, mask))
            if not mask.any():
                raise SceneError(
                    f"The region '{region.name}' covers no part of the ground; move it onto the ground or remove it."
                )
    for tag in dict.fromkeys(region.tag for region in regions if region.rule is RegionRule.CONFINE):
        confining = [region for region in regions if region.rule is RegionRule.CONFINE and region.tag == tag]
        names = ", ".join(region.name for region in confining)
        mask = samples_inside(np.concatenate([_triangles(region) for region in confining]), grid)
        if not mask.any():
            raise SceneError(
                f"The region '{names}' holds no part of the ground that is as wide as a quarter of a cell; make it "
                "larger, move it onto the ground or remove it."
            )
        masks.append(RegionMask(names, RegionRule.CONFINE, tag, mask))
    return tuple(masks)


def _triangles(region: Region) -> np.ndarray:
    return np.asarray(region.triangles, dtype=float).reshape(-1, 3, 3)


def _shadow(triangles: np.ndarray) -> np.ndarray:
    return clip_to_heights(triangles, -np.inf, np.inf)


def samples_inside(triangles: np.ndarray, grid: Grid) -> np.ndarray:
    """Return (4 nx, 4 ny) bool: samples wholly inside what (T, 3, 3) triangles (m) cover, seen from above.

    On a finer mask, what the border crosses has an untouched neighbour on the border's outer side; what is left when
    all that has one is taken away lies inside, and so do the samples made of nothing else.
    """
    nx, ny, n_headings = grid.shape
    finer = Grid((nx * _FINER, ny * _FINER, n_headings), grid.cell_size / _FINER, grid.origin, grid.tiled)
    # The tolerance lets a region that ends with a sample hold it.
    raster = PolygonRaster(finer, _shadow(triangles), margin=1, tolerance=1e-6)
    width, depth = nx * SUBDIVISION, ny * SUBDIVISION
    inside = np.empty((width, depth), dtype=bool)
    for first, last in strips(width, depth * _FINER**2):
        touched = raster.rows(first * _FINER, last * _FINER + 2)
        rows = touched[:-2] & touched[1:-1] & touched[2:]
        kept = rows[:, :-2] & rows[:, 1:-1] & rows[:, 2:]
        inside[first:last] = kept.reshape(last - first, _FINER, depth, _FINER).all(axis=(1, 3))
    return inside
