"""Results in the .blend file, so that work goes on where it was left when the file is opened again.

They lie in the file only, never in the open scene: when a file is being saved they are written, compressed, into a
custom property of their scene, which is removed again as soon as the file is complete; when a file has been read, the
property is taken out of the scene and its bytes wait until somebody asks for the results. So they cost undo nothing,
are not copied with the scene, and come along when it is appended or linked.

The property is a group of archives: one for each graph and embedding, and one for all else, which knows the digests of
the others. What cannot be read, because it is damaged or of another version, is left out with a sentence; nothing in it
is ever executed, and every value is checked, so that whatever is read can be worked with.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ...core.archive import DAMAGE, ArchiveFormat, archive_from_bytes, archive_to_bytes, require
from ...core.embedding.archive import embedding_from_bytes, embedding_to_bytes
from ...core.embedding.embedding import Embedding
from ...core.errors import MotionGraphError
from ...core.evaluation.why_not import LostLinks
from ...core.motion.doctor import ClipMotion
from ...core.motion.graph_archive import graph_from_bytes, graph_to_bytes
from ...core.motion.graph_summary import summarize
from ...core.playback.walk import Walk
from ...core.tuning.pruning import pruning_from_plain, pruning_to_plain
from ..session import SESSION, start_timer, stop_timer
from .shown import MARK, find_painted, find_walk
from .staleness import changes_since_walk, look_again
from .store import (
    OutdatedWalk,
    SceneResults,
    ShownMap,
    ShownWalk,
    Summary,
    WalkNumbers,
    has_pending,
    played_by,
    results,
)

PROPERTY = "wayfarer_results"
"""Custom property of scenes in files: a group of bytes."""

MAIN = "results"
"""Name of the archive that holds all but graphs and embeddings."""

FORMAT = ArchiveFormat("scene results", 3, MotionGraphError)


# ------------------------------------------------------------------------------------------------ writing


def encoded_results(scene) -> dict[str, bytes] | None:
    """Return the results of a scene as they are written into the file; None if it has none."""
    found = results(scene)
    if found.graph is None:
        # What cannot be read here may be readable elsewhere: by a later version, for example.
        return found.unread or None
    content: dict[str, Any] = {
        "made_from": found.made_from,
        "made_for": [mine == now for mine, now in zip(found.made_for, played_by(scene), strict=True)],
        "summary": asdict(found.summary),
        "actions": found.actions,
        # Of actions as they are now; what undo may come back to is not kept.
        "motions": {
            seen: [found.motions[seen].distance, found.motions[seen].turn]
            for seen in sorted(found.motions.keys() & set(found.actions.values()))
        },
    }
    parts: dict[str, bytes] = {}
    arrays: dict[str, np.ndarray] = {}
    if found.embedding is None or found.embedding.graph is not found.graph:
        parts["graph"] = _encoded(found, "graph", found.graph, graph_to_bytes)
    if found.embedding is not None:
        parts["embedding"] = _encoded(found, "embedding", found.embedding, embedding_to_bytes)
        if found.pruning is not None:
            parts["whole"] = _encoded(found, "whole", found.whole, embedding_to_bytes)
            content["pruning"] = pruning_to_plain(found.pruning)
        content["ground_height"] = found.ground_height
        if found.lost_links is not None and found.lost_links[0] is found.embedding:
            content["lost_links"] = asdict(found.lost_links[1])
        floor, action = find_painted(scene), find_walk(scene)
        # Embeddings that have been replaced are not kept, only that floor and walk are out of date.
        if floor is not None and found.painted is not None:
            is_current = found.painted.embedding is found.embedding
            content["painted" if is_current else "outdated_map"] = [floor[MARK], found.painted.key]
        changes = changes_since_walk(found)
        if action is not None and changes:
            content["outdated_walk"] = [action[MARK], *changes]
        elif action is not None and isinstance(found.walk, Walk):
            content["walk"] = action[MARK]
            arrays["states"] = np.asarray(found.walk.states, np.int64)
            arrays["stencils"] = np.asarray(found.walk.stencils, np.int64)
    content["parts"] = digests(parts)
    parts[MAIN] = archive_to_bytes(FORMAT, content, arrays)
    return parts


def digests(parts: Mapping[str, bytes]) -> dict[str, str]:
    """Return the digests of all parts but the main one, by which that knows whether they belong to it."""
    return {name: hashlib.sha256(part).hexdigest() for name, part in sorted(parts.items()) if name != MAIN}


def _encoded(found: SceneResults, kind: str, value, encode) -> bytes:
    """Return the bytes of a result, made once: saving again costs nothing."""
    known = found.encoded.get(kind)
    if known is None or known[0] is not value:
        known = found.encoded[kind] = (value, encode(value))
    return known[1]


# ------------------------------------------------------------------------------------------------ reading


def decoded_results(scene, stored: dict[str, Any]) -> SceneResults:
    """Return the results that a file holds for a scene; their ``problem`` says what cannot be used."""

    def build(content, arrays) -> SceneResults:
        return _decoded(scene, stored, content, arrays)

    try:
        if "header" in stored:
            raise MotionGraphError("they were saved by an earlier version of Wayfarer.")
        found = archive_from_bytes(FORMAT, stored[MAIN], "results", build)
    except (*DAMAGE, MemoryError) as error:
        # Nothing by halves: what was read before the trouble came is of no use.
        problem = f"The results that were saved with this scene cannot be used: {_phrase(error)}. Compute anew"
        found = SceneResults(problem=problem, unread=stored)
    found.stored_bytes = stored_bytes(stored)
    return found


def _decoded(scene, stored: Mapping[str, Any], content: Mapping[str, Any], arrays) -> SceneResults:
    require(content["parts"] == digests(stored))
    found = SceneResults()
    if "embedding" in stored:
        found.embedding = embedding_from_bytes(stored["embedding"], "embedding")
        if "whole" in stored:
            whole = embedding_from_bytes(stored["whole"], "whole embedding")
            pruning = pruning_from_plain(content["pruning"], whole, found.embedding.planes)
            found.prunings, found.embedding = [pruning], pruning.pruned
            found.encoded["whole"] = (whole, stored["whole"])
        found.encoded["embedding"] = (found.embedding, stored["embedding"])
        found.ground_height = float(content["ground_height"])
    if "graph" in stored:
        graph = graph_from_bytes(stored["graph"], "motion graph")
        found.encoded["graph"] = (graph, stored["graph"])
    elif found.embedding is not None:
        graph = found.embedding.graph
    else:
        raise MotionGraphError("there is no motion graph among them.")
    found.graph, found.graph_summary = graph, summarize(graph)
    for kind in ("graph", "embedding") if found.embedding is not None else ("graph",):
        settings, data = content["made_from"][kind]
        found.made_from[kind] = (str(settings), str(data))
        # Until Blender's data has been looked at: nothing has changed since it was saved.
        found.present[kind] = str(data)
    # Session ids are of this session only; what did not fit when it was saved fits nothing.
    character, actions = played_by(scene)
    same_character, same_actions = content["made_for"]
    found.made_for = (character if same_character else -1, actions if same_actions else (-1,))
    found.summary = _summary(content["summary"])
    found.actions = {str(name): str(seen) for name, seen in content["actions"].items()}
    found.motions = {str(seen): ClipMotion(float(far), float(turn)) for seen, (far, turn) in content["motions"].items()}
    if "lost_links" in content and found.embedding is not None:
        found.lost_links = found.embedding, LostLinks(**_numbers(LostLinks, content["lost_links"]))
    for kind, embedding in (("painted", found.embedding), ("outdated_map", None)):
        if kind in content:
            mark, key = map(str, content[kind])
            found.painted = found.marked[mark] = ShownMap(embedding, key)
    if "walk" in content and found.embedding is not None:
        found.walk = _walk(found.embedding, arrays["states"], arrays["stencils"])
        found.marked[str(content["walk"])] = ShownWalk(found.walk, found.summary.walk)
    elif "outdated_walk" in content:
        mark, *changes = map(str, content["outdated_walk"])
        require(len(changes) > 0)
        found.walk = OutdatedWalk(tuple(changes))
        found.marked[mark] = ShownWalk(found.walk, found.summary.walk)
    return found


def _walk(embedding: Embedding, states: np.ndarray, stencils: np.ndarray) -> Walk:
    """Return the walk of these links; ValueError if it is none in this embedding."""
    require(states.dtype == stencils.dtype == np.int64)
    require(states.ndim == 2 and states.shape == (len(stencils) + 1, 4) and stencils.ndim == 1)
    known = embedding.unrolling.stencils
    require(len(stencils) > 0 and stencils.min() >= 0 and stencils.max() < len(known))
    # It starts on the ground and goes where its links lead.
    require(np.all(states[0] >= 0) and np.all(states[0] < embedding.shape))
    require(np.array_equal(np.diff(states[:, 0]), known.dx[stencils]))
    require(np.array_equal(np.diff(states[:, 1]), known.dy[stencils]))
    require(np.array_equal(states[:-1, 2], known.heading[stencils]))
    require(np.array_equal(states[1:, 2], known.destination_heading[stencils]))
    require(np.array_equal(states[1:, 3], known.segment[stencils]))
    return Walk(embedding, states, stencils)


def _summary(plain: Mapping) -> Summary:
    """Return the summary of a file; ValueError, or another damage, if panels cannot show it."""
    outside, uneven = tuple(plain["outside"]), plain["uneven"]
    require(all(isinstance(name, str) for name in outside))
    require(uneven is None or [*map(type, uneven)] == [str, float, float])
    return Summary(
        **_numbers(Summary, plain),
        outside=outside,
        uneven=None if uneven is None else tuple(uneven),
        walk=WalkNumbers(**_numbers(WalkNumbers, plain["walk"])),
    )


def _numbers(kind: type, plain: Mapping) -> dict[str, Any]:
    """Return the integers and floats among the fields of a dataclass; damage if one is none."""
    named = {"int": int, "float": float}
    types = {field.name: named.get(str(getattr(field.type, "__name__", field.type))) for field in fields(kind)}
    return {name: number(plain[name]) for name, number in types.items() if number is not None}


def _phrase(error: Exception) -> str:
    """Return an exception as a part of a sentence."""
    if isinstance(error, MotionGraphError):
        return str(error).rstrip(".")
    if isinstance(error, MemoryError):
        return "they need more memory than there is"
    return "they are damaged"


# ----------------------------------------------------------------------------------------------- handlers


@persistent
def _before_save(*_) -> None:
    # What nobody has taken out of the scenes yet is not to be lost.
    take_saved()
    for scene in bpy.data.scenes:
        parts = encoded_results(scene) if scene.library is None and scene.wayfarer.keep_results else None
        if parts is not None:
            scene[PROPERTY] = parts
            results(scene).stored_bytes = stored_bytes(parts)


@persistent
def _after_save(*_) -> None:
    for scene in bpy.data.scenes:
        if scene.library is None and PROPERTY in scene:
            del scene[PROPERTY]


@persistent
def take_saved(*_) -> None:
    """Take results out of the scenes: after a file was opened, something was appended or linked, or the extension was
    switched on.
    """
    for scene in bpy.data.scenes:
        group = scene.get(PROPERTY)
        if group is None:
            continue
        # Of a linked scene the property cannot be removed: it is read once.
        known = SESSION.known(scene, SceneResults)
        is_read = known is not None and (known.graph is not None or bool(known.problem)) and scene.library is not None
        if not is_read and not has_pending(scene):
            _keep(scene, group)
        if scene.library is None:
            del scene[PROPERTY]


def _keep(scene, group) -> None:
    try:
        found = {str(name): group[name] for name in group.keys()}  # noqa: SIM118  (an IDPropertyGroup is no mapping)
    except (AttributeError, TypeError):
        found = {}
    # Nothing else is ours, and groups inside it are gone with it.
    stored: dict[str, Any] = {name: part for name, part in found.items() if isinstance(part, bytes | str | int | float)}
    uid = scene.session_uid

    def read() -> SceneResults:
        own = next(scene for scene in bpy.data.scenes if scene.session_uid == uid)
        return decoded_results(own, stored)

    SESSION.put(scene, SceneResults(pending=read))
    look_again()


def stored_bytes(parts: Mapping[str, Any]) -> int:
    """Return the size of parts in the file."""
    return sum(len(part) for part in parts.values() if isinstance(part, bytes | str))


_HANDLERS = (
    ("save_pre", _before_save),
    ("save_post", _after_save),
    ("save_post_fail", _after_save),
    ("load_post", take_saved),
    ("blend_import_post", take_saved),
)


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    # Switched on when a file is open already. As long as an extension registers, Blender hides its data.
    if isinstance(bpy.data, bpy.types.BlendData):
        take_saved()
    else:
        start_timer(take_saved)


def unregister():
    stop_timer(take_saved)
    # For whoever switches it on again, after an update for example.
    if isinstance(bpy.data, bpy.types.BlendData):
        _before_save()
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
