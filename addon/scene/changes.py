"""Who is told of changes in a scene, and what is remembered of its shapes until they change.

Blender calls the handlers here; what they find out goes to the listeners, in the order in which they were added.
"""

import inspect
import threading
from collections.abc import Callable
from dataclasses import dataclass

import bpy
from bpy.app.handlers import persistent

from ..bridge.owned import OUTPUT, find_collection
from ..bridge.read_scene import ShapeMemory


@dataclass(frozen=True)
class Change:
    """What Blender has told of.

    Attributes
    ----------
    moved : bool
        Whether anything may stand elsewhere or have another shape that an environment is made from: not what we made,
        nor the character.
    by_script : bool
        Whether this happens in the middle of a script, or of an operator written as one, or with a change of frame: it
        may hold on to what it found before, and what takes long would take long at each of its steps, or frames.
    """

    moved: bool
    by_script: bool


def _ignore(*_) -> None:
    pass


@dataclass(frozen=True)
class Listener:
    """Functions to call: ``changed`` with scene, depsgraph and Change, but not in background mode, and with another
    frame only if something has moved; ``exchanged`` after undo and redo; ``closed`` before another file takes the place
    of this one, ``opened`` after.
    """

    changed: Callable = _ignore
    exchanged: Callable[[], None] = _ignore
    closed: Callable[[], None] = _ignore
    opened: Callable[[], None] = _ignore


LISTENERS: list[Listener] = []

_memories: dict[int, ShapeMemory] = {}
_exchanging = False


def shape_memory(scene) -> ShapeMemory:
    """The shapes of a scene that are known: what has changed since they were read has been forgotten."""
    return _memories.setdefault(scene.session_uid, ShapeMemory())


def is_exchanging() -> bool:
    """Whether undo or redo is in the middle of exchanging Blender's data."""
    return _exchanging


def start_timer(tick: Callable[[], float | None], seconds: float = 0.0) -> None:
    """Have Blender call ``tick`` after so many seconds; if it is to be called already, as soon as it was to be."""
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=seconds)


def stop_timer(tick: Callable[[], float | None]) -> None:
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)


@persistent
def _on_update(scene, depsgraph) -> None:
    if not _is_shown(depsgraph):
        return
    _forget_reshaped(scene, depsgraph)
    if bpy.app.background:
        return
    # Blender itself calls us from nowhere, a script through its own function.
    frame = inspect.currentframe()
    _tell(scene, depsgraph, Change(_has_moved(scene, depsgraph), frame is not None and frame.f_back is not None))


@persistent
def _on_frame(scene, depsgraph) -> None:
    """Another frame, of which Blender tells by this alone; in playback, one after the other."""
    if not _is_shown(depsgraph):
        return
    _forget_reshaped(scene, depsgraph)
    if not bpy.app.background and _has_moved(scene, depsgraph):
        _tell(scene, depsgraph, Change(moved=True, by_script=True))


def _is_shown(depsgraph) -> bool:
    """A render evaluates a copy of its own, in a thread of its own."""
    return depsgraph.mode == "VIEWPORT" and threading.current_thread() is threading.main_thread()


def _forget_reshaped(scene, depsgraph) -> None:
    if scene.session_uid in _memories:
        _memories[scene.session_uid].forget(
            update.id.original.session_uid
            for update in depsgraph.updates
            if update.is_updated_geometry and isinstance(update.id, bpy.types.Object) and update.id.original is not None
        )


def _tell(scene, depsgraph, change: Change) -> None:
    for listener in LISTENERS:
        listener.changed(scene, depsgraph, change)


def _has_moved(scene, depsgraph) -> bool:
    own, character = find_collection(scene, OUTPUT), scene.wayfarer.character
    ours = set(own.objects) if own is not None else set()
    return any(
        (update.is_updated_transform or update.is_updated_geometry)
        and isinstance(update.id, (bpy.types.Object, bpy.types.Collection, bpy.types.Scene))
        and update.id.original not in ours
        and not belongs_to(update.id.original, character)
        for update in depsgraph.updates
    )


def belongs_to(block, character) -> bool:
    """Whether this is the character, or a child of it; there may be many objects in the file, but few above one."""
    while isinstance(block, bpy.types.Object):
        if block == character:
            return True
        block = block.parent
    return False


@persistent
def _before_exchange(*_) -> None:
    global _exchanging
    _exchanging = True


@persistent
def _on_exchange(*_) -> None:
    """Undo and redo: evaluated data is made anew."""
    global _exchanging
    _exchanging = False
    for memory in _memories.values():
        memory.clear()
    for listener in LISTENERS:
        listener.exchanged()


@persistent
def _on_load(*_) -> None:
    global _exchanging
    _exchanging = False
    _memories.clear()
    for listener in LISTENERS:
        listener.closed()


@persistent
def _after_load(*_) -> None:
    for listener in LISTENERS:
        listener.opened()


_HANDLERS = (
    ("depsgraph_update_post", _on_update),
    ("frame_change_post", _on_frame),
    ("undo_pre", _before_exchange),
    ("redo_pre", _before_exchange),
    ("undo_post", _on_exchange),
    ("redo_post", _on_exchange),
    ("load_pre", _on_load),
    ("load_post", _after_load),
)


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
    _memories.clear()
