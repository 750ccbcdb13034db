"""What the data that results were made from looks like now, as fingerprints.

Those of actions and meshes take their time. In a window they are taken only after Blender has told of a change and
things have come to rest, in slices, so that dragging an obstacle stays fluid and drawing a panel computes nothing; in
the background whenever they are asked for.
"""

from collections.abc import Generator
from dataclasses import dataclass

import bpy

from ...core.errors import MotionGraphError
from ...core.progress import Progress, finish
from ..jobs import Slices
from ..scene.changes import shape_memory
from ..scene.inputs import read_shapes
from ..scene.motion_fingerprint import action_fingerprint, actions_fingerprint
from ..session import SESSION, Listener, redraw, start_timer, stop_timer
from .store import SceneResults, results

_SETTLED = 0.25
"""Seconds without a further change after which fingerprints are taken anew."""

_SLICE = 0.02
_TICK = 0.005
"""Seconds of taking them, and of everything else between two slices of it."""


def data_as_seen(scene, kind: str) -> str:
    """The fingerprint of what the scene's result of a kind would be made from: "graph" or "embedding"."""
    if bpy.app.background:
        finish(_look_steps(scene))
    return results(scene).present[kind]


def action_as_seen(scene, action) -> str:
    """The fingerprint of an action; empty if nobody has looked at it."""
    found = results(scene)
    if bpy.app.background and action.name in found.actions:
        found.actions[action.name] = action_fingerprint(scene, action)
    return found.actions.get(action.name, "")


def _look_steps(scene) -> Generator[Progress, None, None]:
    """Take the fingerprints of the scene's shapes and actions, one action between two yields: hundreds of them take
    seconds. What plays is looked at first.
    """
    found = results(scene)
    if found.embedding is not None:
        try:
            shapes = read_shapes(scene, bpy.context.evaluated_depsgraph_get(), shape_memory(scene)).fingerprint
        except MotionGraphError as error:
            # The ground is gone, or a region is: whatever the embedding was made from, it was not this.
            shapes = str(error)
        found.present["embedding"] = shapes
        yield Progress(0.0, "Reading shapes")
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
        yield Progress(place / len(order), "Reading actions")
    if found.graph is not None:
        found.present["graph"] = actions_fingerprint(scene, found.actions)


@dataclass
class _Looking:
    """The scene that is being looked at, by its session id, and what is left to do."""

    scene: int = 0
    work: Slices | None = None


def _settle() -> float | None:
    """Look at the scene: the changes have come to an end."""
    scene, looking = bpy.context.scene, SESSION.of(None, _Looking)
    if scene is None or SESSION.known(scene, SceneResults) is None:
        return None
    if any(listener.is_busy(scene) for listener in SESSION.listeners):
        return _SETTLED
    work = looking.work
    if work is None or looking.scene != scene.session_uid:
        work = looking.work = Slices(_look_steps(scene))
        looking.scene = scene.session_uid
    is_done = work.advance(_SLICE)
    if looking.work is not work:
        # Evaluating the scene brought a change to light: that has set the timer anew.
        return None
    if is_done:
        looking.work = None
        redraw()
    return None if is_done else _TICK


def look_again(*_) -> None:
    """Look anew when things have come to rest, from the start: something has changed."""
    SESSION.of(None, _Looking).work = None
    if SESSION.all(SceneResults):
        start_timer(_settle, _SETTLED)


_LISTENER = Listener(changed=look_again)


def register():
    SESSION.listeners.append(_LISTENER)


def unregister():
    stop_timer(_settle)
    SESSION.listeners.remove(_LISTENER)
