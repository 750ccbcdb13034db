"""What a scene asks a walk to be, as plain values: read at once, so that no data of Blender's is held meanwhile."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...core.errors import WalkError
from ...core.motion.graph import MotionGraph
from ...core.motion.mirror import MIRRORED
from ...core.playback.weighted import ByGoodness, Evenly, PerClip, Weighting, by_variability, uniform
from ..properties.walk import (
    FACING,
    TO_A_TARGET,
    ActionKind,
    WalkFacing,
    WalkStart,
    WalkStyle,
    WalkTarget,
)
from ..properties.walk_weighting import WalkWeighting
from ..results.state import embedding_of
from .curve_points import curve_points

Place = tuple[float, float]

_AXES = {
    WalkFacing.X: (1.0, 0.0, 0.0),
    WalkFacing.Y: (0.0, 1.0, 0.0),
    WalkFacing.NEGATIVE_X: (-1.0, 0.0, 0.0),
    WalkFacing.NEGATIVE_Y: (0.0, -1.0, 0.0),
}


@dataclass(frozen=True)
class WalkRequest:
    """A walk that is asked for.

    Attributes
    ----------
    style : WalkStyle
    seed : int
    duration : float
        Seconds; of styles that arrive somewhere, only if they wander on.
    weighting : Weighting
    start : world x, y (m) or None for anywhere
    goals : (name, place) of every place to go to, in their order
    nearness : float
        Metres.
    heading : float or None
        Radians: which way to face at the last goal; None for any.
    heading_tolerance : float
        Radians.
    curve : (n, 2) float array or None
        World x, y (m) of the polyline to follow.
    width : float
        Metres to either side of the curve.
    action : (ActionKind, name) of what is performed
    walk_on : bool
        Wander on after arriving.
    """

    style: WalkStyle
    seed: int
    duration: float
    weighting: Weighting = uniform
    start: Place | None = None
    goals: tuple[tuple[str, Place], ...] = ()
    nearness: float = 0.0
    heading: float | None = None
    heading_tolerance: float = 0.0
    curve: np.ndarray | None = None
    width: float = 0.5
    action: tuple[ActionKind, str] = (ActionKind.CLIP, "")
    walk_on: bool = False


def walk_problem(context) -> str:
    """What the settings lack for a walk of their style, as a sentence without its full stop; empty if nothing."""
    settings = context.scene.wayfarer.walk
    style = WalkStyle[settings.style]
    if style is not WalkStyle.CURVE:
        if WalkStart[settings.start] is WalkStart.ACTIVE_OBJECT and context.active_object is None:
            return "There is no active object to start at; select one, or start anywhere"
        if WalkStart[settings.start] is WalkStart.OBJECT and settings.start_object is None:
            return "Choose the object to start from first"
    if style in TO_A_TARGET and WalkTarget[settings.target] is WalkTarget.OBJECT and settings.target_object is None:
        return "Choose the object to go to first"
    if style is WalkStyle.WAYPOINTS:
        if settings.waypoints is None:
            return "Choose a collection of waypoints first"
        if not settings.waypoints.all_objects:
            return f"The collection '{settings.waypoints.name}' has no objects to pass; add some"
    if style is WalkStyle.CURVE and settings.path_curve is None:
        return "Choose a curve to follow first"
    if style is WalkStyle.PERFORM:
        kind = ActionKind[settings.action_kind]
        if not (settings.action_clip if kind is ActionKind.CLIP else settings.action_tag).strip():
            return f"Choose the {kind.value} to perform first"
    return ""


def read_request(context) -> WalkRequest:
    """What the scene's settings ask for; WalkError if they lack something, or the curve is none."""
    problem = walk_problem(context)
    if problem:
        raise WalkError(f"{problem}.")
    scene, settings = context.scene, context.scene.wayfarer.walk
    style = WalkStyle[settings.style]
    goals, frame = _goals(scene, settings, style)
    kind = ActionKind[settings.action_kind]
    return WalkRequest(
        style=style,
        seed=settings.seed,
        duration=settings.duration,
        weighting=read_weighting(scene, settings.weighting),
        start=_start(context, settings),
        goals=goals,
        nearness=settings.nearness,
        heading=_heading(frame, WalkFacing[settings.facing]) if style in FACING else None,
        heading_tolerance=settings.facing_tolerance,
        curve=curve_points(settings.path_curve) if style is WalkStyle.CURVE else None,
        width=settings.path_width,
        action=(kind, (settings.action_clip if kind is ActionKind.CLIP else settings.action_tag).strip()),
        walk_on=settings.walk_on,
    )


def read_weighting(scene, name: str) -> Weighting:
    """A choice of :class:`WalkWeighting`, by its name, as the core's."""
    kind = WalkWeighting[name]
    if kind is WalkWeighting.CLIPS:
        weights = {clip.action.name: clip.weight for clip in scene.wayfarer.clips if clip.action is not None}
        return PerClip(_weights_of(embedding_of(scene).graph, weights))
    return {
        WalkWeighting.LINKS: uniform,
        WalkWeighting.GOODNESS: ByGoodness(),
        WalkWeighting.VARIABILITY: by_variability,
        WalkWeighting.PLACES: Evenly(),
    }[kind]


def _weights_of(graph: MotionGraph, weights: Mapping[str, float]) -> dict[str, float]:
    """Weights of the graph's clips by those of actions: a mirrored clip weighs what its original does."""
    of_clips = {
        clip.name: weights.get(clip.name, weights.get(clip.name.removesuffix(MIRRORED))) for clip in graph.clips
    }
    return {name: weight for name, weight in of_clips.items() if weight is not None}


def _start(context, settings) -> Place | None:
    start = WalkStart[settings.start]
    if start is WalkStart.RANDOM or WalkStyle[settings.style] is WalkStyle.CURVE:
        return None
    if start is WalkStart.CURSOR:
        return _place(context.scene.cursor.matrix)
    obj = context.active_object if start is WalkStart.ACTIVE_OBJECT else settings.start_object
    return _place(obj.matrix_world)


def _goals(scene, settings, style: WalkStyle):
    """(name, place) of each goal, and the matrix of the last one."""
    if style is WalkStyle.WAYPOINTS:
        objects = sorted(settings.waypoints.all_objects, key=lambda obj: _by_number(obj.name))
        return tuple((obj.name, _place(obj.matrix_world)) for obj in objects), objects[-1].matrix_world
    if style not in TO_A_TARGET:
        return (), None
    if WalkTarget[settings.target] is WalkTarget.CURSOR:
        return (("3D Cursor", _place(scene.cursor.matrix)),), scene.cursor.matrix
    obj = settings.target_object
    return ((obj.name, _place(obj.matrix_world)),), obj.matrix_world


def _heading(matrix, facing: WalkFacing) -> float | None:
    if facing is WalkFacing.ANY:
        return None
    x, y, z = np.array(matrix)[:3, :3] @ _AXES[facing]
    if np.hypot(x, y) < 1e-3 * max(abs(z), 1e-12):
        raise WalkError("The axis to face along points straight up or down; turn the object, or choose another axis.")
    return float(np.arctan2(y, x))


def _place(matrix) -> Place:
    return float(matrix.translation.x), float(matrix.translation.y)


def _by_number(name: str) -> list:
    """Sorts "Point 9" before "Point 10"."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", name)]
