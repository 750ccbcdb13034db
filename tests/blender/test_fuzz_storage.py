"""Results in a .blend that was damaged or made up: the very same results, or a sentence; nothing else ever happens.

WAYFARER_FUZZ=20 tries twenty times as many.
"""

import io
import json
import os
import zipfile

import bpy
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from bl_ext.user_default.wayfarer.addon.results import file as storage
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.core.archive import archive_to_bytes

from .saved_results import content_of, sealed

EFFORT = int(os.environ.get("WAYFARER_FUZZ", "1"))
# No shrinking: what is found is small enough, and takes long enough.
PHASES = (Phase.explicit, Phase.generate)
FUZZ = {
    "suppress_health_check": list(HealthCheck),
    "deadline": None,
    "derandomize": True,
    "database": None,
    "phases": PHASES,
}


@pytest.fixture(scope="module")
def kept(small_file) -> "Parts":
    """A scene with graph, pruned embedding, map and walk, and what a file holds of them; the scene stays open."""
    bpy.ops.wm.open_mainfile(filepath=small_file)
    bpy.context.scene.wayfarer.tuning.k = 3
    for step in ("build_motion_graph", "embed", "count_lost_links", "prune", "paint_map", "random_walk"):
        assert getattr(bpy.ops.wayfarer, step)() == {"FINISHED"}
    parts = Parts(storage.encoded_results(bpy.context.scene))
    assert {"embedding", "whole", "results"} == set(parts)
    return parts


class Parts(dict):
    """What a file holds of the results; not to be printed."""

    __repr__ = object.__repr__


@pytest.fixture(autouse=True)
def empty_scene():
    """In place of the one that opens an empty file before every test."""


def as_read(parts: dict) -> store.SceneResults:
    """What is read of parts that a file holds."""
    scene = bpy.context.scene
    scene[storage.PROPERTY] = parts
    storage.take_saved()
    return store.results(scene)


def assert_refused_or_usable(found: store.SceneResults) -> bool:
    """Whether it was read: then panels, maps and walks can work with it; else a sentence says why not."""
    scene = bpy.context.scene
    if found.problem:
        assert found.graph is None and found.embedding is None and found.walk is None and not found.marked
        assert found.problem.startswith("The results that were saved with this scene cannot be used: ")
        assert found.problem.endswith("Compute anew") and len(found.problem) < 2000, found.problem
        return False
    numbers = found.summary
    told = f"{numbers.nodes:,} {numbers.links:,} {numbers.coverage:.0%} {numbers.clips_played:,}"
    assert told and found.embedding.n_links >= 0 and found.embedding.node_mask().shape == found.embedding.shape
    assert store.lost_links(scene) is None or store.lost_links(scene).possible >= 0
    assert len(found.graph_summary.hubs(3)) > 0
    if isinstance(found.walk, store.OutdatedWalk):
        assert found.walk.changes and staleness.walk_changes(scene) in ((), found.walk.changes)
    elif found.walk is not None:
        assert np.isfinite(found.walk.root_path).all() and found.walk.duration > 0
    return True


@settings(max_examples=60 * EFFORT, **FUZZ)
@given(st.data())
def test_damaged_parts_are_refused(kept, data):
    """Cut, flipped, overwritten, left out or exchanged anywhere."""
    parts = dict(kept)
    name = data.draw(st.sampled_from(sorted(parts)))
    how = data.draw(st.sampled_from(["cut", "flip", "flip", "insert", "drop", "other type", "exchange"]))
    raw = parts[name]
    damaged = bytearray(raw if isinstance(raw, bytes) else raw.encode())
    place = data.draw(st.integers(0, len(damaged) - 1))
    if how == "cut":
        del damaged[place:]
    elif how == "flip":
        damaged[place] ^= 1 << data.draw(st.integers(0, 6))
    elif how == "insert":
        damaged[place:place] = data.draw(st.binary(min_size=1, max_size=9))
    new = bytes(damaged) if isinstance(raw, bytes) else damaged.decode(errors="ignore").replace("\0", "")
    if how == "drop":
        del parts[name]
    elif how == "other type":
        parts[name] = data.draw(st.sampled_from([1, 2.5, [1, 2], {"a": 1}, "x"]))
    elif how == "exchange":
        parts[name] = parts[data.draw(st.sampled_from(sorted(parts.keys() - {name})))]
    else:
        parts[name] = new
    assert not assert_refused_or_usable(as_read(parts)) or parts == kept, f"{how} of {name} at {place}"


SOME = st.sampled_from([None, -1, 10**400, 1e308, float("nan"), "x", "9" * 5000, [], {}, [[]], [None], True])


@settings(max_examples=60 * EFFORT, **FUZZ)
@given(st.data())
def test_made_up_headers_are_refused_or_do_no_harm(kept, data):
    """Sound by their checksum: any entry, however deep, may be missing or another."""
    header, _ = content_of(kept)
    if data.draw(st.booleans()):
        header["outdated_map"], header["outdated_walk"] = header.pop("painted"), [header.pop("walk"), "a reason"]
    place = header
    while True:
        keys = sorted(place) if isinstance(place, dict) else list(range(len(place)))
        key = data.draw(st.sampled_from(keys))
        if not isinstance(place[key], dict | list) or not place[key] or data.draw(st.booleans()):
            break
        place = place[key]
    if data.draw(st.booleans()):
        place[key] = data.draw(SOME)
    else:
        del place[key]
    assert_refused_or_usable(as_read(remade_with(kept, header)))


def remade_with(parts: dict, content) -> dict:
    """The parts with a main archive of this content."""
    return {**parts, storage.MAIN: archive_to_bytes(storage.FORMAT, content, content_of(parts)[1])}


def npy(array: np.ndarray) -> bytes:
    raw = io.BytesIO()
    np.lib.format.write_array(raw, array, allow_pickle=True)
    return raw.getvalue()


def remade(raw: bytes, changes: dict, names: dict | None = None) -> bytes:
    """An archive with members exchanged, and others under the names of ``names``."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(raw)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr((names or {}).get(name, name), changes.get(name, old.read(name)))
        for name in changes.keys() - set(old.namelist()):
            new.writestr(name, changes[name])
    return out.getvalue()


class Tripwire:
    """Says so if anybody unpickles it."""

    def __reduce__(self):
        return os.mkdir, (Tripwire.folder,)

    folder = ""


def with_header(raw: bytes, **entries) -> bytes:
    with zipfile.ZipFile(io.BytesIO(raw)) as old:
        data = old.read("header.npy")
    header = {**json.loads(data[data.index(b"\n") + 1 :]), **entries}
    return remade(raw, {"header.npy": npy(np.frombuffer(json.dumps(header).encode(), np.uint8))})


def test_hostile_archives_are_refused(kept, tmp_path):
    """Huge shapes, objects, names that are paths, members that unpack to more than there is, headers without an end."""
    Tripwire.folder = str(tmp_path / "executed")
    parts = kept
    bomb = bytes(30_000_000)
    deep = b"[" * 200_000
    objects = npy(np.array([Tripwire()], dtype=object))
    for name in ("embedding", "whole", "results"):
        raw = parts[name]
        member = {"results": "states"}.get(name, "planes")
        with zipfile.ZipFile(io.BytesIO(raw)) as old:
            arrays = json.loads(old.read("header.npy").split(b"\n", 1)[1])["arrays"]
        hostile = {
            "huge": with_header(raw, arrays={**arrays, member: ["<i8", [10**14]]}),
            "huge and empty": with_header(raw, arrays={**arrays, member: ["<i8", [0, 10**14]]}),
            "many dimensions": with_header(raw, arrays={**arrays, member: ["<i8", [1] * 100]}),
            "objects": with_header(raw, arrays={**arrays, member: ["|O", [1]]}),
            "pickled": remade(raw, {f"{member}.npy": objects, "header.npy": objects}),
            "path": with_header(raw, arrays={**arrays, "../../etc/passwd": ["|u1", [4]]}),
            "renamed": remade(raw, {}, {f"{member}.npy": f"../{member}.npy", "header.npy": "/header.npy"}),
            "bomb": remade(raw, {f"{member}.npy": bomb}),
            "header bomb": remade(raw, {"header.npy": bomb}),
            "deep": remade(raw, {"header.npy": npy(np.frombuffer(deep, np.uint8))}),
            "no archive": b"PK\x05\x06" + bytes(18),
            "nothing": b"",
        }
        for how, made_up in hostile.items():
            changed = {**parts, name: made_up}
            found = as_read(changed if name == storage.MAIN else sealed(changed, parts))
            assert not assert_refused_or_usable(found), f"{name}: {how}"
    for content in (["["] * 1000, {"parts": 10**400}, float("nan"), "x", [], {"summary": "1"}):
        assert not assert_refused_or_usable(as_read(remade_with(parts, content))), content
    assert not os.path.exists(Tripwire.folder)
    assert assert_refused_or_usable(as_read(parts))
