"""Clip sets: clips and how they are cut and linked, before a threshold makes a motion graph of them."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ..archive import (
    DAMAGE,
    ArchiveFormat,
    archive_from_bytes,
    archive_kind,
    archive_to_bytes,
    load_archive,
    require,
    save_archive,
)
from ..errors import StudyError
from ..files import read_regular
from ..motion.clip import MotionClip
from ..motion.contacts import ContactSettings
from ..motion.distance import CostSettings
from ..motion.graph import MotionGraph
from ..motion.graph_archive import GRAPH_FORMAT, graph_from_arrays, graph_to_arrays
from ..motion.graph_settings import MotionGraphSettings, ThresholdMode

CLIP_SET_FORMAT = ArchiveFormat("clip set", 2, StudyError)


@dataclass(frozen=True)
class ClipSet:
    """Clips of one character.

    Attributes
    ----------
    clips : tuple of MotionClip
    settings : MotionGraphSettings
        How they are cut and linked, but for what a study varies.
    """

    clips: tuple[MotionClip, ...]
    settings: MotionGraphSettings = field(default_factory=MotionGraphSettings)


def clip_set_to_bytes(clip_set: ClipSet) -> bytes:
    """Write the clips to an .npz in memory; the same clips always make the same bytes."""
    # Clips in an archive are a motion graph that has not been cut yet.
    bare = MotionGraph(clip_set.clips, 0.0, (), np.empty((0, 2), dtype=int), np.empty(0))
    clips, arrays = graph_to_arrays(bare)
    settings = asdict(clip_set.settings)
    settings["threshold_mode"] = clip_set.settings.threshold_mode.value
    weights = clip_set.settings.cost.joint_weights
    settings["cost"]["joint_weights"] = None if weights is None else dict(weights)
    return archive_to_bytes(CLIP_SET_FORMAT, {"clips": clips, "settings": settings}, arrays)


def save_clip_set(clip_set: ClipSet, path: str | os.PathLike) -> None:
    """Write the clips to a file; StudyError if that cannot be done."""
    save_archive(path, clip_set_to_bytes(clip_set), CLIP_SET_FORMAT)


def load_clip_set(path: str | os.PathLike) -> ClipSet:
    """Read the clips of :func:`save_clip_set`; StudyError names the file if it cannot be read."""
    return archive_from_bytes(CLIP_SET_FORMAT, load_archive(path, CLIP_SET_FORMAT), os.fspath(path), _clip_set)


def holds_motion_graph(path: str | os.PathLike) -> bool:
    """Test for the header of a motion graph; the file may still be damaged."""
    try:
        return archive_kind(read_regular(path)) == GRAPH_FORMAT.name
    except DAMAGE:
        return False


def _clip_set(content: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> ClipSet:
    clips: Sequence[MotionClip] = graph_from_arrays(content["clips"], arrays).clips
    require(clips)
    given = dict(content["settings"])
    feet = given["contacts"]["feet"]
    contacts = {**given["contacts"], "feet": None if feet is None else tuple(tuple(map(str, foot)) for foot in feet)}
    given["contacts"] = ContactSettings(**contacts)
    given["cost"] = CostSettings(**given["cost"])
    given["threshold_mode"] = ThresholdMode(given["threshold_mode"])
    return ClipSet(tuple(clips), MotionGraphSettings(**given))
