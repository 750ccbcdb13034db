"""The environment as the viewport shows it: made when the scene has changed, never while drawing."""

import time
from dataclasses import dataclass

import bpy
from bpy.app.handlers import persistent

from ..core.errors import MotionGraphError
from .bridge.read_scene import ShapeMemory
from .inputs import environment_settings_fingerprint, make_environment, read_shapes
from .properties.floor_map import CHANGE_LISTENERS
from .render.environment_lines import Lines, environment_lines
from .state import redraw, results

_LOOK = 0.1
"""Seconds between two looks at the settings while the environment is shown."""


@dataclass(frozen=True)
class EnvironmentView:
    """Lines to draw, the world z (m) of the ground, and what is wrong with the environment, if anything is."""

    lines: tuple[Lines, ...] = ()
    ground_height: float = 0.0
    error: str = ""


_views: dict[int, tuple[str, EnvironmentView]] = {}
_memories: dict[int, ShapeMemory] = {}
_changed = True
_next = 0.0


def environment_view(scene) -> EnvironmentView:
    """What is known of a scene's environment; empty before the first look."""
    return _views.get(scene.session_uid, ("", EnvironmentView()))[1]


def look(scene, depsgraph) -> bool:
    """Make the view of a scene anew if its shapes or settings have changed; whether they had."""
    memory = _memories.setdefault(scene.session_uid, ShapeMemory())
    settings, before = environment_settings_fingerprint(scene), _views.get(scene.session_uid)
    try:
        shapes = read_shapes(scene, depsgraph, memory)
        seen = f"{settings} {shapes.fingerprint}"
        if before is not None and before[0] == seen:
            return False
        found = results(scene)
        if found.embedding is not None and found.made_from.get("embedding") == (settings, shapes.fingerprint):
            environment = found.embedding.environment
        else:
            environment = make_environment(scene, shapes)
        view = EnvironmentView(environment_lines(environment, shapes.ground_height), shapes.ground_height)
    except MotionGraphError as error:
        seen = f"{settings} {error}"
        view = EnvironmentView(error=str(error))
    _views[scene.session_uid] = (seen, view)
    return before is None or before[0] != seen


def start() -> None:
    """Look at the scene from time to time, for as long as its environment is shown."""
    if not bpy.app.background and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=0.0)


_settings = ""


def _tick() -> float | None:
    global _changed, _settings, _next
    scene = bpy.context.scene
    if scene is None or not scene.wayfarer.overlay.show_environment:
        return None
    settings = environment_settings_fingerprint(scene)
    if not (_changed or settings != _settings) or time.perf_counter() < _next:
        return _LOOK
    _changed, _settings = False, settings
    started = time.perf_counter()
    if look(scene, bpy.context.evaluated_depsgraph_get()):
        redraw()
    # Where it takes long, it must not take more than a fifth of the time.
    _next = time.perf_counter() + 4 * (time.perf_counter() - started)
    return _LOOK


@persistent
def _on_update(scene, depsgraph) -> None:
    global _changed
    if bpy.app.background or not scene.wayfarer.overlay.show_environment:
        return
    objects = [update for update in depsgraph.updates if isinstance(update.id, bpy.types.Object)]
    if scene.session_uid in _memories:
        _memories[scene.session_uid].forget(u.id.original.session_uid for u in objects if u.is_updated_geometry)
    _changed = True
    start()


@persistent
def _on_exchange(*_) -> None:
    global _changed
    _changed = True
    _memories.clear()


@persistent
def _on_load(*_) -> None:
    _views.clear()
    _on_exchange()


@persistent
def _after_load(*_) -> None:
    start()


def _on_setting(_) -> None:
    start()


_HANDLERS = (
    ("depsgraph_update_post", _on_update),
    ("undo_post", _on_exchange),
    ("redo_post", _on_exchange),
    ("load_pre", _on_load),
    ("load_post", _after_load),
)


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    CHANGE_LISTENERS.append(_on_setting)


def unregister():
    CHANGE_LISTENERS.remove(_on_setting)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
    _on_load()
