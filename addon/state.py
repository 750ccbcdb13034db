"""What has been computed for each scene, and whether it still fits the scene.

Results are values of the core; they are kept in memory, not in the file, and never refer to Blender's data: scenes are
known by their session id. A result is *stale* when what it was made from has changed since: settings, keys of actions,
the shape or place of obstacles. That is decided by fingerprints of what goes into the work. Those of settings are
cheap and always fresh; those of actions and meshes are taken anew in a window only after Blender has told of a change
and things have come to rest, so that dragging an obstacle stays fluid and drawing a panel computes nothing.
"""

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
from .examination import ClipHealth
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
from .render.contact_strip import ContactShares

_SETTLED = 0.25
"""Seconds without a further change after which fingerprints are taken anew."""


@dataclass
class SceneResults:
    """The results of one scene; None where there is none (yet).

    ``made_from`` holds, for graph and embedding, the fingerprints of settings and of data that they were made from;
    ``present`` those of the data as last seen. ``painted`` is the embedding whose map the floor shows, with the name
    of the quantity. ``ground_height`` is the world z (m) of the embedding's ground. ``summary`` holds the numbers that
    the panels show, ``graph_summary`` what there is to say about the graph, ``lost_links`` an embedding and the links
    that it lost.

    ``health`` and ``contacts`` are what was found out about single actions, by the fingerprint of the action and of
    the settings: whoever undoes a change finds again what was known before it. ``actions`` are the fingerprints of
    actions as last seen, by name.
    """

    health: dict[tuple[str, str], ClipHealth] = field(default_factory=dict)
    contacts: dict[tuple[str, str], ContactShares] = field(default_factory=dict)
    actions: dict[str, str] = field(default_factory=dict)
    graph: MotionGraph | None = None
    graph_summary: GraphSummary | None = None
    embedding: Embedding | None = None
    lost_links: tuple[Embedding, LostLinks] | None = None
    painted: tuple[Embedding, str] | None = None
    walk: Walk | None = None
    ground_height: float = 0.0
    made_from: dict[str, tuple[str, str]] = field(default_factory=dict)
    present: dict[str, str] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)


_by_scene: dict[int, SceneResults] = {}


def results(scene) -> SceneResults:
    """The results of a scene, empty at first."""
    return _by_scene.setdefault(scene.session_uid, SceneResults())


def keep_health(scene, action: str, seen: str, health: ClipHealth) -> None:
    """Keep what was found in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.health[seen, doctor_settings_fingerprint(scene)] = health
    found.actions[action] = seen


def keep_contacts(scene, action: str, seen: str, shares: ContactShares) -> None:
    """Keep for how long the feet are planted in the action of this name, of fingerprint ``seen``."""
    found = results(scene)
    found.contacts[seen, contacts_fingerprint(scene)] = shares
    found.actions[action] = seen


def health_of(scene, action) -> ClipHealth | None:
    """What was found in an action; None if it was not examined, or not since it or the settings have changed."""
    return results(scene).health.get((_seen(scene, action), doctor_settings_fingerprint(scene)))


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
    found.graph, found.graph_summary = graph, summarize(graph)
    found.made_from["graph"] = (graph_settings_fingerprint(scene), actions)
    found.present["graph"] = actions


def keep_embedding(scene, embedding: Embedding, shapes: SceneShapes) -> None:
    """Keep an embedding made in these shapes."""
    found = results(scene)
    found.embedding, found.ground_height = embedding, shapes.ground_height
    found.made_from["embedding"] = (environment_settings_fingerprint(scene), shapes.fingerprint)
    found.present["embedding"] = shapes.fingerprint


def graph_is_stale(scene) -> bool:
    """Whether the motion graph was made from other settings or actions than the scene's."""
    found = results(scene)
    if found.graph is None:
        return False
    present = _present(scene, "graph")
    return found.made_from["graph"] != (graph_settings_fingerprint(scene), present)


def embedding_is_stale(scene) -> bool:
    """Whether the embedding was made from another graph, other settings or another environment."""
    found = results(scene)
    if found.embedding is None:
        return False
    if found.embedding.graph is not found.graph or graph_is_stale(scene):
        return True
    present = _present(scene, "embedding")
    return found.made_from["embedding"] != (environment_settings_fingerprint(scene), present)


def map_is_stale(scene) -> bool:
    """Whether the floor shows another embedding, or another quantity, than it should."""
    found = results(scene)
    if found.painted is None:
        return False
    embedding, quantity = found.painted
    other = embedding is not found.embedding or quantity != scene.wayfarer.map.quantity
    return other or embedding_is_stale(scene)


def walk_is_stale(scene) -> bool:
    """Whether the walk was made in another embedding."""
    found = results(scene)
    if found.walk is None:
        return False
    return found.walk.embedding is not found.embedding or embedding_is_stale(scene)


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


def _settle() -> None:
    """Timer: the changes have come to an end."""
    scene = bpy.context.scene
    if scene.session_uid in _by_scene:
        _look(scene)
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
def _on_load(*_) -> None:
    _by_scene.clear()


_HANDLERS = (
    ("depsgraph_update_post", _on_change),
    ("undo_post", _on_change),
    ("redo_post", _on_change),
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
