"""The environment as the viewport shows it: made when the scene has changed, never while drawing."""

import time
from dataclasses import dataclass

import bpy

from ..core.errors import MotionGraphError
from ..core.progress import finish
from .inputs import environment_settings_fingerprint, make_environment_steps, read_shapes
from .properties.floor_map import CHANGE_LISTENERS
from .render.environment_lines import Lines, environment_lines
from .scene_changes import LISTENERS, Listener, shape_memory, start_timer, stop_timer
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
_changed = True
_next = 0.0


def environment_view(scene) -> EnvironmentView:
    """What is known of a scene's environment; empty before the first look."""
    return _views.get(scene.session_uid, ("", EnvironmentView()))[1]


def look(scene, depsgraph) -> bool:
    """Make the view of a scene anew if its shapes or settings have changed; whether they had."""
    settings, before = environment_settings_fingerprint(scene), _views.get(scene.session_uid)
    memory = shape_memory(scene)
    try:
        shapes = read_shapes(scene, depsgraph, memory)
        seen = f"{settings} {shapes.fingerprint}"
        if before is not None and before[0] == seen:
            return False
        found = results(scene)
        if found.embedding is not None and found.made_from.get("embedding") == (settings, shapes.fingerprint):
            environment = found.embedding.environment
        else:
            environment = finish(make_environment_steps(scene, shapes, memory))
        view = EnvironmentView(environment_lines(environment, shapes.ground_height), shapes.ground_height)
    except MotionGraphError as error:
        seen = f"{settings} {error}"
        view = EnvironmentView(error=str(error))
    _views[scene.session_uid] = (seen, view)
    return before is None or before[0] != seen


_settings = ""


def _tick() -> float | None:
    """Look at the scene from time to time, for as long as its environment is shown."""
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


def _start() -> None:
    start_timer(_tick)


def _on_change(scene, *_) -> None:
    global _changed
    if scene.wayfarer.overlay.show_environment:
        _changed = True
        _start()


def _on_exchange() -> None:
    global _changed
    _changed = True


def _on_load() -> None:
    _views.clear()
    _on_exchange()


def _on_setting(_) -> None:
    _start()


_LISTENER = Listener(changed=_on_change, exchanged=_on_exchange, closed=_on_load, opened=_start)


def register():
    LISTENERS.append(_LISTENER)
    CHANGE_LISTENERS.append(_on_setting)


def unregister():
    CHANGE_LISTENERS.remove(_on_setting)
    LISTENERS.remove(_LISTENER)
    stop_timer(_tick)
    _on_load()
