"""Notification of what moves in a scene, and the shapes that are known until they change."""

import threading

import bpy
from bpy.app.handlers import persistent

from ..bridge.owned import OUTPUT, find_collection
from ..bridge.read_scene import ShapeMemory
from ..session import SESSION, Listener


def shape_memory(scene) -> ShapeMemory:
    """Return the shapes of a scene that are known: those that have changed since they were read are forgotten."""
    return SESSION.of(scene, ShapeMemory)


@persistent
def _on_update(scene, depsgraph) -> None:
    if not _is_shown(depsgraph):
        return
    _forget_reshaped(scene, depsgraph)
    if not bpy.app.background:
        _notify(scene, depsgraph, has_moved(scene, depsgraph))


@persistent
def _on_frame(scene, depsgraph) -> None:
    """Note another frame, for which Blender calls this handler alone: in playback, one after the other."""
    if not _is_shown(depsgraph):
        return
    _forget_reshaped(scene, depsgraph)
    if not bpy.app.background and has_moved(scene, depsgraph):
        _notify(scene, depsgraph, moved=True)


def _notify(scene, depsgraph, moved: bool) -> None:
    for listener in SESSION.listeners:
        listener.changed(scene, depsgraph, moved)


def _is_shown(depsgraph) -> bool:
    """Return False for a render, which evaluates a copy of its own, in a thread of its own."""
    return depsgraph.mode == "VIEWPORT" and threading.current_thread() is threading.main_thread()


def _forget_reshaped(scene, depsgraph) -> None:
    memory = SESSION.known(scene, ShapeMemory)
    if memory is not None:
        memory.forget(
            update.id.original.session_uid
            for update in depsgraph.updates
            if update.is_updated_geometry and isinstance(update.id, bpy.types.Object) and update.id.original is not None
        )


def has_moved(scene, depsgraph) -> bool:
    """Return True if anything may stand elsewhere, or have another shape, that an environment is made from: all but
    the objects that Wayfarer makes, and the character.
    """
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
    """Return True for the character, and a child of it; there may be many objects in the file, but few above one."""
    while isinstance(block, bpy.types.Object):
        if block == character:
            return True
        block = block.parent
    return False


def _forget_shapes() -> None:
    """Forget evaluated data, which undo and redo make anew."""
    for memory in SESSION.all(ShapeMemory):
        memory.clear()


_HANDLERS = (("depsgraph_update_post", _on_update), ("frame_change_post", _on_frame))
_LISTENER = Listener(exchanged=_forget_shapes)


def register():
    SESSION.listeners.append(_LISTENER)
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    SESSION.listeners.remove(_LISTENER)
