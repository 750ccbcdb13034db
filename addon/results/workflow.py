"""The steps of the workflow as functions of a scene: what buttons and the command line do alike.

Each comes in two halves: a generator that gathers input before its first yield and changes nothing, and a function
that keeps what came of it.
"""

from collections.abc import Generator
from dataclasses import dataclass, replace

import bpy
import numpy as np
from mathutils import Vector

from ...core.embedding.embedding import Embedding, embed_steps
from ...core.evaluation.variability import coverage_share
from ...core.motion.doctor import ClipMotion, clip_motions
from ...core.motion.graph import MotionGraph, build_motion_graph_steps
from ...core.motion.graph_summary import summarize
from ...core.progress import Progress, portion
from ..bridge.read_scene import ShapeMemory, shown_objects
from ..scene.inputs import (
    SceneShapes,
    check_any,
    graph_settings,
    graph_settings_fingerprint,
    make_environment,
    prepared_clips_steps,
    read_character_steps,
    read_shapes,
)
from ..scene.motion_fingerprint import actions_fingerprint
from ..scene.relief import uneven_ground
from .clips import keep_motion
from .store import graph_of, keep_embedding, played_by, results


@dataclass(frozen=True)
class BuiltGraph:
    """A motion graph, the fingerprint of what it was made from, (action name, reason) of what could not be read, and
    by name the fingerprint of each action and how far it goes."""

    graph: MotionGraph
    actions: str
    n_clips: int
    problems: tuple[tuple[str, str], ...]
    seen: dict[str, str]
    motions: dict[str, ClipMotion]


def build_graph_steps(scene) -> Generator[Progress, None, BuiltGraph]:
    """Build the motion graph of the scene's character; raises ClipError if its clips do not make one."""
    read = yield from portion(read_character_steps(scene), 0.0, 0.2)
    check_any(scene, read)
    settings, actions = graph_settings(scene), actions_fingerprint(scene, read.seen)
    steady_heading, mirror = scene.wayfarer.graph.steady_heading, scene.wayfarer.graph.mirror_clips
    motions = {}
    for clip in read.clips:
        yield Progress(0.2, f"Measuring {clip.name}")
        motions.update(clip_motions([clip]))
    clips = yield from portion(prepared_clips_steps(read.clips, steady_heading, mirror), 0.2, 0.3)
    graph = yield from portion(build_motion_graph_steps(clips, settings), 0.3, 1.0)
    return BuiltGraph(graph, actions, len(read.clips), tuple(read.problems), read.seen, motions)


def keep_built(scene, built: BuiltGraph) -> None:
    """Keep a motion graph, with its numbers, as that of the scene."""
    graph, found = built.graph, results(scene)
    found.graph, found.graph_summary, found.problem, found.unread = graph, summarize(graph), "", {}
    found.made_for = played_by(scene)
    found.made_from["graph"] = (graph_settings_fingerprint(scene), built.actions)
    found.present["graph"] = built.actions
    for name, motion in built.motions.items():
        keep_motion(scene, name, built.seen[name], motion)
    found.summary = replace(
        found.summary,
        clips=built.n_clips,
        clips_played=len({segment.clip for segment in graph.segments}),
        motion_seconds=sum(segment.duration for segment in graph.segments),
        dropped_seconds=sum(dropped.seconds for dropped in graph.dropped),
    )


@dataclass(frozen=True)
class Embedded:
    """An embedding, the shapes that it was made in, the share of the free floor that it covers, the names of obstacles
    that make no difference, and of a ground that is not flat its name, lowest and highest z (m)."""

    embedding: Embedding
    shapes: SceneShapes
    share: float
    outside: tuple[str, ...]
    uneven: tuple[str, float, float] | None


def embed_scene_steps(scene, depsgraph) -> Generator[Progress, None, Embedded]:
    """Embed the scene's motion graph; raises SceneError or EmbeddingError if that cannot be done."""
    memory = ShapeMemory()
    shapes = read_shapes(scene, depsgraph, memory)
    environment = make_environment(scene, shapes)
    outside, uneven = _outside(scene, shapes), uneven_ground(scene, shapes.ground_height, depsgraph, memory)
    settings = scene.wayfarer.embedding.to_core()
    yield Progress(0.0, "Reading the scene")
    # What did not move since the last time need not be computed again.
    steps = embed_steps(graph_of(scene), environment, settings, results(scene).whole)
    embedding = yield from portion(steps, 0.0, 0.9)
    # Counted here, because counting takes about as long as embedding.
    yield Progress(0.9, "Counting links")
    share, _ = coverage_share(embedding), embedding.n_links
    return Embedded(embedding, shapes, share, outside, uneven)


def keep_embedded(scene, embedded: Embedded) -> None:
    """Keep an embedding, with its numbers, as that of the scene."""
    embedding = embedded.embedding
    keep_embedding(scene, embedding, embedded.shapes)
    found = results(scene)
    found.summary = replace(
        found.summary,
        nodes=embedding.n_nodes,
        links=embedding.n_links,
        coverage=embedded.share,
        outside=embedded.outside,
        uneven=embedded.uneven,
    )


def _outside(scene, shapes: SceneShapes) -> tuple[str, ...]:
    """Names of the obstacles that stand so far off the ground rectangle that they make no difference."""
    settings = scene.wayfarer.environment
    low, high = np.subtract(shapes.low, settings.radius), np.add(shapes.high, settings.radius)
    names = []
    solid = settings.obstacles.all_objects if settings.obstacles else ()
    for obj in shown_objects(solid, bpy.context.view_layer):
        if obj.type not in {"MESH", "CURVE", "SURFACE", "META", "FONT"}:
            continue
        corners = np.array([tuple(obj.matrix_world @ Vector(corner)) for corner in obj.bound_box])[:, :2]
        if np.any(corners.max(axis=0) < low) or np.any(corners.min(axis=0) > high):
            names.append(obj.name)
    return tuple(names)
