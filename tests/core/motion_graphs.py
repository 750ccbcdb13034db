"""Motion graphs of real size for the tests, built once."""

from functools import cache
from pathlib import Path

from core.motion.distance import CostSettings
from core.motion.graph import MotionGraph, MotionGraphSettings, build_motion_graph
from core.motion.repertoire import sample_repertoire

from .bvh import read_bvh

#: Frames at the start of a recording that hold no motion (said by the data's manifest).
DEFECTIVE_FRAMES = {"16_28": 6}


#: Shorter segments and more links than by default: more to go wrong in little time.
SHORT = MotionGraphSettings(min_segment_duration=0.67, cost=CostSettings(travel_weight=0.3, turn_weight=0.3))


@cache
def sample_graph() -> MotionGraph:
    """The motion graph of the procedural sample character."""
    return build_motion_graph(list(sample_repertoire()), SHORT)


@cache
def recorded_clips(data_folder: Path):
    """The 23 recorded motions of cmu16, at 120 frames per second."""
    files = sorted((data_folder / "cmu16").glob("*.bvh"))
    return tuple(read_bvh(f, drop_first=DEFECTIVE_FRAMES.get(f.stem, 0)) for f in files)


@cache
def recorded_graph(data_folder: Path) -> MotionGraph:
    """The motion graph of the recorded motions."""
    return build_motion_graph(list(recorded_clips(data_folder)), SHORT)
