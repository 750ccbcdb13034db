"""The environment as the viewport shows it: made when the scene has changed, never while drawing."""

import time
from collections.abc import Generator
from dataclasses import dataclass, field

import bpy

from ...core.errors import MotionGraphError
from ...core.progress import Progress, finish
from ..jobs import Slices
from ..render.environment_lines import Lines, environment_lines
from ..results.store import results
from ..scene.changes import shape_memory
from ..scene.inputs import environment_settings_fingerprint, make_environment_steps, read_shapes
from ..session import SESSION, Listener, redraw, start_timer, stop_timer

_SLICE = 0.03
"""Seconds of work after which Blender has its turn, if the work can be interrupted there."""


@dataclass(frozen=True)
class EnvironmentView:
    """Lines to draw, the world z (m) of the ground, and what is wrong with the environment, if anything is."""

    lines: tuple[Lines, ...] = ()
    ground_height: float = 0.0
    error: str = ""


@dataclass
class _Look:
    """The view of one scene, the fingerprint of what it was made from, the state of the scene when it was looked at
    last, the number of its changes, and the look that has begun."""

    view: EnvironmentView = field(default_factory=EnvironmentView)
    made_from: str = ""
    state: tuple = ()
    n_changes: int = 0
    work: Slices[bool] | None = None


def environment_view(scene) -> EnvironmentView:
    """Return what is known of a scene's environment; empty before the first look."""
    return SESSION.of(scene, _Look).view


def is_in_sight(scene, area) -> bool:
    """Return True if a 3D viewport shows the environment of its scene."""
    return scene is not None and area.spaces.active.overlay.show_overlays and scene.wayfarer.overlay.show_environment


def windows_in_sight() -> list[bpy.types.Window]:
    """Return the windows in which the environment of their scene is in sight."""
    return [
        window
        for window in bpy.context.window_manager.windows
        if any(area.type == "VIEW_3D" and is_in_sight(window.scene, area) for area in window.screen.areas)
    ]


def look_soon() -> None:
    """Have the scenes in sight looked at after the drawing: whatever changes, Blender draws."""
    if not bpy.app.timers.is_registered(_tick):
        start_timer(_tick)


def look(scene, depsgraph) -> bool:
    """Make the view of a scene anew if its shapes or settings have changed; return True if they had."""
    return finish(look_steps(scene, depsgraph))


def look_steps(scene, depsgraph) -> Generator[Progress, None, bool]:
    """Look in steps; after the first, nothing of Blender's is needed any more."""
    seen, memory = SESSION.of(scene, _Look), shape_memory(scene)
    settings = environment_settings_fingerprint(scene)
    try:
        shapes = read_shapes(scene, depsgraph, memory)
        made_from = f"{settings} {shapes.fingerprint}"
        if made_from == seen.made_from:
            return False
        found = results(scene)
        if found.embedding is not None and found.made_from.get("embedding") == (settings, shapes.fingerprint):
            environment = found.embedding.environment
        else:
            environment = yield from make_environment_steps(scene, shapes, memory)
        view = EnvironmentView(environment_lines(environment, shapes.ground_height), shapes.ground_height)
    except MotionGraphError as error:
        made_from = f"{settings} {error}"
        view = EnvironmentView(error=str(error))
    is_new, seen.made_from, seen.view = made_from != seen.made_from, made_from, view
    return is_new


def _tick() -> float | None:
    """Look at the scenes in sight that may have changed since the last look."""
    started = time.perf_counter()
    for window in windows_in_sight():
        scene = window.scene
        seen = SESSION.of(scene, _Look)
        state = seen.n_changes, environment_settings_fingerprint(scene)
        if seen.work is None and seen.state == state:
            continue
        if seen.work is None:
            seen.state = state
            with bpy.context.temp_override(window=window):
                seen.work = Slices(look_steps(scene, bpy.context.evaluated_depsgraph_get()))
        # The first step at once, however long it took to get here: it reads from Blender's data, which does not last.
        if not seen.work.advance(_SLICE):
            return 0.0
        if seen.work.result:
            redraw()
        seen.work = None
        # Where one step takes long, it must not take more than a fifth of the time.
        return 4 * (time.perf_counter() - started)
    return None


def _on_change(scene, *_) -> None:
    SESSION.of(scene, _Look).n_changes += 1


def _on_exchange() -> None:
    for seen in SESSION.all(_Look):
        seen.n_changes += 1


_LISTENER = Listener(changed=_on_change, exchanged=_on_exchange)


def register():
    SESSION.listeners.append(_LISTENER)


def unregister():
    SESSION.listeners.remove(_LISTENER)
    stop_timer(_tick)
