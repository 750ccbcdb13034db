"""The scene's embedding, pruned and whole again, as maps, walks and questions use it.

The scene's settings hold the mark of the pruned embedding in use, so that undo and redo change it, too.
"""

from dataclasses import replace

import bpy

from ...core.embedding.embedding import Embedding
from ...core.evaluation.size import EmbeddingSize
from ...core.evaluation.variability import coverage_share
from ...core.tuning.pruning import Pruning
from ..properties.floor_map import map_changed
from ..session import SESSION, Listener, redraw
from .findings import mark_of
from .store import has_pending, results

_REMEMBERED = 3
"""Pruned embeddings that redo can come back to."""


def keep_pruning(scene, pruning: Pruning) -> None:
    """Make a pruned embedding that of the scene; the whole one is kept."""
    found = results(scene)
    if pruning.pruned is pruning.whole:
        scene.wayfarer.tuning.pruned = ""
        _use(scene, pruning.whole, pruning.whole, pruning.before)
        return
    found.prunings = [*found.prunings, pruning][-_REMEMBERED:]
    scene.wayfarer.tuning.pruned = mark_of(pruning.pruned)
    _use(scene, pruning.pruned, pruning.whole, pruning.after)


def restore_whole(scene) -> None:
    """Make the whole embedding that of the scene again."""
    pruning = results(scene).pruning
    if pruning is not None:
        scene.wayfarer.tuning.pruned = ""
        _use(scene, pruning.whole, pruning.whole, pruning.before)


def _use(scene, embedding: Embedding, whole: Embedding, size: EmbeddingSize) -> None:
    found = results(scene)
    found.embedding = embedding
    share = coverage_share(embedding, whole)
    found.summary = replace(found.summary, nodes=size.nodes, links=size.links, coverage=share)
    # No change of Blender's data: the painted map follows when it is notified.
    map_changed(scene.wayfarer.map, None)


def _on_exchange() -> None:
    """Note undo or redo: the settings say which embedding the scene has."""
    for scene in bpy.data.scenes:
        if scene.library is not None or has_pending(scene):
            continue
        found, wanted = results(scene), scene.wayfarer.tuning.pruned
        if not wanted and found.pruning is not None:
            _use(scene, found.pruning.whole, found.pruning.whole, found.pruning.before)
        elif wanted:
            for pruning in found.prunings:
                if pruning.whole is found.whole and mark_of(pruning.pruned) == wanted:
                    _use(scene, pruning.pruned, pruning.whole, pruning.after)
                    break
    redraw()


_LISTENER = Listener(exchanged=_on_exchange)


def register():
    SESSION.listeners.append(_LISTENER)


def unregister():
    SESSION.listeners.remove(_LISTENER)
