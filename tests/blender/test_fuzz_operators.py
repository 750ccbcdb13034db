"""Whatever an artist does, in whatever order: no error but a reported sentence, nothing left behind, nothing stale
shown as fresh.

Random steps on a small sample, the same every time. WAYFARER_FUZZ=20 takes twenty times as many, WAYFARER_FUZZ_SEED
others.
"""

import os
import sys
import time
from collections import Counter
from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon import state
from bl_ext.user_default.wayfarer.addon.bridge.write_colors import painted_colors
from bl_ext.user_default.wayfarer.addon.inputs import make_environment, read_shapes
from bl_ext.user_default.wayfarer.addon.workflow import build_graph_steps
from bl_ext.user_default.wayfarer.core.embedding.embedding import embed
from bl_ext.user_default.wayfarer.core.progress import finish
from tests.blender.artist import Artist
from tests.blender.registered import is_ours

EPISODE = 75
"""Steps after which the sample is opened again: so much has been deleted by then."""

N_EPISODES = 2 * int(os.environ.get("WAYFARER_FUZZ", "1"))
SEED = int(os.environ.get("WAYFARER_FUZZ_SEED", "0"))

PILED = 60
"""Datablocks that our operators may add in an episode: floors, curves of walks, crowds, charts, materials."""

MEGABYTES = 400
"""By which Blender may grow over all episodes: it keeps what undo needs, and forgets it with the file."""

PURPOSEFUL = {"add_sample_room", "apply_remedy", "append_actions"}
"""They add to the file because that is what they are for."""


def datablocks() -> dict[str, int]:
    """How many there are of each kind, but for those that windows come with."""
    left_out = {"screens", "workspaces", "window_managers", "brushes", "palettes", "libraries"}
    kinds = (name for name in dir(bpy.data) if name not in left_out)
    found = {kind: getattr(bpy.data, kind) for kind in kinds}
    return {kind: len(blocks) for kind, blocks in found.items() if isinstance(blocks, bpy.types.bpy_prop_collection)}


def orphans() -> set[str]:
    """What nobody uses, and nobody wants to be kept."""
    kinds = ("meshes", "curves", "armatures", "materials", "actions", "objects")
    return {f"{kind} {block.name}" for kind in kinds for block in getattr(bpy.data, kind) if block.users == 0}


def our_handlers() -> int:
    lists = (getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers))
    return sum(is_ours(function) for functions in lists if isinstance(functions, list) for function in functions)


def megabytes() -> float:
    """What the process takes of the machine's memory; 0 where that is not known."""
    status = Path("/proc/self/statm")
    return int(status.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6 if status.exists() else 0.0


def assert_fresh_is_fresh() -> set[str]:
    """What is not called stale is what comes out when everything is computed anew, from scratch; what that was."""
    scene = bpy.context.scene
    found = state.results(scene)
    if found.graph is None or state.graph_is_stale(scene):
        return set()
    graph = finish(build_graph_steps(scene)).graph
    assert graph.links.tolist() == found.graph.links.tolist(), "a stale motion graph is shown as fresh"
    for new, old in zip(graph.segments, found.graph.segments, strict=True):
        # Not to the last bit: where the character stands makes no difference but in rounding.
        np.testing.assert_allclose(new.path, old.path, 1e-5, 1e-5, err_msg="a stale motion graph is shown as fresh")
    if found.embedding is None or state.embedding_is_stale(scene):
        return {"graph"}
    environment = make_environment(scene, read_shapes(scene, bpy.context.evaluated_depsgraph_get()))
    embedding = embed(found.graph, environment, scene.wayfarer.embedding.to_core())
    whole = found.whole
    assert (embedding.n_nodes, embedding.planes) == (whole.n_nodes, whole.planes), "a stale embedding is shown as fresh"
    fresh = {"graph", "embedding"}
    floor = state.find_painted(scene)
    if floor is not None and not state.map_is_stale(scene) and floor.mode == "OBJECT":
        wanted = scene.wayfarer.map
        painted = finish(wanted.kind.paint_steps(found.embedding, wanted.to_core()))
        np.testing.assert_allclose(
            painted_colors(floor), painted.colors, atol=1e-6, err_msg="a stale map is shown as fresh"
        )
        fresh.add("painted")
    if state.find_walk(scene) is not None and not state.walk_is_stale(scene):
        x, y, heading, segment = (found.walk.states % found.embedding.shape).T
        assert found.embedding.node_mask()[x, y, heading, segment].all(), "a stale walk is shown as fresh"
        fresh.add("walk")
    return fresh


JUST_MADE = {
    "build_motion_graph": state.graph_is_stale,
    "embed": state.embedding_is_stale,
    "paint_map": state.map_is_stale,
    "random_walk": state.walk_is_stale,
}
"""What an operator has made is not stale, unless what it was made from is."""


def an_episode(artist: Artist, seen: Counter, capfd) -> None:
    handlers, piled = our_handlers(), Counter()
    for _ in range(EPISODE):
        counts, before = datablocks(), orphans()
        stale_before = [state.graph_is_stale(bpy.context.scene), state.embedding_is_stale(bpy.context.scene)]
        name = artist.step()
        printed = "".join(capfd.readouterr())
        assert "Traceback" not in printed, printed[printed.index("Traceback") :]
        seen[name if not artist.failed else f"{name} refused"] += 1
        if name in dir(bpy.ops.wayfarer) and name not in PURPOSEFUL:
            more = {kind: n - counts[kind] for kind, n in datablocks().items() if n != counts[kind]}
            piled.update(more)
            assert sum(piled.values()) <= PILED, f"datablocks pile up: {piled}, {more} by {name}"
            # A region lets go of its object, which someone may have removed from all scenes before.
            new = orphans() - before if name != "remove_region" else set()
            assert not new, f"{name} leaves {new} behind"
        if name in JUST_MADE and not artist.failed:
            index = list(JUST_MADE).index(name)
            made_of_stale = any(stale_before[:index])
            assert made_of_stale or not JUST_MADE[name](bpy.context.scene), f"what {name} has made is stale at once"
        assert our_handlers() == handlers, "handlers pile up"
        if artist.random.random() < 0.3:
            seen.update(f"fresh {kind}" for kind in assert_fresh_is_fresh())
    assert state.n_kept() <= len(bpy.data.scenes) + 4, "results of scenes that are gone pile up"


def test_random_steps(small_file, tmp_path, capfd):
    seen, memory = Counter(), []
    for episode in range(N_EPISODES):
        folder = tmp_path / f"Müller & Söhne {episode}"
        folder.mkdir()
        bpy.ops.wm.open_mainfile(filepath=small_file)
        bpy.ops.ed.undo_push(message="Start")
        artist, started = Artist(1000 * SEED + episode, folder), time.perf_counter()
        try:
            for name in ("build_motion_graph", "embed", "paint_map", "random_walk")[: 4 - episode % 3]:
                assert getattr(bpy.ops.wayfarer, name)("EXEC_DEFAULT", True) == {"FINISHED"}
            an_episode(artist, seen, capfd)
        except Exception as error:
            steps = "\n  ".join(artist.done)
            raise AssertionError(f"episode {episode}, after\n  {steps}\n{type(error).__name__}: {error}") from error
        memory.append(megabytes())
        with capfd.disabled():
            if N_EPISODES > 2:
                took = time.perf_counter() - started
                sys.stdout.write(f"episode {episode}: {EPISODE} steps in {took:.1f} s, {memory[-1]:.0f} MB\n")
                sys.stdout.flush()
    warm = memory[: max(len(memory) // 3, 2)]
    assert max(memory) <= max(warm) + MEGABYTES, f"memory grows: {memory}"
    # Or all of this would have tested nothing.
    enough = {"graph": N_EPISODES, "embedding": N_EPISODES, "painted": N_EPISODES // 2, "walk": N_EPISODES // 5}
    assert all(seen[f"fresh {kind}"] >= n for kind, n in enough.items()), seen
    with capfd.disabled():
        if N_EPISODES > 2:
            sys.stdout.write(f"{seen}\n")


def test_a_stale_embedding_would_be_seen(sample_settings):
    for step in ("build_motion_graph", "embed"):
        getattr(bpy.ops.wayfarer, step)()
    assert assert_fresh_is_fresh() == {"graph", "embedding"}
    scene = bpy.context.scene
    bpy.data.objects["Table"].location.x += 1
    bpy.context.view_layer.update()
    found = state.results(scene)
    # As if nobody had told of the change.
    found.made_from["embedding"] = (
        found.made_from["embedding"][0],
        read_shapes(scene, bpy.context.evaluated_depsgraph_get()).fingerprint,
    )
    with pytest.raises(AssertionError, match="stale embedding"):
        assert_fresh_is_fresh()
