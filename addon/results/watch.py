"""What the data that results were made from looks like now, as fingerprints.

Those of actions and meshes take their time. In a window they are taken only after Blender has told of a change and
things have come to rest, in slices, so that dragging an obstacle stays fluid and drawing a panel computes nothing; in
the background whenever they are asked for.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ...core.errors import MotionGraphError
from ..scene.changes import LISTENERS, Listener, shape_memory
from ..scene.inputs import read_shapes
from ..scene.motion_fingerprint import action_fingerprint, actions_fingerprint
from .store import is_known, n_kept, results

_SETTLED = 0.25
"""Seconds without a further change after which fingerprints are taken anew."""

_SLICE = 0.02
_TICK = 0.005
"""Seconds of taking them, and of everything else between two slices of it."""

_END = object()


def data_as_seen(scene, kind: str) -> str:
    """The fingerprint of what the scene's result of a kind would be made from: "graph" or "embedding"."""
    if bpy.app.background:
        _look(scene)
    return results(scene).present[kind]


def action_as_seen(scene, action) -> str:
    """The fingerprint of an action; empty if nobody has looked at it."""
    found = results(scene)
    if bpy.app.background and action.name in found.actions:
        found.actions[action.name] = action_fingerprint(scene, action)
    return found.actions.get(action.name, "")


def _look(scene) -> None:
    """Take the fingerprints of the scene's actions and shapes."""
    for _ in _look_steps(scene):
        pass


def _look_steps(scene) -> Iterator[None]:
    """The same, an action between two yields: hundreds of them take seconds. What plays is looked at first."""
    found = results(scene)
    if found.embedding is not None:
        try:
            shapes = read_shapes(scene, bpy.context.evaluated_depsgraph_get(), shape_memory(scene)).fingerprint
        except MotionGraphError as error:
            # The ground is gone, or a region is: whatever the embedding was made from, it was not this.
            shapes = str(error)
        found.present["embedding"] = shapes
        yield
    character = scene.wayfarer.character
    playing = character.animation_data.action if character and character.animation_data else None
    actions = {clip.action for clip in scene.wayfarer.clips if clip.action and clip.action.name in found.actions}
    if found.graph is not None:
        actions.update(scene.wayfarer.used_actions())
    # By their ids: between two yields anything may be removed.
    order = [action.session_uid for action in sorted(actions, key=lambda action: action != playing)]
    for place, uid in enumerate(order):
        action = next((action for action in bpy.data.actions if action.session_uid == uid), None)
        if action is not None:
            found.actions[action.name] = action_fingerprint(scene, action)
        if found.graph is not None and place == 0:
            found.present["graph"] = actions_fingerprint(scene, found.actions)
        yield
    if found.graph is not None:
        found.present["graph"] = actions_fingerprint(scene, found.actions)


AT_WORK: list[Callable[[Any], bool]] = []
"""Called with a scene: whether its results are being brought up to date at this moment, so that looking must wait."""


_looking: tuple[int, Iterator[None]] | None = None
"""The scene that is being looked at, by its session id, and what is left to do."""


def _settle() -> float | None:
    """Timer: the changes have come to an end."""
    global _looking
    scene = bpy.context.scene
    if scene is None or not is_known(scene):
        _looking = None
        return None
    if any(at_work(scene) for at_work in AT_WORK):
        return _SETTLED
    if _looking is None or _looking[0] != scene.session_uid:
        _looking = scene.session_uid, _look_steps(scene)
    until = time.perf_counter() + _SLICE
    while time.perf_counter() < until:
        if _looking is None:
            # Evaluating the scene brought a change to light: that has set the timer anew.
            return None
        if next(_looking[1], _END) is _END:
            _looking = None
            redraw()
            return None
    return _TICK


def redraw() -> None:
    """Have all panels drawn anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def on_change(*_) -> None:
    """Something has changed: look anew when things have come to rest."""
    global _looking
    # Whatever was being looked at may have changed: from the start.
    _looking = None
    if bpy.app.background or not n_kept():
        return
    if bpy.app.timers.is_registered(_settle):
        bpy.app.timers.unregister(_settle)
    bpy.app.timers.register(_settle, first_interval=_SETTLED)


@persistent
def _on_load(*_) -> None:
    global _looking
    _looking = None


_LISTENER = Listener(changed=on_change)


def register():
    bpy.app.handlers.load_pre.append(_on_load)
    LISTENERS.append(_LISTENER)


def unregister():
    if bpy.app.timers.is_registered(_settle):
        bpy.app.timers.unregister(_settle)
    LISTENERS.remove(_LISTENER)
    bpy.app.handlers.load_pre.remove(_on_load)
