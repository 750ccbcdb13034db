"""Groups of segments that people name: a segment, a clip, a tag."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..errors import EvaluationError
from ..motion.graph import MotionGraph


class Grouping(Enum):
    """A way to group the segments of a motion graph."""

    SEGMENT = "segment"
    CLIP = "clip"
    TAG = "tag"


@dataclass(frozen=True)
class SegmentGroup:
    """The segments of a clip or with a tag, or a single one: an *action*, or what ablation takes away together.

    Attributes
    ----------
    kind : Grouping
    name : str
        Of the segment, clip or tag.
    segments : tuple of int
    """

    kind: Grouping
    name: str
    segments: tuple[int, ...]


def segment_groups(graph: MotionGraph, kind: Grouping) -> list[SegmentGroup]:
    """Return all segments, clips or tags of a motion graph; clips in their order, tags by name.

    >>> from ..motion.graph import MotionSegment
    >>> step = MotionSegment("step", 0, 0, 1, np.zeros((2, 3)), 1 / 30, {"hop": np.ones(2, dtype=bool)})
    >>> walk = MotionSegment("walk", 0, 1, 2, np.zeros((2, 3)), 1 / 30, {})
    >>> graph = MotionGraph((), 30.0, (step, walk), np.array([[0, 1]]), np.zeros(1))
    >>> [(found.name, found.segments) for kind in Grouping for found in segment_groups(graph, kind)]
    [('step', (0,)), ('walk', (1,)), ('clip 0', (0, 1)), ('hop', (0,))]
    """
    indices = range(len(graph.segments))
    if kind is Grouping.SEGMENT:
        return [SegmentGroup(kind, graph.segments[i].name, (i,)) for i in indices]
    if kind is Grouping.CLIP:
        members: dict[int, list[int]] = {}
        for i in indices:
            members.setdefault(graph.segments[i].clip, []).append(i)
        named = len(graph.clips) > max(members, default=0)
        return [
            SegmentGroup(kind, graph.clips[clip].name if named else f"clip {clip}", tuple(members[clip]))
            for clip in sorted(members)
        ]
    tags = sorted({tag for segment in graph.segments for tag in segment.tags})
    return [SegmentGroup(kind, tag, tuple(i for i in indices if tag in graph.segments[i].tags)) for tag in tags]


def segments_with_tag(graph: MotionGraph, tag: str) -> tuple[int, ...]:
    """Segments with a tag on any frame; EvaluationError, with the tags that there are, if there is none."""
    tagged = {group.name: group.segments for group in segment_groups(graph, Grouping.TAG)}
    found = tuple(i for i in tagged.get(tag, ()) if np.any(graph.segments[i].tags[tag]))
    if not found:
        known = ", ".join(f"'{name}'" for name in tagged) or "none"
        raise EvaluationError(
            f"No segment of the motion graph carries the tag '{tag}' (tags: {known}); mark frames of a clip with it."
        )
    return found


def segments_of_clip(graph: MotionGraph, clip: str) -> tuple[int, ...]:
    """Segments that were cut from a clip, by its name; EvaluationError, with the reason, if there is none."""
    cut = {group.name: group.segments for group in segment_groups(graph, Grouping.CLIP)}
    if clip not in cut:
        dropped = {lost.clip: lost.reason for lost in graph.dropped}
        reason = f" ({dropped[clip]})" if clip in dropped else ""
        raise EvaluationError(
            f"No segment of the motion graph comes from the clip '{clip}'{reason}; choose another, or build the graph "
            "with a higher Max Cost."
        )
    return cut[clip]
