"""Results in the .blend file, so that work goes on where it was left when the file is opened again.

They lie in the file only, never in the open scene: when a file is being saved they are written, compressed, into a
custom property of their scene, which is removed again as soon as the file is complete; when a file has been read, the
property is taken out of the scene and its bytes wait until somebody asks for the results. So they cost undo nothing,
are not copied with the scene, and come along when it is appended or linked.

What cannot be read, because it is damaged or of a later version, is left out with a sentence; nothing in it is ever
executed. A checksum over all of it tells what was damaged; what was made up is checked part by part, so that whatever
is read can be worked with.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from numbers import Real
from typing import Any

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ...core.archive import DAMAGE, ArchiveFormat, archive_from_bytes, archive_to_bytes, require
from ...core.embedding.archive import embedding_from_bytes, embedding_to_bytes
from ...core.embedding.embedding import Embedding
from ...core.errors import MotionGraphError, WalkError
from ...core.evaluation.why_not import LostLinks
from ...core.motion.doctor import ClipMotion
from ...core.motion.graph_archive import graph_from_bytes, graph_to_bytes
from ...core.motion.graph_summary import summarize
from ...core.playback.walk import Walk
from ...core.tuning.pruning import pruning_from_plain, pruning_to_plain
from ..session import SESSION, start_timer, stop_timer
from .state import (
    MARK,
    OutdatedWalk,
    SceneResults,
    changes_since_walk,
    find_painted,
    find_walk,
    has_pending,
    has_results,
    played_by,
    results,
)
from .watch import look_again

PROPERTY = "wayfarer_results"
"""Custom property of scenes in files: a group of bytes, of one text in JSON and of their checksum."""

_VERSION = 1
_CHECKSUM = "sha256"
_WALK_FORMAT = ArchiveFormat("walk", 1, WalkError)


def keeps_results(scene) -> bool:
    """Whether the scene's results are written into its file."""
    return scene.wayfarer.keep_results


# ------------------------------------------------------------------------------------------------ writing


def encoded_results(scene) -> dict[str, bytes | str] | None:
    """The results of a scene as they are written into the file; None if it has none."""
    found = results(scene)
    if found.graph is None:
        # What cannot be read here may be readable elsewhere: by a later version, for example.
        return found.unread or None
    header = {
        "version": _VERSION,
        "made_from": found.made_from,
        "made_for": [mine == now for mine, now in zip(found.made_for, played_by(scene), strict=True)],
        "summary": found.summary,
        "actions": found.actions,
        "motions": {seen: [found.motions[seen].distance, found.motions[seen].turn] for seen in _measured(found)},
    }
    parts: dict[str, bytes | str] = {}
    if found.embedding is None or found.embedding.graph is not found.graph:
        parts["graph"] = _encoded(found, "graph", found.graph, graph_to_bytes)
    if found.embedding is not None:
        parts["embedding"] = _encoded(found, "embedding", found.embedding, embedding_to_bytes)
        if found.pruning is not None:
            parts["whole"] = _encoded(found, "whole", found.whole, embedding_to_bytes)
            header["pruning"] = pruning_to_plain(found.pruning)
        header["ground_height"] = found.ground_height
        if found.lost_links is not None and found.lost_links[0] is found.embedding:
            header["lost_links"] = asdict(found.lost_links[1])
        floor, action = find_painted(scene), find_walk(scene)
        # Embeddings that have been replaced are not kept, only that floor and walk are out of date.
        if floor is not None and found.painted is not None:
            embedding, key = found.painted
            header["painted" if embedding is found.embedding else "outdated_map"] = [floor[MARK], key]
        changes = changes_since_walk(found)
        if action is not None and changes:
            header["outdated_walk"] = [action[MARK], *changes]
        elif action is not None and isinstance(found.walk, Walk):
            parts["walk"] = _encoded(found, "walk", found.walk, walk_to_bytes)
            header["walk"] = action[MARK]
    parts["header"] = json.dumps(header, default=float)
    parts[_CHECKSUM] = checksum(parts)
    return parts


def _measured(found: SceneResults) -> list[str]:
    """Fingerprints of actions as they are now that have been measured; what undo may come back to is not kept."""
    return [seen for seen in sorted(set(found.actions.values())) if seen in found.motions]


def checksum(parts: Mapping[str, bytes | str]) -> str:
    """Of all parts but the checksum itself."""
    digest = hashlib.sha256()
    for name in sorted(parts.keys() - {_CHECKSUM}):
        part = parts[name]
        data = part if isinstance(part, bytes) else str(part).encode(errors="replace")
        digest.update(f"{name} {type(part).__name__} {len(data)} ".encode())
        digest.update(data)
    return digest.hexdigest()


def _encoded(found: SceneResults, kind: str, value, encode) -> bytes:
    """The bytes of a result, made once: saving again costs nothing."""
    known = found.encoded.get(kind)
    if known is None or known[0] is not value:
        known = found.encoded[kind] = (value, encode(value))
    return known[1]


def walk_to_bytes(walk: Walk) -> bytes:
    """The links of a walk as an .npz in memory; its embedding is not in it."""
    arrays = {"states": np.asarray(walk.states, np.int64), "stencils": np.asarray(walk.stencils, np.int64)}
    return archive_to_bytes(_WALK_FORMAT, {}, arrays)


def walk_from_bytes(raw: bytes, embedding: Embedding) -> Walk:
    """The walk of :func:`walk_to_bytes` in its embedding; WalkError if it is none."""

    def build(_, arrays) -> Walk:
        states, stencils = arrays["states"], arrays["stencils"]
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

    return archive_from_bytes(_WALK_FORMAT, raw, "walk", build)


# ------------------------------------------------------------------------------------------------ reading


def decoded_results(scene, stored: dict[str, bytes | str]) -> SceneResults:
    """Return the results that a file holds for a scene; their ``problem`` says what cannot be used."""
    size = stored_bytes(stored)
    try:
        found = SceneResults(stored_bytes=size)
        header = json.loads(stored["header"])
        if header["version"] > _VERSION:
            raise WalkError("they were saved by a later version of Wayfarer; update the extension")
        if stored[_CHECKSUM] != checksum(stored):
            raise WalkError("they are damaged: their checksum does not match")
        _decode(scene, stored, header, found)
        return found
    except (*DAMAGE, MemoryError) as error:
        # Nothing by halves: what was filled in before the trouble came is of no use.
        problem = f"The results that were saved with this scene cannot be used: {_phrase(error)}. Compute anew"
        return SceneResults(problem=problem, unread=stored, stored_bytes=size)


def _decode(scene, stored, header, found: SceneResults) -> None:
    if "embedding" in stored:
        found.embedding = embedding_from_bytes(stored["embedding"], "embedding")
        if "whole" in stored:
            whole = embedding_from_bytes(stored["whole"], "whole embedding")
            pruning = pruning_from_plain(header["pruning"], whole, found.embedding.planes)
            found.prunings, found.embedding = [pruning], pruning.pruned
            found.encoded["whole"] = (whole, stored["whole"])
        found.encoded["embedding"] = (found.embedding, stored["embedding"])
        found.ground_height = float(header["ground_height"])
    if "graph" in stored:
        graph = graph_from_bytes(stored["graph"], "motion graph")
        found.encoded["graph"] = (graph, stored["graph"])
    elif found.embedding is not None:
        graph = found.embedding.graph
    else:
        raise WalkError("there is no motion graph among them")
    found.graph, found.graph_summary = graph, summarize(graph)
    kinds = ("graph", "embedding") if found.embedding is not None else ("graph",)
    for kind in kinds:
        settings, data = header["made_from"][kind]
        found.made_from[kind] = (str(settings), str(data))
        # Until Blender's data has been looked at: nothing has changed since it was saved.
        found.present[kind] = str(data)
    # Session ids are of this session only; what did not fit when it was saved fits nothing.
    character, actions = played_by(scene)
    same_character, same_actions = header["made_for"]
    found.made_for = (character if same_character else -1, actions if same_actions else (-1,))
    found.summary = _summary(header["summary"], header, found)
    found.actions = {str(name): str(seen) for name, seen in header["actions"].items()}
    found.motions = {str(seen): ClipMotion(float(far), float(turn)) for seen, (far, turn) in header["motions"].items()}
    if "lost_links" in header:
        found.lost_links = found.embedding, LostLinks(**_numbers(header["lost_links"]))
    for kind, embedding in (("painted", found.embedding), ("outdated_map", None)):
        if kind in header:
            mark, key = map(str, header[kind])
            found.painted = found.marked[mark] = (embedding, key)
    numbers = {name: value for name, value in found.summary.items() if name.startswith("walk_")}
    if "walk" in header and found.embedding is not None:
        found.walk = walk_from_bytes(stored["walk"], found.embedding)
        found.encoded["walk"] = (found.walk, stored["walk"])
        found.marked[str(header["walk"])] = (found.walk, numbers)
    elif "outdated_walk" in header:
        mark, *changes = map(str, header["outdated_walk"])
        require(len(changes) > 0)
        found.walk = OutdatedWalk(tuple(changes))
        found.marked[mark] = (found.walk, numbers)


#: Numbers that panels show beside a graph, an embedding and a walk: where there is one, they are there.
_SUMMARY = {
    "graph": ("clips", "clips_played", "motion_seconds", "dropped_seconds"),
    "embedding": ("nodes", "links", "coverage"),
    "walk": ("walk_seconds", "walk_length", "walk_segments"),
}


def _summary(plain: Mapping, header: Mapping, found: SceneResults) -> dict:
    """The summary of a header, if panels can show it."""
    kinds = [kind for kind in _SUMMARY if getattr(found, kind) is not None or {kind, f"outdated_{kind}"} & set(header)]
    _numbers({name: plain[name] for kind in kinds for name in _SUMMARY[kind]})
    require(all(isinstance(name, str) for name in plain.get("outside", [])))
    require([*map(type, plain.get("uneven", []))] in ([], [str, float, float]))
    return dict(plain)


def _numbers(plain: Mapping) -> dict:
    """The same; ValueError if anything but numbers is in it."""
    require(all(isinstance(value, Real) for value in plain.values()))
    return dict(plain)


def _phrase(error: Exception) -> str:
    """An exception as a part of a sentence."""
    if isinstance(error, MotionGraphError):
        return str(error).rstrip(".")
    if isinstance(error, MemoryError):
        return "they need more memory than there is"
    return f"they are damaged ({type(error).__name__}: {error})"


# ----------------------------------------------------------------------------------------------- handlers


def _own_scenes():
    return [scene for scene in bpy.data.scenes if scene.library is None]


@persistent
def _before_save(*_) -> None:
    # What nobody has taken out of the scenes yet is not to be lost.
    find_saved()
    for scene in _own_scenes():
        if PROPERTY in scene:
            del scene[PROPERTY]
        if not keeps_results(scene):
            continue
        parts = encoded_results(scene)
        if parts is None:
            continue
        scene[PROPERTY] = parts
        results(scene).stored_bytes = stored_bytes(parts)


@persistent
def _after_save(*_) -> None:
    for scene in _own_scenes():
        if PROPERTY in scene:
            del scene[PROPERTY]


@persistent
def _after_load(*_) -> None:
    """After a file was opened, and after something was appended or linked."""
    for scene in bpy.data.scenes:
        group = scene.get(PROPERTY)
        if group is None:
            continue
        # Of a linked scene the property cannot be removed: it is read once.
        known = has_pending if scene.library is None else has_results
        if not known(scene):
            _keep(scene, group)
        if scene.library is None:
            del scene[PROPERTY]


def find_saved() -> None:
    """Find what was saved with a file that was opened before the extension was switched on, or kept for then."""
    _after_load()


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


def stored_bytes(parts: dict[str, bytes | str]) -> int:
    """What parts take in the file."""
    return sum(len(part) for part in parts.values() if isinstance(part, bytes | str))


_HANDLERS = (
    ("save_pre", _before_save),
    ("save_post", _after_save),
    ("save_post_fail", _after_save),
    ("load_post", _after_load),
    ("blend_import_post", _after_load),
)


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    # Switched on when a file is open already. As long as an extension registers, Blender hides its data.
    if isinstance(bpy.data, bpy.types.BlendData):
        find_saved()
    else:
        start_timer(find_saved)


def unregister():
    stop_timer(find_saved)
    # For whoever switches it on again, after an update for example.
    if isinstance(bpy.data, bpy.types.BlendData):
        _before_save()
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
