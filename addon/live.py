"""Live evaluation: the map follows the scene while ``scene.wayfarer.live`` is on.

Blender tells of every change of objects; a timer then works in slices, between which the window stays alive. Where a
round of work takes too long to keep up with a hand that moves an obstacle, it waits until the hand lets go.
"""

import time

import bpy
from bpy.app.handlers import persistent

from .jobs import LongOperator
from .live_evaluation import LiveEvaluation
from .properties.floor_map import CHANGE_LISTENERS
from .render.viewport import show_colors
from .scene_collections import OUTPUT, find_collection
from .state import AT_WORK, redraw, results

FOLLOWS = 0.3
"""Seconds of work up to which the map follows every change; beyond, it waits for changes to end."""

_SLICE = 0.03
_TICK = 0.005
"""Seconds of work, and of everything else between two slices of it."""

_LONGEST_SLICE = 0.1
"""Seconds of work where redrawing takes long: as much as that, so that the map does not wait for the picture."""

_LOOK = 0.05
"""Seconds between two looks at the settings, of whose changes Blender does not tell."""

_QUIET = 0.2
"""Seconds without a change after which the artist has let go, whatever the tool."""

_PATIENCE = 0.3
"""Seconds for which the floor may lag behind: after that, a change no longer sends work back to its start."""

_evaluations: dict[int, LiveEvaluation] = {}
_last_change = _behind_since = _left = 0.0


def evaluation(scene) -> LiveEvaluation:
    """The live evaluation of a scene, made when first asked for."""
    return _evaluations.setdefault(scene.session_uid, LiveEvaluation())


def status(scene) -> tuple[str, str]:
    """What there is to say about live evaluation, with the name of an icon."""
    live = _evaluations.get(scene.session_uid)
    if results(scene).embedding is None:
        return "Embed the motion graph first", "INFO"
    if live is None:
        return "", "NONE"
    if live.error:
        return live.error, "ERROR"
    if live.latency > FOLLOWS:
        return ("Updating" if live.working else "Updates when you let go"), "TIME"
    return (f"Follows in {live.latency:.2f} s" if live.seconds else ""), "NONE"


# ----------------------------------------------------------------------------------------------- changes


def _changed(scene, objects=()) -> None:
    global _last_change, _behind_since
    now, live = time.perf_counter(), evaluation(scene)
    if not live.waiting and not live.working:
        _behind_since = now
    _last_change = now
    lags = now - _behind_since > _PATIENCE
    # While someone drags, changes never cease: the map follows all the same, one round after the other.
    follows = live.latency <= FOLLOWS and (lags or _is_dragging())
    live.change(objects, restart=not follows)
    _start()


@persistent
def _on_update(scene, depsgraph) -> None:
    if bpy.app.background or not scene.wayfarer.live:
        return
    own = find_collection(scene, OUTPUT)
    ours = {obj.session_uid for obj in own.objects} if own is not None else set()
    ours |= {obj.data.session_uid for obj in own.objects if obj.data is not None} if own is not None else set()
    character = scene.wayfarer.character
    if character is not None:
        ours |= {obj.session_uid for obj in (character, *character.children_recursive)}
    reshaped, moved = [], False
    for update in depsgraph.updates:
        data = update.id.original
        if data.session_uid in ours or not isinstance(data, (bpy.types.Object, bpy.types.Collection, bpy.types.Scene)):
            continue
        moved |= update.is_updated_transform or update.is_updated_geometry
        if update.is_updated_geometry:
            reshaped.append(data.session_uid)
    if moved:
        _changed(scene, reshaped)


@persistent
def _on_exchange(*_) -> None:
    """Undo and redo: evaluated data is made anew, and the floor shows what it showed then."""
    for live in _evaluations.values():
        live.forget()
    if not bpy.app.background:
        _start()


@persistent
def _on_load(*_) -> None:
    for live in _evaluations.values():
        live.stop()
    _evaluations.clear()


@persistent
def _after_load(*_) -> None:
    _start()


def _on_map_setting(scene) -> None:
    """Without live evaluation, too, a map that is shown follows its own settings."""
    if results(scene).painted is not None and not scene.wayfarer.live:
        _repaint.add(scene.session_uid)
        evaluation(scene).change()
    _start()


_repaint: set[int] = set()


# ------------------------------------------------------------------------------------------------- timer


def _start() -> None:
    if not bpy.app.background and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_TICK)


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


def _shown(live: LiveEvaluation, slow: bool) -> tuple:
    """What viewport and panel show of it. Where the map follows, nothing is said while work goes on: to draw that would
    take longer than the work."""
    return slow and live.working, live.error, id(live.seconds)


def _tick() -> float | None:
    global _left
    scene = bpy.context.scene
    if scene is None:
        return None
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
    if not live.waiting and not live.working:
        _repaint.discard(scene.session_uid)
        return None if map_only else _LOOK
    slow = live.latency > FOLLOWS
    if slow and not live.working and (_is_dragging() or time.perf_counter() - _last_change < _QUIET):
        return _LOOK
    had_floor, before = results(scene).painted is not None, _shown(live, slow)
    elsewhere = time.perf_counter() - _left if live.working else 0.0
    budget = min(max(_SLICE, elsewhere), _LONGEST_SLICE)
    done = live.step(scene, bpy.context.evaluated_depsgraph_get(), budget, map_only)
    _left = time.perf_counter()
    if not had_floor and results(scene).painted is not None:
        show_colors(bpy.context.screen, scene)
    if done or _shown(live, slow) != before:
        redraw()
    return _TICK


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
    CHANGE_LISTENERS.append(_on_map_setting)
    AT_WORK.append(_is_working)


def unregister():
    AT_WORK.remove(_is_working)
    CHANGE_LISTENERS.remove(_on_map_setting)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
    _on_load()
