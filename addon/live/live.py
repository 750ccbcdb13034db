"""Live evaluation: the map follows the scene while ``scene.wayfarer.live`` is on.

Blender notifies us of every change of objects, after it has evaluated them and before it draws. While a hand drags, and
the work takes hardly longer than drawing, it is done there and then: what was moved and the map that follows are in one
picture. Otherwise a timer works in slices, between which the window stays alive. Where a round of work takes too
long to keep up with a hand that moves an obstacle, it waits until the hand lets go.
"""

import time
from typing import Literal

import bpy

from ...core.wording import time as spoken_time
from ..jobs import LongOperator
from ..render.floor import find_floor
from ..render.viewport import show_colors
from ..results.shown import MARK
from ..results.store import has_pending, results
from ..session import SESSION, Listener, redraw, start_timer, stop_timer
from .evaluation import LiveEvaluation

FOLLOWS = 0.3
"""Seconds of work up to which the map follows every change; beyond, it waits for changes to end."""

_BEFORE_DRAWING = 0.06
"""Seconds of work for which what is dragged waits, so that it comes into one picture with the map of it."""

_SLICE = 0.03
_TICK = 0.0
"""Seconds of work, and of rest between two slices of it: Blender handles events and draws all the same."""

_LONGEST_SLICE = 0.1
"""Seconds of work where Blender takes long in between: as much as that, so that the map does not wait for the rest."""

_LOOK = 0.05
"""Seconds between two looks at the settings, of whose changes Blender does not notify us."""

_QUIET = 0.2
"""Seconds without a change after which the artist has let go, whatever the tool."""

_JOBS = ("RENDER", "OBJECT_BAKE")
"""Jobs of Blender in whose time nothing is painted but by the timer."""


def evaluation(scene) -> LiveEvaluation:
    """Return the live evaluation of a scene, made when first asked for."""
    return SESSION.of(scene, LiveEvaluation)


def status(scene) -> tuple[str, Literal["NONE", "INFO", "ERROR", "TIME"]]:
    """Return what there is to say about live evaluation, with the name of an icon."""
    live = SESSION.known(scene, LiveEvaluation)
    if results(scene).embedding is None:
        return "Embed the motion graph first", "INFO"
    if live is None:
        return "", "NONE"
    if live.error:
        return live.error, "ERROR"
    slow = live.latency > FOLLOWS
    if slow and not live.done:
        return ("Updating" if live.working else "Updates when you let go"), "TIME"
    if not live.seconds:
        return "", "NONE"
    drawn = f", drawn after {spoken_time(live.drawn)}" if live.drawn else ""
    return f"Painted after {spoken_time(live.written)}{drawn}{', when you let go' if slow else ''}", "NONE"


# ----------------------------------------------------------------------------------------------- changes


def _on_change(scene, depsgraph, moved: bool) -> None:
    if not scene.wayfarer.live or not moved:
        return
    _changed(scene)
    # Scripts and operators may hold on to what they found before, and wait for each of their changes.
    if _is_dragging():
        follow(scene, depsgraph)
    _start_at_once()


def _changed(scene) -> None:
    live = evaluation(scene)
    # While someone drags, changes never cease: the map follows all the same, one round after the other.
    live.change(restart=live.takes > FOLLOWS)


def follow(scene, depsgraph) -> bool:
    """Let the map follow a change that Blender has just evaluated and is about to draw, if that can be done in time.

    Return True if the floor was painted. Blender evaluates the floor once more before it draws.
    """
    return may_work_before_drawing(scene, depsgraph.view_layer) and _work(scene, depsgraph, FOLLOWS)


def may_work_before_drawing(scene, view_layer) -> bool:
    """Return True if there is time for the map to follow before Blender draws, and if nobody else is at work on what it
    reads and writes.
    """
    if evaluation(scene).takes > _BEFORE_DRAWING:
        return False
    if has_pending(scene) or results(scene).embedding is None:
        return False
    if any(map(bpy.app.is_job_running, _JOBS)) or any(map(is_long_work, _running())):
        return False
    # Windows that show different things would take turns with the one floor.
    windows = bpy.context.window_manager.windows
    if any(window.scene != scene or window.view_layer != view_layer for window in windows):
        return False
    floor = _earlier_floor(scene)
    if floor is None or floor.mode != "OBJECT" or not floor.is_editable:
        return False
    return floor.data is not None and floor.data.is_editable


def _earlier_floor(scene) -> bpy.types.Object | None:
    """Return the floor if it was painted before: the first painting is a step of undo."""
    floor = find_floor(scene)
    return floor if floor is not None and MARK in floor else None


def _on_exchange() -> None:
    """Note undo or redo, before and after: the floor shows what it showed then."""
    for live in SESSION.all(LiveEvaluation):
        live.forget()
    _start_at_once()


def _on_load() -> None:
    for live in SESSION.all(LiveEvaluation):
        live.stop()


def _on_map_setting(scene) -> None:
    """Let a map that is shown follow its own settings, also without live evaluation."""
    if scene.wayfarer.live or results(scene).painted is not None:
        live = evaluation(scene)
        live.wants_map = not scene.wayfarer.live
        live.change()
    _start_at_once()


# ------------------------------------------------------------------------------------------------- timer


def _start_at_once() -> None:
    """Work after what happens now, and the drawing that it leads to; the timer may be waiting for its next look."""
    start_timer(_tick)


def _running() -> list[str]:
    """Return the identifiers of the modal operators that run in any window."""
    windows = bpy.context.window_manager.windows
    return [operator.bl_idname for window in windows for operator in window.modal_operators]


def _is_dragging() -> bool:
    return any(name.startswith("TRANSFORM_OT_") for name in _running())


def is_long_work(name: str) -> bool:
    """Return True for an operator, by its identifier, of ours that works long: the scene must not change under it."""
    kind = getattr(bpy.types, name, None)
    return isinstance(kind, type) and issubclass(kind, LongOperator)


def _is_working(scene) -> bool:
    live = SESSION.known(scene, LiveEvaluation)
    return live is not None and live.working


def _said(live: LiveEvaluation) -> tuple:
    """Return what the panel says of it. Where the map follows, nothing is said while work goes on: to draw that would
    take longer than the work."""
    return live.latency > FOLLOWS and live.working, live.error


def _tick() -> float | None:
    scene = bpy.context.scene
    if scene is None:
        return None
    map_only, live = not scene.wayfarer.live, evaluation(scene)
    live.note_picture()
    # In this order: results that were saved are read when they are asked for first.
    if (map_only and not live.wants_map) or results(scene).embedding is None:
        live.stop()
        return None if map_only else _LOOK
    if any(is_long_work(name) for name in _running()):
        live.stop()
        return _LOOK
    if live.notice_settings(scene):
        _changed(scene)
    if live.done:
        live.wants_map = False
        return None if map_only else _LOOK
    moving = time.perf_counter() - live.last_change < _QUIET
    slow = live.latency > FOLLOWS
    if (live.painted and moving) or (slow and not live.working and (moving or _is_dragging())):
        return _LOOK
    if _is_dragging() and _earlier_floor(scene) is None:
        # The step of undo would keep what is on its way.
        return _LOOK
    elsewhere = time.perf_counter() - live.left if live.working else 0.0
    budget = min(max(_SLICE, elsewhere), _LONGEST_SLICE)
    _work(scene, bpy.context.evaluated_depsgraph_get(), budget, map_only)
    return _TICK


def _work(scene, depsgraph, budget: float, map_only: bool = False) -> bool:
    """Work for some seconds; return True if the floor was painted."""
    live = evaluation(scene)
    had_floor, before, seen = results(scene).painted is not None, _said(live), live.changed_at
    live.step(scene, depsgraph, budget, map_only)
    if not had_floor and results(scene).painted is not None:
        show_colors(bpy.context.screen, scene)
    if live.done or _said(live) != before:
        redraw("UI")
    if live.changed_at != seen:
        redraw("WINDOW")
    return live.changed_at != seen


_LISTENER = Listener(
    changed=_on_change,
    map_changed=_on_map_setting,
    exchanging=_on_exchange,
    exchanged=_on_exchange,
    closed=_on_load,
    opened=_start_at_once,
    is_busy=_is_working,
)


def register():
    SESSION.listeners.append(_LISTENER)


def unregister():
    SESSION.listeners.remove(_LISTENER)
    stop_timer(_tick)
