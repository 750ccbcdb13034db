"""The painted floor and the baked walk, which results have left in the scene.

Each carries a mark that says which result it shows: whoever undoes it, or deletes it, has it no longer.
"""

import uuid
from dataclasses import replace

import bpy

from ...core.embedding.embedding import Embedding
from ...core.errors import SceneError
from ...core.maps import PaintedMap
from ...core.playback.walk import Walk
from ..render.floor import find_floor, put_on_floor
from ..session import REMEMBERED, SESSION, Listener
from .store import SceneResults, ShownMap, ShownWalk, WalkNumbers, has_pending, results

MARK = "wayfarer_result"
"""Custom property of the floor and of baked walks: which result they show."""


def paint_floor(scene, embedding: Embedding, painted: PaintedMap, key: str, offset: float, in_operator: bool = False):
    """Paint a map of the scene's embedding on its floor, and keep what the floor shows.

    ``key`` is that of the map (``scene.wayfarer.map.key``), ``offset`` the floor's height above the ground in metres.

    Where no operator makes the floor, to which Blender adds a step of undo by itself, one is added here: Blender may
    leave a collection as it is when it undoes what came before, and would find in it an object that is no more. A map
    on an existing floor is no step of undo.

    Raises SceneError if the floor is being edited, or if undo has taken it away and no operator asks for another one:
    that would come back however often it is undone, and nothing could be redone any more. Then nothing has changed.
    """
    found = results(scene)
    if not in_operator and find_floor(scene) is None and found.map_was_undone:
        raise SceneError("The painted floor was undone; redo, or paint the map again.")
    floor = put_on_floor(scene, embedding.environment.grid, found.ground_height, offset, painted)
    last = found.painted
    if last is not None and last.embedding is embedding and last.key == key and find_painted(scene) is not None:
        # Live evaluation paints the same many times a second.
        return
    found.painted, is_new = ShownMap(embedding, key, painted.numbers), MARK not in floor
    _mark(found, floor, found.painted)
    if is_new and not in_operator:
        bpy.ops.ed.undo_push(message="Paint Map")


def keep_walk(scene, walk: Walk, numbers: WalkNumbers, action) -> None:
    """Keep a walk, baked into an action."""
    found = results(scene)
    _show_walk(found, ShownWalk(walk, numbers))
    _mark(found, action, ShownWalk(walk, numbers))


def _show_walk(found: SceneResults, shown: ShownWalk) -> None:
    found.walk, found.summary = shown.walk, replace(found.summary, walk=shown.numbers)


def _mark(found: SceneResults, datablock, shown: ShownMap | ShownWalk) -> None:
    mark = uuid.uuid4().hex
    datablock[MARK] = mark
    found.marked[mark] = shown
    alike = [mark for mark, other in found.marked.items() if type(other) is type(shown)]
    for mark in alike[:-REMEMBERED]:
        del found.marked[mark]


def _shown_by(found: SceneResults, block) -> ShownMap | ShownWalk | None:
    return found.marked.get(block.get(MARK, "")) if block is not None else None


def find_painted(scene):
    """Return the floor object, if it shows what the results say; else None."""
    found, floor = results(scene), find_floor(scene)
    return floor if found.painted is not None and _shown_by(found, floor) is found.painted else None


def find_walk(scene) -> bpy.types.Action | None:
    """Return the action that the walk was baked into, if it is still there."""
    found = results(scene)
    for action in bpy.data.actions if found.walk is not None else ():
        shown = _shown_by(found, action)
        if isinstance(shown, ShownWalk) and shown.walk is found.walk:
            return action
    return None


def _on_exchange() -> None:
    """Follow undo and redo: floor and walk show what they are marked with."""
    for scene in bpy.data.scenes:
        if SESSION.known(scene, SceneResults) is not None and not has_pending(scene):
            _follow_marks(scene)


def _follow_marks(scene) -> None:
    found, character = results(scene), scene.wayfarer.character
    on_floor = _shown_by(found, find_floor(scene))
    found.painted = on_floor if isinstance(on_floor, ShownMap) else None
    if found.walk is None and not any(isinstance(shown, ShownWalk) for shown in found.marked.values()):
        return
    shown = [(action, _shown_by(found, action)) for action in bpy.data.actions]
    walks = {action: walk for action, walk in shown if isinstance(walk, ShownWalk)}
    playing = character.animation_data.action if character and character.animation_data else None
    found.walk = None
    if walks:
        _show_walk(found, walks[playing] if playing in walks else [*walks.values()][-1])


_LISTENER = Listener(exchanged=_on_exchange)


def register():
    SESSION.listeners.append(_LISTENER)


def unregister():
    SESSION.listeners.remove(_LISTENER)
