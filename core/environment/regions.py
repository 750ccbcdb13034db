"""Annotated regions: parts of the ground where only some motion may be played."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy import ndimage

from .grid import Grid
from .obstacles import clip_to_heights, occupied_samples, samples_within


class RegionRule(Enum):
    """What a region asks of the frames that are played in it."""

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
        REQUIRE and FORBID: every sample that the grown region touches. CONFINE: samples wholly inside it.
    """

    name: str
    rule: RegionRule
    tag: str
    mask: np.ndarray


def rasterise_region(region: Region, grid: Grid) -> RegionMask:
    """The region on the grid's sample mask, rounded to the safe side of its rule."""
    shadow = clip_to_heights(np.asarray(region.triangles, dtype=float), -np.inf, np.inf)
    if region.rule is not RegionRule.CONFINE:
        return RegionMask(region.name, region.rule, region.tag, samples_within(grid, shadow, region.margin))
    # A sample that the border crosses has an untouched neighbour on the border's outer side.
    touched = occupied_samples(grid, shadow, margin=1)
    inside = ndimage.binary_erosion(touched, np.ones((3, 3), dtype=bool))[1:-1, 1:-1]
    return RegionMask(region.name, region.rule, region.tag, inside)
