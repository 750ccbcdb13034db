"""A walk as the scene asks for it, in plain values: read at once, so that no data of Blender's is held meanwhile."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...core.errors import WalkError
from ...core.motion.graph import MotionGraph
from ...core.motion.mirror import MIRRORED
from ...core.playback.styles import Place, WalkRequest
from ...core.playback.walk_motion import MotionRequest
from ...core.playback.weighted import ByGoodness, Evenly, PerClip, Weighting, by_variability, uniform
from ..bridge.clip_actions import bake_problem
from ..results.store import embedding_of
from .curve_points import curve_points

_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "NEGATIVE_X": (-1.0, 0.0, 0.0), "NEGATIVE_Y": (0.0, -1.0, 0.0)}


def walk_problem(context) -> str:
    """Return what a walk as the settings ask for it lacks, a sentence without full stop; empty if nothing."""
    settings = context.scene.wayfarer.walk
    problem = bake_problem(context.scene.wayfarer.character) if settings.output != "COPY" else ""
    if problem:
        return problem
    used = settings.chosen_style.settings
    return next(filter(None, (find(context, settings) for name, find in _PROBLEMS.items() if name in used)), "")


def read_request(context) -> WalkRequest:
    """Read what the scene's settings ask for; WalkError if they lack something, or the curve is none."""
    problem = walk_problem(context)
    if problem:
        raise WalkError(f"{problem}.")
    scene, settings = context.scene, context.scene.wayfarer.walk
    fields: dict[str, Any] = {}
    for used in settings.chosen_style.settings:
        if used in _READERS:
            fields |= _READERS[used](context, settings)
    return WalkRequest(
        settings.style,
        settings.seed,
        settings.duration,
        settings.walk_on,
        weighting=read_weighting(scene, settings.weighting),
        nearness=settings.nearness,
        smoothness=settings.smoothness,
        **fields,
    )


def read_motion_request(scene, closed: bool = False) -> MotionRequest:
    """Read how the scene's settings want motion made; ClipError if its feet are none of the character's."""
    settings = scene.wayfarer
    contacts = settings.contacts.to_core(settings.character)
    cleanup = settings.walk.cleanup_settings(contacts) if settings.walk.hold_feet else None
    return MotionRequest(settings.walk.synthesis_settings(), cleanup, contacts, closed)


def read_weighting(scene, name: str) -> Weighting:
    """Return the core's weighting for an item of ``WEIGHTING_ITEMS``."""
    if name == "CLIPS":
        weights = {clip.action.name: clip.weight for clip in scene.wayfarer.clips if clip.action is not None}
        return PerClip(_weights_of(embedding_of(scene).graph, weights))
    return {"LINKS": uniform, "GOODNESS": ByGoodness(), "VARIABILITY": by_variability, "PLACES": Evenly()}[name]


def _weights_of(graph: MotionGraph, weights: Mapping[str, float]) -> dict[str, float]:
    """Return weights of the graph's clips by those of actions: a mirrored clip weighs what its original does."""
    of_clips = {
        clip.name: weights.get(clip.name, weights.get(clip.name.removesuffix(MIRRORED))) for clip in graph.clips
    }
    return {name: weight for name, weight in of_clips.items() if weight is not None}


def _start_problem(context, settings) -> str:
    if settings.start == "ACTIVE_OBJECT" and context.active_object is None:
        return "There is no active object to start at; select one, or start anywhere"
    if settings.start == "OBJECT" and settings.start_object is None:
        return "Choose the object to start from first"
    return ""


def _target_problem(_, settings) -> str:
    return "Choose the object to go to first" if settings.target == "OBJECT" and settings.target_object is None else ""


def _waypoints_problem(_, settings) -> str:
    if settings.waypoints is None:
        return "Choose a collection of waypoints first"
    if not settings.waypoints.all_objects:
        return f"The collection '{settings.waypoints.name}' has no objects to pass; add some"
    return ""


def _curve_problem(_, settings) -> str:
    return "Choose a curve to follow first" if settings.path_curve is None else ""


def _action_problem(_, settings) -> str:
    clip, tag = _action(settings)
    return "" if clip or tag else f"Choose the {settings.action_kind.lower()} to perform first"


#: Functions that say, for a setting of a style, what it lacks.
_PROBLEMS = {
    "start": _start_problem,
    "target": _target_problem,
    "waypoints": _waypoints_problem,
    "curve": _curve_problem,
    "action": _action_problem,
}


def _start(context, settings) -> Place | None:
    if settings.start == "RANDOM":
        return None
    if settings.start == "CURSOR":
        return _place(context.scene.cursor.matrix)
    obj = context.active_object if settings.start == "ACTIVE_OBJECT" else settings.start_object
    return _place(obj.matrix_world)


def _goals(scene, settings) -> list[tuple[str, Any]]:
    """Return name and world matrix of each goal."""
    if "waypoints" in settings.chosen_style.settings:
        objects = sorted(settings.waypoints.all_objects, key=lambda obj: _by_number(obj.name))
    elif settings.target == "CURSOR":
        return [("3D Cursor", scene.cursor.matrix)]
    else:
        objects = [settings.target_object]
    return [(obj.name, obj.matrix_world) for obj in objects]


def _read_goals(context, settings) -> dict[str, Any]:
    return {"goals": tuple((name, _place(matrix)) for name, matrix in _goals(context.scene, settings))}


def _read_facing(context, settings) -> dict[str, Any]:
    if settings.facing == "ANY":
        return {}
    _, matrix = _goals(context.scene, settings)[-1]
    x, y, z = np.array(matrix)[:3, :3] @ _AXES[settings.facing]
    if np.hypot(x, y) < 1e-3 * max(abs(z), 1e-12):
        raise WalkError("The axis to face along points straight up or down; turn the object, or choose another axis.")
    return {"heading": float(np.arctan2(y, x)), "heading_tolerance": settings.facing_tolerance}


def _action(settings) -> tuple[str, str]:
    """Return the clip and the tag to perform, of which one is empty."""
    if settings.action_kind == "CLIP":
        return settings.action_clip.strip(), ""
    return "", settings.action_tag.strip()


#: Functions that read, for a setting of a style, fields of the request.
_READERS = {
    "start": lambda context, settings: {"start": _start(context, settings)},
    "target": _read_goals,
    "waypoints": _read_goals,
    "facing": _read_facing,
    "curve": lambda _, settings: {"curve": curve_points(settings.path_curve), "width": settings.path_width},
    "action": lambda _, settings: dict(zip(("clip", "tag"), _action(settings), strict=True)),
}


def _place(matrix) -> Place:
    return float(matrix.translation.x), float(matrix.translation.y)


def _by_number(name: str) -> list:
    """Sort "Point 9" before "Point 10"."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", name)]
