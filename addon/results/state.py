"""What has been computed for each scene, and whether it still fits the scene.

Results are kept in memory while Blender runs (:mod:`.scene_results`; :mod:`.storage` puts them into the file when it is
saved). A result is *stale* when what it was made from has changed since: the character, settings, keys of actions, the
shape or place of obstacles. That is decided by fingerprints of what goes into the work: those of settings are always
fresh, those of actions and shapes are looked after by :mod:`.data_watch`.

What a result left in the scene, the painted floor and the baked walk, carries a mark that says which result it shows:
whoever undoes it, or deletes it, has it no longer.
"""

import uuid

import bpy

from ...core.embedding.embedding import Embedding
from ...core.evaluation.why_not import LostLinks
from ...core.motion.doctor import ClipHealth, ClipMotion
from ...core.motion.graph import MotionGraph
from ...core.motion.graph_summary import summarize
from ...core.playback.walk import Walk
from ...core.report.contact_chart import ContactShares
from ..bridge.clip_actions import character_problem
from ..properties.graph_names import SOURCE
from ..render.floor import find_floor
from ..scene.inputs import (
    SceneShapes,
    contacts_fingerprint,
    doctor_settings_fingerprint,
    environment_settings_fingerprint,
    graph_settings_fingerprint,
)
from ..session import REMEMBERED, SESSION, Listener
from .store import (
    OutdatedWalk,
    SceneResults,
    embedded_graph,
    embedding_of,
    graph_of,
    has_pending,
    has_results,
    is_walk,
    results,
    walk_of,
    whole_of,
)
from .watch import action_as_seen, data_as_seen, look_again

__all__ = [
    "MARK",
    "NEWLY_MADE",
    "OutdatedWalk",
    "SceneResults",
    "changes_since_walk",
    "contacts_of",
    "embedding_changes",
    "embedding_is_stale",
    "embedding_of",
    "find_painted",
    "find_walk",
    "graph_changes",
    "graph_is_stale",
    "graph_of",
    "has_pending",
    "has_results",
    "health_of",
    "keep_contacts",
    "keep_embedding",
    "keep_graph",
    "keep_health",
    "keep_motion",
    "keep_painted",
    "keep_walk",
    "lost_links",
    "map_is_stale",
    "motion_of",
    "played_by",
    "register",
    "results",
    "unregister",
    "walk_changes",
    "walk_is_stale",
    "walk_of",
    "whole_of",
]

MARK = "wayfarer_result"
"""Custom property of the floor and of baked walks: which result they show."""

NEWLY_MADE = {"graph": "The motion graph was built anew", "embedding": "The motion graph was embedded anew"}


def keep_health(scene, action: str, seen: str, health: ClipHealth) -> None:
    """Keep what was found in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.health[action, seen, doctor_settings_fingerprint(scene)] = health
    found.actions[action] = seen
    _keep_latest(found.health, len(found.actions))


def keep_contacts(scene, action: str, seen: str, shares: ContactShares) -> None:
    """Keep for how long the feet are planted in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.contacts[seen, contacts_fingerprint(scene)] = shares
    found.actions[action] = seen
    _keep_latest(found.contacts, len(found.actions))


def keep_motion(scene, action: str, seen: str, motion: ClipMotion) -> None:
    """Keep how far the character goes in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.motions[seen] = motion
    found.actions[action] = seen
    _keep_latest(found.motions, len(found.actions))


def _keep_latest(known: dict, n_actions: int) -> None:
    """Forget the oldest of what is known about actions, beyond what undo may come back to."""
    while len(known) > 8 * n_actions + 100:
        del known[next(iter(known))]


def motion_of(scene, action) -> ClipMotion | None:
    """How far the character goes in an action; None if nobody has looked since it has changed."""
    return results(scene).motions.get(action_as_seen(scene, action))


def health_of(scene, action) -> ClipHealth | None:
    """What was found in an action; None if it was not examined, or not since it or the settings have changed."""
    known = action.name, action_as_seen(scene, action), doctor_settings_fingerprint(scene)
    return results(scene).health.get(known)


def contacts_of(scene, action) -> ContactShares | None:
    """For how long the feet are planted in an action; None as for :func:`health_of`."""
    return results(scene).contacts.get((action_as_seen(scene, action), contacts_fingerprint(scene)))


def lost_links(scene) -> LostLinks | None:
    """The links that the scene's embedding lost, if they have been counted."""
    found = results(scene)
    if found.lost_links is None or found.lost_links[0] is not found.embedding:
        return None
    return found.lost_links[1]


def keep_graph(scene, graph: MotionGraph, actions: str) -> None:
    """Keep a motion graph made from actions with the fingerprint ``actions``."""
    found = results(scene)
    found.graph, found.graph_summary, found.problem = graph, summarize(graph), ""
    found.unread = {}
    found.made_for = played_by(scene)
    found.made_from["graph"] = (graph_settings_fingerprint(scene), actions)
    found.present["graph"] = actions


def keep_embedding(scene, embedding: Embedding, shapes: SceneShapes) -> None:
    """Keep an embedding made in these shapes."""
    found = results(scene)
    found.embedding, found.ground_height = embedding, shapes.ground_height
    # They are large, and undo does not come back to what they were made of.
    found.prunings = []
    found.made_from["embedding"] = (environment_settings_fingerprint(scene), shapes.fingerprint)
    found.present["embedding"] = shapes.fingerprint


def keep_painted(scene, floor, embedding: Embedding, key: str, in_operator: bool = False) -> None:
    """Keep that the floor object shows this map of an embedding.

    Where no operator has made the floor, to which Blender adds a step of undo by itself, one is added here: Blender may
    leave a collection as it is when it undoes what came before, and would find in it an object that is no more. What
    an existing floor shows is no step of undo.
    """
    found = results(scene)
    same = found.painted is not None and found.painted[0] is embedding and found.painted[1] == key
    # Live evaluation paints the same many times a second.
    if same and find_painted(scene) is not None:
        return
    found.painted, is_new = (embedding, key), MARK not in floor
    _mark(found, floor, found.painted)
    if is_new and not in_operator:
        bpy.ops.ed.undo_push(message="Paint Map")


def keep_walk(scene, walk: Walk, action) -> None:
    """Keep a walk, baked into an action."""
    found = results(scene)
    numbers = {name: value for name, value in found.summary.items() if name.startswith("walk_")}
    found.walk = walk
    _mark(found, action, (walk, numbers))


def _mark(found: SceneResults, datablock, result) -> None:
    mark = uuid.uuid4().hex
    datablock[MARK] = mark
    found.marked[mark] = result
    alike = [mark for mark, other in found.marked.items() if is_walk(other) == is_walk(result)]
    for mark in alike[:-REMEMBERED]:
        del found.marked[mark]


def find_painted(scene):
    """The floor object, if it shows what the results say; else None."""
    found, floor = results(scene), find_floor(scene)
    if floor is None or found.painted is None:
        return None
    return floor if found.marked.get(floor.get(MARK)) is found.painted else None


def find_walk(scene) -> bpy.types.Action | None:
    """The action that the walk was baked into, if it is still there."""
    found = results(scene)
    for action in bpy.data.actions if found.walk is not None else ():
        marked = found.marked.get(action.get(MARK))
        if marked is not None and marked[0] is found.walk:
            return action
    return None


def played_by(scene) -> tuple[int, tuple[int, ...]]:
    """Session ids of the scene's character, 0 if it cannot be used, and of the actions in use."""
    settings = scene.wayfarer
    character = 0 if character_problem(scene) else settings.character.session_uid
    return character, tuple(sorted(action.session_uid for action in settings.used_actions()))


def graph_changes(scene) -> tuple[str, ...]:
    """What makes the motion graph stale, as sentences without their full stops."""
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
    elif data != data_as_seen(scene, "graph"):
        changes.append("Keys, tags or frame ranges of clips have changed, or the rest pose or what moves the rig has")
    if settings != graph_settings_fingerprint(scene):
        changes.append("Its settings have changed")
    return tuple(changes)


def embedding_changes(scene) -> tuple[str, ...]:
    """What makes the embedding stale, as sentences without their full stops."""
    found = results(scene)
    if found.embedding is None:
        return ()
    settings, data = found.made_from["embedding"]
    changes = []
    if found.embedding.graph is not found.graph:
        changes.append(NEWLY_MADE["graph"])
    elif graph_is_stale(scene):
        changes.append("The motion graph is out of date")
    if data != data_as_seen(scene, "embedding"):
        changes.append("Ground, obstacles or regions have moved or changed")
    if settings != environment_settings_fingerprint(scene):
        changes.append("Settings of the environment or the embedding have changed")
    return tuple(changes)


def walk_changes(scene) -> tuple[str, ...]:
    """What makes the walk stale, as sentences without their full stops."""
    found = results(scene)
    if found.walk is None or find_walk(scene) is None:
        return ()
    changes = changes_since_walk(found)
    return changes or (("The embedding is out of date",) if embedding_is_stale(scene) else ())


def changes_since_walk(found: SceneResults) -> tuple[str, ...]:
    """Why the embedding is no longer the one of the walk that there is, as sentences without their full stops."""
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
    """Whether the motion graph was made for another character, from other settings or other actions."""
    return bool(graph_changes(scene))


def embedding_is_stale(scene) -> bool:
    """Whether the embedding was made from another graph, other settings or another environment."""
    return bool(embedding_changes(scene))


def map_is_stale(scene) -> bool:
    """Whether the floor shows another embedding, or another quantity, than it should."""
    found = results(scene)
    if found.painted is None or find_painted(scene) is None:
        return False
    embedding, key = found.painted
    other = embedding is not found.embedding or key != scene.wayfarer.map.key
    return other or embedding_is_stale(scene)


def walk_is_stale(scene) -> bool:
    """Whether the walk was made in an embedding that is no more, or has lost nodes since."""
    return bool(walk_changes(scene))


def _on_exchange() -> None:
    """Note undo or redo: what floor and walk show now is what they are marked with."""
    for scene in bpy.data.scenes:
        if SESSION.known(scene, SceneResults) is not None and not has_pending(scene):
            _follow_marks(scene)
    look_again()


def _follow_marks(scene) -> None:
    found, floor = results(scene), find_floor(scene)
    found.painted = found.marked.get(floor.get(MARK)) if floor is not None else None
    character = scene.wayfarer.character
    if found.walk is None and not any(map(is_walk, found.marked.values())):
        return
    walks = [action for action in bpy.data.actions if is_walk(found.marked.get(action.get(MARK), ("",)))]
    playing = character.animation_data.action if character and character.animation_data else None
    shown = playing if playing in walks else walks[-1] if walks else None
    found.walk = None
    if shown is not None:
        found.walk, numbers = found.marked[shown[MARK]]
        found.summary.update(numbers)


_LISTENER = Listener(exchanged=_on_exchange)


def register():
    SOURCE.graph_of = embedded_graph
    SESSION.listeners.append(_LISTENER)


def unregister():
    SESSION.listeners.remove(_LISTENER)
    SOURCE.clear()
