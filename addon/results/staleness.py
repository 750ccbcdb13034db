"""Staleness: a result is stale when what it was made from has changed since.

That is decided by fingerprints of the character, settings, keys of actions, and shapes and places of obstacles. Those
of settings are always fresh; those of actions and shapes take their time. In a window they are taken only after Blender
has notified us of a change and things have come to rest, in slices, so that dragging an obstacle stays fluid and
drawing a panel computes nothing; in the background whenever they are asked for.
"""

from collections.abc import Generator
from dataclasses import dataclass

import bpy

from ...core.errors import MotionGraphError
from ...core.progress import Progress, finish
from ..bridge.clip_actions import character_problem
from ..jobs import Slices
from ..scene.changes import shape_memory
from ..scene.inputs import environment_settings_fingerprint, graph_settings_fingerprint, read_shapes
from ..scene.motion_fingerprint import action_fingerprint, actions_fingerprint
from ..session import SESSION, Listener, redraw, start_timer, stop_timer
from .shown import find_painted, find_walk
from .store import OutdatedWalk, SceneResults, played_by, results

NEWLY_MADE = {"graph": "The motion graph was built anew", "embedding": "The motion graph was embedded anew"}

_SETTLED = 0.25
"""Seconds without a further change after which fingerprints are taken anew."""

_SLICE = 0.02
_TICK = 0.005
"""Seconds of taking them, and of everything else between two slices of it."""


def graph_changes(scene) -> tuple[str, ...]:
    """Return what makes the motion graph stale, as sentences without their full stops."""
    found = results(scene)
    if found.graph is None:
        return ()
    character, actions = played_by(scene)
    settings, data = found.made_from["graph"]
    if character != found.made_for[0]:
        return (character_problem(scene) or "It was built for another character",)
    changes = []
    if actions != found.made_for[1]:
        changes.append("Other clips are ticked")
    elif data != _present_data(scene, "graph"):
        changes.append("Keys, tags or frame ranges of clips have changed, or the rest pose or what moves the rig has")
    if settings != graph_settings_fingerprint(scene):
        changes.append("Its settings have changed")
    return tuple(changes)


def embedding_changes(scene) -> tuple[str, ...]:
    """Return what makes the embedding stale, as sentences without their full stops."""
    found = results(scene)
    if found.embedding is None:
        return ()
    settings, data = found.made_from["embedding"]
    changes = []
    if found.embedding.graph is not found.graph:
        changes.append(NEWLY_MADE["graph"])
    elif graph_is_stale(scene):
        changes.append("The motion graph is out of date")
    if data != _present_data(scene, "embedding"):
        changes.append("Ground, obstacles or regions have moved or changed")
    if settings != environment_settings_fingerprint(scene):
        changes.append("Settings of the environment or the embedding have changed")
    return tuple(changes)


def walk_changes(scene) -> tuple[str, ...]:
    """Return what makes the walk stale, as sentences without their full stops."""
    found = results(scene)
    if found.walk is None or find_walk(scene) is None:
        return ()
    changes = changes_since_walk(found)
    return changes or (("The embedding is out of date",) if embedding_is_stale(scene) else ())


def changes_since_walk(found: SceneResults) -> tuple[str, ...]:
    """Return why the embedding is no longer the one of the walk that there is, as sentences without full stops."""
    if isinstance(found.walk, OutdatedWalk):
        return found.walk.changes
    if found.walk is None or found.walk.embedding is found.embedding:
        return ()
    walked, embedding = found.walk.embedding, found.embedding
    if embedding is None or walked.unrolling is not embedding.unrolling:
        return (NEWLY_MADE["embedding"],)
    # Pruned since, or restored: whatever could be walked may be there still.
    if any(then & ~now for then, now in zip(walked.planes, embedding.planes, strict=True)):
        return ("The embedding was pruned",)
    return ()


def graph_is_stale(scene) -> bool:
    """Return True if the motion graph was made for another character, from other settings or other actions."""
    return bool(graph_changes(scene))


def embedding_is_stale(scene) -> bool:
    """Return True if the embedding was made from another graph, other settings or another environment."""
    return bool(embedding_changes(scene))


def map_is_stale(scene) -> bool:
    """Return True if the floor shows another embedding, or another quantity, than it should."""
    found = results(scene)
    if found.painted is None or find_painted(scene) is None:
        return False
    other = found.painted.embedding is not found.embedding or found.painted.key != scene.wayfarer.map.key
    return other or embedding_is_stale(scene)


def walk_is_stale(scene) -> bool:
    """Return True if the walk was made in an embedding that is no more, or has lost nodes since."""
    return bool(walk_changes(scene))


# ------------------------------------------------------------------------------------------ fingerprints


def _present_data(scene, kind: str) -> str:
    """Return the fingerprint of what the scene's result of a kind would be made from: "graph" or "embedding"."""
    if bpy.app.background:
        finish(_graph_steps(scene) if kind == "graph" else _embedding_steps(scene))
    return results(scene).present[kind]


def present_action(scene, action) -> str:
    """Return the fingerprint of an action; empty if none was ever taken."""
    found = results(scene)
    if bpy.app.background and action.name in found.actions:
        found.actions[action.name] = action_fingerprint(scene, action)
    return found.actions.get(action.name, "")


def _look_steps(scene) -> Generator[Progress, None, None]:
    """Take the fingerprints of the scene's shapes and actions."""
    yield from _embedding_steps(scene)
    yield from _graph_steps(scene)


def _embedding_steps(scene) -> Generator[Progress, None, None]:
    """Take the fingerprint of the scene's shapes."""
    found = results(scene)
    if found.embedding is not None:
        try:
            shapes = read_shapes(scene, bpy.context.evaluated_depsgraph_get(), shape_memory(scene)).fingerprint
        except MotionGraphError as error:
            # The ground is gone, or a region is: whatever the embedding was made from, it was not this.
            shapes = str(error)
        found.present["embedding"] = shapes
        yield Progress(0.0, "Reading shapes")


def _graph_steps(scene) -> Generator[Progress, None, None]:
    """Take the fingerprints of the scene's actions, one between two yields: hundreds of them take seconds. The one that
    plays comes first.
    """
    found, character = results(scene), scene.wayfarer.character
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


_LISTENER = Listener(changed=look_again, exchanged=look_again)


def register():
    SESSION.listeners.append(_LISTENER)


def unregister():
    stop_timer(_settle)
    SESSION.listeners.remove(_LISTENER)
