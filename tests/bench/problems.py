"""The problems that are measured: motion graphs and rooms of the paper's size."""

import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from core.environment.environment import Environment, EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.motion.clip import MotionClip
from core.motion.graph import MotionGraph, ThresholdMode, build_motion_graph
from core.motion.repertoire import sample_repertoire
from tests.core.bvh import read_bvh
from tests.core.geometry import box_triangles
from tests.core.motion_graphs import DEFECTIVE_FRAMES, SHORT


def data_folder() -> Path:
    """Where the recorded motions are, if they are at hand."""
    return Path(os.environ.get("WAYFARER_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))


@cache
def clips() -> tuple[MotionClip, ...]:
    """The recorded motions where they are at hand (WAYFARER_DATA), the sample character's otherwise."""
    folder = data_folder() / "cmu16"
    if not folder.is_dir():
        return tuple(sample_repertoire())
    return tuple(read_bvh(f, drop_first=DEFECTIVE_FRAMES.get(f.stem, 0)) for f in sorted(folder.glob("*.bvh")))


@cache
def large_clips() -> tuple[MotionClip, ...]:
    """The 160 recorded motions (611 s) of the scale set; none where they are not at hand."""
    return tuple(read_bvh(file) for file in sorted((data_folder() / "cmu_locomotion").glob("*.bvh")))


@cache
def graph(max_cost: float) -> MotionGraph:
    """The motion graph of :func:`clips` at a threshold."""
    return build_motion_graph(list(clips()), replace(SHORT, max_cost=max_cost))


@cache
def scarce_graph() -> MotionGraph:
    """A motion graph of the sample character's clips with few links: many small components, and large ones beside."""
    settings = replace(SHORT, threshold_mode=ThresholdMode.LINKS, max_links=200)
    return build_motion_graph(sample_repertoire(), settings)


@cache
def room(width: float = 7.0, depth: float = 8.0, pillars_per_area: float = 0.12) -> Environment:
    """A ground of width x depth metres with square pillars scattered over it (pillars per square metre)."""
    rng = np.random.default_rng(11)
    n_pillars = int(width * depth * pillars_per_area)
    corners = rng.uniform([0.5, 0.5], [width - 1, depth - 1], (n_pillars, 2))
    sides = rng.uniform(0.2, 0.5, (n_pillars, 2))
    boxes = [box_triangles((*low, 0), (*(low + side), 2)) for low, side in zip(corners, sides, strict=True)]
    grid = Grid.over_rectangle((0, 0), (width, depth), 0.125, 24)
    return build_environment(grid, np.concatenate(boxes), settings=EnvironmentSettings(radius=0.25))
