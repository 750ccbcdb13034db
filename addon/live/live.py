"""Live evaluation: the map follows the scene while ``scene.wayfarer.live`` is on.

Blender tells of every change of objects, after it has evaluated them and before it draws. Where the work takes no
longer than drawing twice, it is done there and then: what was moved and the map that follows are in one picture.
Otherwise a timer works in slices, between which the window stays alive. Where a round of work takes too long to keep up
with a hand that moves an obstacle, it waits until the hand lets go.
"""

import time
from collections import deque
from statistics import median
from typing import Literal

import bpy

from ..bridge import text
from ..jobs import LongOperator
from ..properties.floor_map import CHANGE_LISTENERS
from ..render.floor import find_floor
from ..render.viewport import show_colors
from ..results.state import AT_WORK, MARK, has_pending, results
from ..scene.changes import LISTENERS, Change, Listener, is_exchanging, shape_memory, start_timer, stop_timer
from .evaluation import LiveEvaluation

FOLLOWS = 0.3
"""Seconds of work up to which the map follows every change; beyond, it waits for changes to end."""

_PATIENT_PICTURES = 2
"""What is moved waits for the map while so many pictures could be drawn; in two pictures, both come later."""

_SLICE = 0.03
_TICK = 0.0
"""Seconds of work, and of rest between two slices of it: Blender handles events and draws all the same."""

_LONGEST_SLICE = 0.1
"""Seconds of work where redrawing takes long: as much as that, so that the map does not wait for the picture."""

_LOOK = 0.05
"""Seconds between two looks at the settings, of whose changes Blender does not tell."""

_QUIET = 0.2
"""Seconds without a change after which the artist has let go, whatever the tool."""

_PATIENCE = 0.3
"""Seconds for which the floor may lag behind: after that, a change no longer sends work back to its start."""

_JOBS = ("RENDER", "OBJECT_BAKE")
"""Jobs of Blender in whose time nothing is painted but by the timer."""

_PICTURES = 5
"""Pictures whose drawing is remembered."""

_evaluations: dict[int, LiveEvaluation] = {}
_pictures: deque[float] = deque(maxlen=_PICTURES)
"""Seconds from the end of a piece of work to the end of the drawing that came after it."""

_last_change = _behind_since = _left = 0.0
_to_draw: LiveEvaluation | None = None
_painted = False
"""Whose work comes next into a picture, and whether it has painted."""


def evaluation(scene) -> LiveEvaluation:
    """The live evaluation of a scene, made when first asked for."""
    if scene.session_uid not in _evaluations:
        _evaluations[scene.session_uid] = LiveEvaluation(shape_memory(scene))
    return _evaluations[scene.session_uid]


def status(scene) -> tuple[str, Literal["NONE", "INFO", "ERROR", "TIME"]]:
    """What there is to say about live evaluation, with the name of an icon."""
    live = _evaluations.get(scene.session_uid)
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
    drawn = f", drawn after {text.time(live.drawn)}" if live.drawn else ""
    return f"Painted after {text.time(live.written)}{drawn}{', when you let go' if slow else ''}", "NONE"


# ----------------------------------------------------------------------------------------------- changes


def _changed(scene) -> None:
    global _last_change, _behind_since
    now, live = time.perf_counter(), evaluation(scene)
    if live.painted:
        _behind_since = now
    _last_change = now
    lags = now - _behind_since > _PATIENCE
    # While someone drags, changes never cease: the map follows all the same, one round after the other.
    follows = live.latency <= FOLLOWS and (lags or _is_dragging())
    live.change(restart=not follows)


def _on_change(scene, depsgraph, change: Change) -> None:
    if not scene.wayfarer.live or not change.moved:
        return
    _changed(scene)
    if not change.by_script:
        follow(scene, depsgraph)
    _start_at_once()


def follow(scene, depsgraph) -> bool:
    """Let the map follow a change that Blender has just evaluated and is about to draw, if that can be done in time;
    whether the floor was painted. Blender evaluates the floor once more before it draws.
    """
    live = evaluation(scene)
    seen, before = live.changed_at, _said(live)
    if may_work_before_drawing(scene, depsgraph.view_layer):
        live.step(scene, depsgraph, FOLLOWS)
        if _said(live) != before:
            _tag("UI")
    _expect_picture(live, live.changed_at != seen)
    return live.changed_at != seen


def may_work_before_drawing(scene, view_layer) -> bool:
    """Whether there is time for the map to follow before Blender draws, because it takes no longer than to draw twice;
    and whether nobody else is at work on what it reads and writes.
    """
    if evaluation(scene).takes > min(FOLLOWS, max(_SLICE, _PATIENT_PICTURES * drawing_takes())):
        return False
    if is_exchanging() or has_pending(scene) or results(scene).embedding is None:
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
    """The floor, if it was painted before: the first painting is a step of undo."""
    floor = find_floor(scene)
    return floor if floor is not None and MARK in floor else None


def drawing_takes() -> float:
    """Seconds that Blender takes to draw, in the median of the last pictures; 0 before the first."""
    return median(_pictures) if _pictures else 0.0


def _expect_picture(live: LiveEvaluation, painted: bool) -> None:
    """What Blender does next is to draw."""
    global _left, _to_draw, _painted
    if painted:
        _tag("WINDOW")
    _left, _to_draw, _painted = time.perf_counter(), live, painted


def _note_picture() -> None:
    """Called when the picture is there that was expected."""
    global _to_draw
    now = time.perf_counter()
    if _to_draw is not None:
        _pictures.append(now - _left)
        if _painted:
            _to_draw.drawn = now - _to_draw.changed_at
    _to_draw = None


def _on_exchange() -> None:
    """Undo and redo: the floor shows what it showed then."""
    for live in _evaluations.values():
        live.forget()
    _start_at_once()


def _on_load() -> None:
    for live in _evaluations.values():
        live.stop()
    _evaluations.clear()


def _on_map_setting(scene) -> None:
    """Without live evaluation, too, a map that is shown follows its own settings."""
    if scene.wayfarer.live:
        evaluation(scene).change()
    elif results(scene).painted is not None:
        _repaint.add(scene.session_uid)
        evaluation(scene).change()
    _start_at_once()


_repaint: set[int] = set()


# ------------------------------------------------------------------------------------------------- timer


def _start_at_once() -> None:
    """After what happens now, and the drawing that it leads to; the timer may be waiting for its next look."""
    stop_timer(_tick)
    start_timer(_tick)


def _running() -> list[str]:
    """Identifiers of the modal operators that run in any window."""
    windows = bpy.context.window_manager.windows
    return [operator.bl_idname for window in windows for operator in window.modal_operators]


def _is_dragging() -> bool:
    return any(name.startswith("TRANSFORM_OT_") for name in _running())


def is_long_work(name: str) -> bool:
    """Whether an operator, by its identifier, is one of ours that work long: it would not like the scene to change."""
    kind = getattr(bpy.types, name, None)
    return isinstance(kind, type) and issubclass(kind, LongOperator)


def _is_working(scene) -> bool:
    live = _evaluations.get(scene.session_uid)
    return live is not None and live.working


def _tag(*kinds: str) -> None:
    """Have these regions of all 3D viewports drawn anew, and not the rest of them."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type in kinds:
                        region.tag_redraw()


def _said(live: LiveEvaluation) -> tuple:
    """What the panel says of it. Where the map follows, nothing is said while work goes on: to draw that would take
    longer than the work."""
    return live.latency > FOLLOWS and live.working, live.error


def _tick() -> float | None:
    scene = bpy.context.scene
    if scene is None:
        return None
    elsewhere = time.perf_counter() - _left
    _note_picture()
    map_only = not scene.wayfarer.live
    # In this order: results that were saved are read when they are asked for first.
    if (map_only and scene.session_uid not in _repaint) or results(scene).embedding is None:
        live = _evaluations.get(scene.session_uid)
        if live is not None:
            live.stop()
        return None if map_only else _LOOK
    if any(is_long_work(name) for name in _running()):
        evaluation(scene).stop()
        return _LOOK
    live = evaluation(scene)
    if live.notice_settings(scene):
        _changed(scene)
    if live.done:
        _repaint.discard(scene.session_uid)
        return None if map_only else _LOOK
    moving = time.perf_counter() - _last_change < _QUIET
    slow = live.latency > FOLLOWS
    if (live.painted and moving) or (slow and not live.working and (moving or _is_dragging())):
        return _LOOK
    if _is_dragging() and _earlier_floor(scene) is None:
        # The step of undo would keep what is on its way.
        return _LOOK
    _work(scene, live, min(max(_SLICE, elsewhere if live.working else 0.0), _LONGEST_SLICE), map_only)
    return _TICK


def _work(scene, live: LiveEvaluation, budget: float, map_only: bool) -> None:
    """One slice of work."""
    global _left
    had_floor, before, seen = results(scene).painted is not None, _said(live), live.changed_at
    live.step(scene, bpy.context.evaluated_depsgraph_get(), budget, map_only)
    if not had_floor and results(scene).painted is not None:
        show_colors(bpy.context.screen, scene)
    if live.done or _said(live) != before:
        _tag("UI")
    _left = time.perf_counter()
    if live.changed_at != seen:
        _expect_picture(live, painted=True)


_LISTENER = Listener(changed=_on_change, exchanged=_on_exchange, closed=_on_load, opened=_start_at_once)


def register():
    LISTENERS.append(_LISTENER)
    CHANGE_LISTENERS.append(_on_map_setting)
    AT_WORK.append(_is_working)


def unregister():
    AT_WORK.remove(_is_working)
    CHANGE_LISTENERS.remove(_on_map_setting)
    LISTENERS.remove(_LISTENER)
    stop_timer(_tick)
    _on_load()
