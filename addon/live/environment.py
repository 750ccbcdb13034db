"""The environment as the viewport shows it: made when the scene has changed, never while drawing."""

import time
from collections.abc import Generator
from dataclasses import dataclass

import bpy

from ...core.errors import MotionGraphError
from ...core.progress import Progress, finish
from ..render.environment_lines import Lines, environment_lines
from ..results.state import redraw, results
from ..scene.changes import LISTENERS, Listener, shape_memory, start_timer, stop_timer
from ..scene.inputs import environment_settings_fingerprint, make_environment_steps, read_shapes
from .sight import windows_in_sight

_LOOK = 0.1
"""Seconds between two looks at the settings while the environment is in sight."""
_SLICE = 0.03
"""Seconds of work after which Blender has its turn, if the work can be interrupted there."""


@dataclass(frozen=True)
class EnvironmentView:
    """Lines to draw, the world z (m) of the ground, and what is wrong with the environment, if anything is."""

    lines: tuple[Lines, ...] = ()
    ground_height: float = 0.0
    error: str = ""


_views: dict[int, tuple[str, EnvironmentView]] = {}


def environment_view(scene) -> EnvironmentView:
    """What is known of a scene's environment; empty before the first look."""
    return _views.get(scene.session_uid, ("", EnvironmentView()))[1]


def keep_looking() -> None:
    """Have the views follow their scenes, for as long as an environment is in sight."""
    start_timer(_tick)


def look(scene, depsgraph) -> bool:
    """Make the view of a scene anew if its shapes or settings have changed; whether they had."""
    return finish(look_steps(scene, depsgraph))


def look_steps(scene, depsgraph) -> Generator[Progress, None, bool]:
    """The same in steps; after the first, nothing of Blender's is needed any more."""
    key, settings, memory = scene.session_uid, environment_settings_fingerprint(scene), shape_memory(scene)
    before = _views.get(key)
    try:
        shapes = read_shapes(scene, depsgraph, memory)
        seen = f"{settings} {shapes.fingerprint}"
        if before is not None and before[0] == seen:
            return False
        found = results(scene)
        if found.embedding is not None and found.made_from.get("embedding") == (settings, shapes.fingerprint):
            environment = found.embedding.environment
        else:
            environment = yield from make_environment_steps(scene, shapes, memory)
        view = EnvironmentView(environment_lines(environment, shapes.ground_height), shapes.ground_height)
    except MotionGraphError as error:
        seen = f"{settings} {error}"
        view = EnvironmentView(error=str(error))
    _views[key] = (seen, view)
    return before is None or before[0] != seen


_n_changes = 0
_looked: dict[int, tuple] = {}
_work: Generator[Progress, None, bool] | None = None
_next = 0.0


def _tick() -> float | None:
    """Look at the scenes from time to time, for as long as an environment is in sight."""
    global _work, _next
    windows = windows_in_sight()
    if not windows:
        _stop()
        return None
    started = time.perf_counter()
    if started < _next:
        return _LOOK
    if _work is None:
        _work = _next_work(windows)
    if _work is None:
        return _LOOK
    try:
        # The first step at once, however long it took to get here: it reads from Blender's data, which does not last.
        next(_work)
        while time.perf_counter() - started < _SLICE:
            next(_work)
        return 0.0
    except StopIteration as end:
        _work = None
        if end.value:
            redraw()
    # Where one step takes long, it must not take more than a fifth of the time.
    _next = time.perf_counter() + 4 * (time.perf_counter() - started)
    return _LOOK


def _next_work(windows: list[bpy.types.Window]) -> Generator[Progress, None, bool] | None:
    """A look at the first scene of which something may have changed since the last."""
    for window in windows:
        scene = window.scene
        state = _state(scene)
        if _looked.get(scene.session_uid) != state:
            _looked[scene.session_uid] = state
            with bpy.context.temp_override(window=window):
                return look_steps(scene, bpy.context.evaluated_depsgraph_get())
    return None


def _state(scene) -> tuple:
    """What differs if something may have changed; of what scripts set here, Blender does not tell."""
    settings = scene.wayfarer.environment
    return (
        _n_changes,
        environment_settings_fingerprint(scene),
        *(settings.ground_source, *settings.ground_low, *settings.ground_high, settings.ground_height),
        *(block and block.session_uid for block in (settings.ground, settings.obstacles)),
        *(region.object and region.object.session_uid for region in settings.regions),
    )


def _stop() -> None:
    """Give up what is being looked at, to be looked at again."""
    global _work
    if _work is not None:
        _work = None
        _looked.clear()


def _on_change(*_) -> None:
    global _n_changes
    _n_changes += 1


def _on_load() -> None:
    _stop()
    _views.clear()
    _looked.clear()


_LISTENER = Listener(changed=_on_change, exchanged=_on_change, closed=_on_load)


def register():
    LISTENERS.append(_LISTENER)


def unregister():
    LISTENERS.remove(_LISTENER)
    stop_timer(_tick)
    _on_load()
