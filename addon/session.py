"""The state that lasts between two calls from Blender, and the notification of what Blender's data goes through.

All of it is in :data:`SESSION`, by scene and by kind; another file, or switching the extension off, clears it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import bpy
from bpy.app.handlers import persistent

REMEMBERED = 3
"""Deleted scenes, painted maps and walks that undo can come back to."""

_Kept = TypeVar("_Kept")


def _ignore(*_) -> None:
    pass


@dataclass(frozen=True)
class Listener:
    """Functions to call when something happens.

    Attributes
    ----------
    changed : (scene, depsgraph, moved)
        The depsgraph was evaluated, though not in background mode; ``moved`` if an environment may be another one now.
    map_changed : (scene)
        A setting of the map was changed by hand.
    exchanging, exchanged : ()
        Undo or redo begins, and has come to its end.
    closed, opened : ()
        Another file is about to take the place of this one, and has taken it.
    is_busy : (scene) -> bool
        Return True while the scene's results are being brought up to date.
    """

    changed: Callable[..., Any] = _ignore
    map_changed: Callable[..., Any] = _ignore
    exchanging: Callable[[], None] = _ignore
    exchanged: Callable[[], None] = _ignore
    closed: Callable[[], None] = _ignore
    opened: Callable[[], None] = _ignore
    is_busy: Callable[..., Any] = _ignore


class Session:
    """Listeners, in the order of their calls, and one object of each kind for each scene; for all scenes with None."""

    def __init__(self):
        self.listeners: list[Listener] = []
        self._kept: dict[int, dict[type, Any]] = {}

    def of(self, scene, kind: type[_Kept]) -> _Kept:
        """Return the scene's object of a kind, made when first asked for."""
        kept = self._kept.get(scene.session_uid if scene is not None else 0, {})
        if kind not in kept:
            self.put(scene, kind())
            return self.of(scene, kind)
        return kept[kind]

    def put(self, scene, value) -> None:
        """Make a value that of its kind of the scene."""
        uid = scene.session_uid if scene is not None else 0
        if uid not in self._kept:
            self._kept[uid] = {}
            self._forget_deleted()
        self._kept[uid][type(value)] = value

    def known(self, scene, kind: type[_Kept]) -> _Kept | None:
        """Return the scene's object of a kind if there is one."""
        return self._kept.get(scene.session_uid, {}).get(kind)

    def all(self, kind: type[_Kept]) -> list[_Kept]:
        """Return the objects of a kind of all scenes."""
        return [kept[kind] for kept in self._kept.values() if kind in kept]

    def clear(self) -> None:
        """Forget everything but the listeners."""
        self._kept.clear()

    def _forget_deleted(self) -> None:
        present = {0, *(scene.session_uid for scene in bpy.data.scenes)}
        gone = [uid for uid in self._kept if uid not in present]
        for uid in gone[:-REMEMBERED]:
            del self._kept[uid]


SESSION = Session()


def start_timer(tick: Callable[[], float | None], seconds: float = 0.0) -> None:
    """Have Blender call ``tick`` after so many seconds, and no earlier; there are no timers in background mode."""
    stop_timer(tick)
    if not bpy.app.background:
        bpy.app.timers.register(tick, first_interval=seconds)


def stop_timer(tick: Callable[[], float | None]) -> None:
    """Have Blender not call ``tick`` any more."""
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)


def redraw(*regions: str) -> None:
    """Have all 3D viewports drawn anew, or only their regions of these types."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if not regions or region.type in regions:
                        region.tag_redraw()


@persistent
def _before_exchange(*_) -> None:
    for listener in SESSION.listeners:
        listener.exchanging()


@persistent
def _after_exchange(*_) -> None:
    for listener in SESSION.listeners:
        listener.exchanged()


@persistent
def _before_load(*_) -> None:
    for listener in SESSION.listeners:
        listener.closed()
    SESSION.clear()


@persistent
def _after_load(*_) -> None:
    for listener in SESSION.listeners:
        listener.opened()


_HANDLERS = (
    ("undo_pre", _before_exchange),
    ("redo_pre", _before_exchange),
    ("undo_post", _after_exchange),
    ("redo_post", _after_exchange),
    ("load_pre", _before_load),
    ("load_post", _after_load),
)


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    SESSION.clear()
