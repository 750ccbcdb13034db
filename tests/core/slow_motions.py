"""Motions that take longer: the small problems' own segments last fractions of a second."""

from dataclasses import replace

import numpy as np

from core.motion.graph import MotionGraph


def slower(graph: MotionGraph, slowness: int) -> MotionGraph:
    """The same motions with every segment's frames held for a while: longer by up to a factor of ``slowness``."""
    rng = np.random.default_rng(len(graph.segments))
    segments = []
    for segment in graph.segments:
        held = int(rng.integers(1, slowness + 1))
        path = np.repeat(segment.path, held, axis=0)
        tags = {tag: np.repeat(mask, held) for tag, mask in segment.tags.items()}
        duration = (len(path) - 1) / graph.frame_rate
        segments.append(replace(segment, path=path, first=0, last=len(path) - 1, duration=duration, tags=tags))
    return replace(graph, segments=tuple(segments))
