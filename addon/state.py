"""What has been computed for each scene, and whether it still fits the scene.

Results are values of the core; they are kept in memory while Blender runs (:mod:`.storage` puts them into the file when
it is saved) and never refer to Blender's data: scenes are known by their session id. A result is *stale* when what it
was made from has changed since: the character, settings, keys of actions, the shape or place of obstacles. That is
decided by fingerprints of what goes into the work. Those of settings are cheap and always fresh; those of actions and
meshes are taken anew in a window only after Blender has told of a change and things have come to rest, so that dragging
an obstacle stays fluid and drawing a panel computes nothing.

What a result left in the scene, the painted floor and the baked walk, carries a mark that says which result it shows:
whoever undoes it, or deletes it, has it no longer.
"""

import uuid
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..core.embedding.embedding import Embedding
from ..core.errors import MotionGraphError
from ..core.evaluation.why_not import LostLinks
from ..core.motion.graph import MotionGraph
from ..core.motion.graph_summary import GraphSummary, summarize
from ..core.playback.walk import Walk
from .clip_actions import character_problem
from .examination import ClipHealth, ClipMotion
from .inputs import (
    SceneShapes,
    action_fingerprint,
    actions_fingerprint,
    contacts_fingerprint,
    doctor_settings_fingerprint,
    environment_settings_fingerprint,
    graph_settings_fingerprint,
    read_shapes,
)
from .pruning import Pruning
from .render.contact_strip import ContactShares
from .render.floor import find_floor

_SETTLED = 0.25
"""Seconds without a further change after which fingerprints are taken anew."""

MARK = "wayfarer_result"
"""Custom property of the floor and of baked walks: which result they show."""

_REMEMBERED = 3
"""Painted maps and walks that undo can come back to."""

NEWLY_MADE = {"graph": "The motion graph was built anew", "embedding": "The motion graph was embedded anew"}


@dataclass
class SceneResults:
    """The results of one scene; None where there is none (yet).

    ``made_from`` holds, for graph and embedding, the fingerprints of settings and of data that they were made from;
    ``present`` those of the data as last seen; ``made_for`` the character and the actions of the graph, by session id.
    ``painted`` is the embedding whose map the floor shows, with the key of the map (``scene.wayfarer.map.key``).
    ``ground_height`` is the world z (m) of the embedding's ground. ``summary`` holds the numbers that the panels show,
    ``graph_summary`` what there is to say about the graph, ``lost_links`` an embedding and the links that it lost.
    ``marked`` are what floors and walks of late show, by their mark; ``prunings`` how embeddings were pruned of late.

    ``health`` and ``contacts`` are what was found out about single actions, by name and fingerprint of the action and
    by that of the settings: whoever undoes a change finds again what was known before it. ``motions`` are how far
    actions go, by fingerprint. ``actions`` are the fingerprints of actions as last seen, by name.

    ``pending`` reads results that were saved, when they are asked for first; ``problem`` says why they could not be
    read, ``unread`` are those, as they lay in the file. ``encoded`` are results as bytes, with what they were made of,
    ``stored_bytes`` what they take in the file.
    """

    health: dict[tuple[str, str, str], ClipHealth] = field(default_factory=dict)
    contacts: dict[tuple[str, str], ContactShares] = field(default_factory=dict)
    motions: dict[str, ClipMotion] = field(default_factory=dict)
    actions: dict[str, str] = field(default_factory=dict)
    graph: MotionGraph | None = None
    graph_summary: GraphSummary | None = None
    embedding: Embedding | None = None
    lost_links: tuple[Embedding, LostLinks] | None = None
    painted: tuple[Embedding, str] | None = None
    walk: Walk | None = None
    ground_height: float = 0.0
    made_for: tuple[int, tuple[int, ...]] = (0, ())
    made_from: dict[str, tuple[str, str]] = field(default_factory=dict)
    present: dict[str, str] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)
    marked: dict[str, Any] = field(default_factory=dict)
    prunings: list[Pruning] = field(default_factory=list)
    pending: Callable[["SceneResults"], None] | None = None
    problem: str = ""
    unread: dict[str, Any] = field(default_factory=dict)
    encoded: dict[str, tuple[Any, bytes]] = field(default_factory=dict)
    stored_bytes: int = 0

    @property
    def pruning(self) -> Pruning | None:
        """How the embedding was pruned; None if it was not."""
        return next((pruning for pruning in self.prunings if pruning.pruned is self.embedding), None)

    @property
    def whole(self) -> Embedding | None:
        """The embedding as it was before it was pruned."""
        pruning = self.pruning
        return self.embedding if pruning is None else pruning.whole


_by_scene: dict[int, SceneResults] = {}


def results(scene) -> SceneResults:
    """The results of a scene, empty at first."""
    found = _by_scene.setdefault(scene.session_uid, SceneResults())
    if found.pending is not None:
        pending, found.pending = found.pending, None
        pending(found)
    return found


def keep_pending(scene, read: Callable[[SceneResults], None]) -> None:
    """Results of a scene that ``read`` fills in when they are asked for first."""
    _by_scene[scene.session_uid] = SceneResults(pending=read)
    _on_change()


def has_pending(scene) -> bool:
    """Whether results were saved with the scene that nobody has asked for yet."""
    found = _by_scene.get(scene.session_uid)
    return found is not None and found.pending is not None


def has_results(scene) -> bool:
    """Whether there are results of a scene, read or not yet read."""
    found = _by_scene.get(scene.session_uid)
    return found is not None and (found.pending is not None or found.graph is not None or bool(found.problem))


def keep_health(scene, action: str, seen: str, health: ClipHealth) -> None:
    """Keep what was found in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.health[action, seen, doctor_settings_fingerprint(scene)] = health
    found.actions[action] = seen


def keep_contacts(scene, action: str, seen: str, shares: ContactShares) -> None:
    """Keep for how long the feet are planted in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.contacts[seen, contacts_fingerprint(scene)] = shares
    found.actions[action] = seen


def keep_motion(scene, action: str, seen: str, motion: ClipMotion) -> None:
    """Keep how far the character goes in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.motions[seen] = motion
    found.actions[action] = seen


def motion_of(scene, action) -> ClipMotion | None:
    """How far the character goes in an action; None if nobody has looked since it has changed."""
    return results(scene).motions.get(_seen(scene, action))


def health_of(scene, action) -> ClipHealth | None:
    """What was found in an action; None if it was not examined, or not since it or the settings have changed."""
    known = action.name, _seen(scene, action), doctor_settings_fingerprint(scene)
    return results(scene).health.get(known)


def contacts_of(scene, action) -> ContactShares | None:
    """For how long the feet are planted in an action; None as for :func:`health_of`."""
    return results(scene).contacts.get((_seen(scene, action), contacts_fingerprint(scene)))


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


def keep_painted(scene, floor, embedding: Embedding, key: str) -> None:
    """Keep that the floor object shows this map of an embedding."""
    found = results(scene)
    same = found.painted is not None and found.painted[0] is embedding and found.painted[1] == key
    # Live evaluation paints the same many times a second.
    if same and find_painted(scene) is not None:
        return
    found.painted = (embedding, key)
    _mark(found, floor, found.painted)


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
    kind = type(result[0])
    alike = [mark for mark, other in found.marked.items() if type(other[0]) is kind]
    for mark in alike[:-_REMEMBERED]:
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
    elif data != _present(scene, "graph"):
        changes.append("Keys, tags or frame ranges of clips have changed, or the rest pose has")
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
    if data != _present(scene, "embedding"):
        changes.append("Ground, obstacles or regions have moved or changed")
    if settings != environment_settings_fingerprint(scene):
        changes.append("Settings of the environment or the embedding have changed")
    return tuple(changes)


def walk_changes(scene) -> tuple[str, ...]:
    """What makes the walk stale, as sentences without their full stops."""
    found = results(scene)
    if found.walk is None or find_walk(scene) is None:
        return ()
    if found.walk.embedding is not found.embedding:
        return (NEWLY_MADE["embedding"],)
    return ("The embedding is out of date",) if embedding_is_stale(scene) else ()


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
    """Whether the walk was made in another embedding."""
    return bool(walk_changes(scene))


def _present(scene, kind: str) -> str:
    if bpy.app.background:
        _look(scene)
    return results(scene).present[kind]


def _seen(scene, action) -> str:
    found = results(scene)
    if bpy.app.background and action.name in found.actions:
        found.actions[action.name] = action_fingerprint(scene, action)
    return found.actions.get(action.name, "")


def _look(scene) -> None:
    """Take the fingerprints of the scene's actions and shapes."""
    found = results(scene)
    known = {clip.action for clip in scene.wayfarer.clips if clip.action and clip.action.name in found.actions}
    found.actions.update({action.name: action_fingerprint(scene, action) for action in known})
    if found.graph is not None:
        found.present["graph"] = actions_fingerprint(scene)
    if found.embedding is not None:
        try:
            shapes = read_shapes(scene, bpy.context.evaluated_depsgraph_get()).fingerprint
        except MotionGraphError as error:
            # The ground is gone, or a region is: whatever the embedding was made from, it was not this.
            shapes = str(error)
        found.present["embedding"] = shapes


AT_WORK: list[Callable[[Any], bool]] = []
"""Called with a scene: whether its results are being brought up to date at this moment, so that looking must wait."""


def _settle() -> float | None:
    """Timer: the changes have come to an end."""
    scene = bpy.context.scene
    if scene is None:
        return None
    if any(at_work(scene) for at_work in AT_WORK):
        return _SETTLED
    if scene.session_uid in _by_scene:
        _look(scene)
    redraw()
    return None


def redraw() -> None:
    """Have all panels drawn anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@persistent
def _on_change(*_) -> None:
    if bpy.app.background or not _by_scene:
        return
    if bpy.app.timers.is_registered(_settle):
        bpy.app.timers.unregister(_settle)
    bpy.app.timers.register(_settle, first_interval=_SETTLED)


@persistent
def _on_exchange(*_) -> None:
    """Undo and redo: what floor and walk show now is what they are marked with."""
    for scene in bpy.data.scenes:
        if scene.session_uid in _by_scene and not has_pending(scene):
            _follow_marks(scene)
    _on_change()


def _follow_marks(scene) -> None:
    found, floor = results(scene), find_floor(scene)
    found.painted = found.marked.get(floor.get(MARK)) if floor is not None else None
    character = scene.wayfarer.character
    if found.walk is None and not any(isinstance(shown[0], Walk) for shown in found.marked.values()):
        return
    walks = [action for action in bpy.data.actions if isinstance(found.marked.get(action.get(MARK), ("",))[0], Walk)]
    playing = character.animation_data.action if character and character.animation_data else None
    shown = playing if playing in walks else walks[-1] if walks else None
    found.walk = None
    if shown is not None:
        found.walk, numbers = found.marked[shown[MARK]]
        found.summary.update(numbers)


@persistent
def _on_load(*_) -> None:
    _by_scene.clear()


_HANDLERS = (
    ("depsgraph_update_post", _on_change),
    ("undo_post", _on_exchange),
    ("redo_post", _on_exchange),
    ("load_pre", _on_load),
)


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    if bpy.app.timers.is_registered(_settle):
        bpy.app.timers.unregister(_settle)
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
    _by_scene.clear()
