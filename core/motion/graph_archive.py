"""Motion graphs in files and in memory: all of a graph as plain arrays and a header, and back to the last bit."""

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..archive import ArchiveFormat, archive_from_bytes, archive_to_bytes, load_archive, require, save_archive
from ..errors import MotionGraphError
from .clip import MotionClip
from .dropped import DroppedClip
from .graph import MotionGraph, MotionSegment
from .skeleton import Skeleton

GRAPH_FORMAT = ArchiveFormat("motion graph", 2, MotionGraphError)


def graph_to_bytes(graph: MotionGraph) -> bytes:
    """Return the graph with its clips as an .npz in memory, without pickles."""
    return archive_to_bytes(GRAPH_FORMAT, *graph_to_arrays(graph))


def graph_from_bytes(raw: bytes, source: str = "motion graph") -> MotionGraph:
    """Return the graph of :func:`graph_to_bytes`, equal to the last bit.

    MotionGraphError, with the name ``source``, for what is damaged, foreign or saved by a later version.
    """
    return archive_from_bytes(GRAPH_FORMAT, raw, source, graph_from_arrays)


def save_motion_graph(graph: MotionGraph, path: str | os.PathLike) -> None:
    """Write the graph to a file; MotionGraphError if that cannot be done."""
    save_archive(path, graph_to_bytes(graph), GRAPH_FORMAT)


def load_motion_graph(path: str | os.PathLike) -> MotionGraph:
    """Return the graph of :func:`save_motion_graph`; MotionGraphError names the file if it cannot be read."""
    return graph_from_bytes(load_archive(path, GRAPH_FORMAT), os.fspath(path))


def graph_to_arrays(graph: MotionGraph) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return all of a motion graph: what JSON can hold, and arrays by name."""
    skeletons = list({id(clip.skeleton): clip.skeleton for clip in graph.clips}.values())
    number = {id(skeleton): index for index, skeleton in enumerate(skeletons)}
    segments = [*graph.segments, *graph.dropped_segments]
    content = {
        "frame_rate": float(graph.frame_rate),
        # JSON knows no "not a number".
        "max_cost": None if math.isnan(graph.max_cost) else float(graph.max_cost),
        "skeletons": [list(skeleton.names) for skeleton in skeletons],
        "clips": [
            {
                "name": clip.name,
                "skeleton": number[id(clip.skeleton)],
                "frame_rate": float(clip.frame_rate),
                "first_frame": float(clip.first_frame),
                "n_frames": clip.n_frames,
                "tags": list(clip.tags),
                "has_heading": clip.heading is not None,
            }
            for clip in graph.clips
        ],
        "segments": [
            {
                "name": segment.name,
                "clip": int(segment.clip),
                "first": int(segment.first),
                "last": int(segment.last),
                "duration": float(segment.duration),
                "tags": list(segment.tags),
            }
            for segment in segments
        ],
        "n_kept": len(graph.segments),
        "dropped": [[drop.clip, float(drop.seconds), drop.reason] for drop in graph.dropped],
    }
    arrays = {
        "skeleton_parents": _joined((s.parents for s in skeletons), np.int64),
        "skeleton_rest_rotations": _joined((s.rest_rotations for s in skeletons), float),
        "skeleton_rest_translations": _joined((s.rest_translations for s in skeletons), float),
        "skeleton_forward": _joined((s.forward for s in skeletons), float),
        # Frames last: what follows in time is alike.
        "clip_rotations": _joined((clip.rotations.T for clip in graph.clips), float),
        "clip_translations": _joined((clip.translations.T for clip in graph.clips), float),
        "clip_tags": _joined((mask for clip in graph.clips for mask in clip.tags.values()), bool),
        "clip_heading": _joined((clip.heading for clip in graph.clips if clip.heading is not None), float),
        "segment_paths": _joined((segment.path.T for segment in segments), float),
        "segment_tags": _joined((mask for segment in segments for mask in segment.tags.values()), bool),
        "links": np.asarray(graph.links, dtype=np.int64),
        "link_costs": np.asarray(graph.link_costs, dtype=float),
        "dropped_links": np.asarray(graph.dropped_links, dtype=np.int64),
    }
    return content, arrays


def graph_from_arrays(content: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> MotionGraph:
    """Return the motion graph of :func:`graph_to_arrays`; an exception, mostly ValueError, if they do not fit."""
    read = {name: _Reader(array) for name, array in arrays.items()}
    skeletons = []
    for names in content["skeletons"]:
        n_joints = len(names)
        skeletons.append(
            Skeleton(
                tuple(names),
                read["skeleton_parents"].take(n_joints),
                read["skeleton_rest_rotations"].take(n_joints, 4),
                read["skeleton_rest_translations"].take(n_joints, 3),
                read["skeleton_forward"].take(3),
            )
        )
    clips = [_clip(entry, skeletons, read) for entry in content["clips"]]
    segments = []
    for entry in content["segments"]:
        clip, first, last = entry["clip"], entry["first"], entry["last"]
        require(0 <= first < last)
        # Made-up graphs may have no clips.
        require(not clips or (0 <= clip < len(clips) and last < clips[clip].n_frames))
        n_frames = last - first + 1
        path = np.ascontiguousarray(read["segment_paths"].take(3, n_frames).T)
        tags = {tag: read["segment_tags"].take(n_frames) for tag in entry["tags"]}
        segments.append(MotionSegment(entry["name"], clip, first, last, path, float(entry["duration"]), tags))
    n_kept, links, dropped_links = content["n_kept"], arrays["links"], arrays["dropped_links"]
    require(0 <= n_kept <= len(segments))
    for pairs, n_known in ((links, n_kept), (dropped_links, len(segments))):
        require(pairs.dtype == np.int64 and pairs.shape == (len(pairs), 2))
        require(np.all((pairs >= 0) & (pairs < n_known)))
    require(arrays["link_costs"].shape == (len(links),))
    return MotionGraph(
        clips=tuple(clips),
        frame_rate=float(content["frame_rate"]),
        segments=tuple(segments[:n_kept]),
        links=links,
        link_costs=arrays["link_costs"],
        dropped=tuple(DroppedClip(str(clip), float(seconds), str(why)) for clip, seconds, why in content["dropped"]),
        max_cost=math.nan if content["max_cost"] is None else float(content["max_cost"]),
        dropped_segments=tuple(segments[n_kept:]),
        dropped_links=dropped_links,
    )


def _clip(entry: Mapping[str, Any], skeletons: Sequence[Skeleton], read: "Mapping[str, _Reader]") -> MotionClip:
    require(0 <= entry["skeleton"] < len(skeletons))
    skeleton, n_frames = skeletons[entry["skeleton"]], entry["n_frames"]
    rotations = read["clip_rotations"].take(4, skeleton.n_joints, n_frames)
    translations = read["clip_translations"].take(3, skeleton.n_joints, n_frames)
    return MotionClip(
        name=entry["name"],
        skeleton=skeleton,
        frame_rate=float(entry["frame_rate"]),
        rotations=np.ascontiguousarray(rotations.T),
        translations=np.ascontiguousarray(translations.T),
        tags={tag: read["clip_tags"].take(n_frames) for tag in entry["tags"]},
        first_frame=float(entry["first_frame"]),
        heading=read["clip_heading"].take(n_frames) if entry["has_heading"] else None,
    )


def _joined(arrays: Iterable[np.ndarray], kind: type) -> np.ndarray:
    """All numbers of some arrays, one after another."""
    return np.concatenate([np.empty(0, dtype=kind), *(np.asarray(array, dtype=kind).ravel() for array in arrays)])


class _Reader:
    """Takes arrays from a joined one, in turn."""

    def __init__(self, joined: np.ndarray):
        self._joined = joined
        self._next = 0

    def take(self, *shape: int) -> np.ndarray:
        """A copy of the next numbers; ValueError if there are not so many."""
        n = math.prod(shape)
        start, self._next = self._next, self._next + n
        return self._joined[start : self._next].reshape(shape).copy()
