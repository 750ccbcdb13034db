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

from bl_ext.user_default.wayfarer.addon.bridge.write_colors import painted_colors
from bl_ext.user_default.wayfarer.addon.results import shown, staleness, store
from bl_ext.user_default.wayfarer.addon.results.workflow import build_graph_steps
from bl_ext.user_default.wayfarer.addon.scene.inputs import (
    graph_settings,
    make_environment,
    prepared_clips_steps,
    read_character_steps,
    read_shapes,
)
from bl_ext.user_default.wayfarer.addon.scene.motion_fingerprint import actions_fingerprint
from bl_ext.user_default.wayfarer.addon.session import SESSION
from bl_ext.user_default.wayfarer.core.embedding.embedding import embed
from bl_ext.user_default.wayfarer.core.errors import SceneError
from bl_ext.user_default.wayfarer.core.motion.clip import MotionClip
from bl_ext.user_default.wayfarer.core.motion.graph import MotionGraph, build_motion_graph_steps
from bl_ext.user_default.wayfarer.core.progress import finish
from tests.blender.artist import Artist
from tests.blender.meddler import OWN_MATERIAL
from tests.blender.registered import is_ours

EPISODE = 75
"""Steps after which the sample is opened again: so much has been deleted by then."""

N_EPISODES = 2 * int(os.environ.get("WAYFARER_FUZZ", "1"))
SEED = int(os.environ.get("WAYFARER_FUZZ_SEED", "0"))

PILED = 60
"""Datablocks that our operators may add in an episode: floors, curves of walks, crowds, charts, materials."""

MEGABYTES = 400
"""By which Blender may grow over all episodes: it keeps what undo needs, and forgets it with the file."""

PURPOSEFUL = {"add_sample_room", "apply_remedy", "append_actions", "remedy"}
"""They add to the file because that is what they are for."""

OURS = {*dir(bpy.ops.wayfarer), "remedy", "evaluate_live", "preset"}
"""Steps in which nobody else does anything."""


def datablocks() -> dict[str, int]:
    """How many there are of each kind, but for those that windows come with."""
    left_out = {"screens", "workspaces", "window_managers", "brushes", "palettes", "libraries"}
    kinds = (name for name in dir(bpy.data) if name not in left_out)
    found = {kind: getattr(bpy.data, kind) for kind in kinds}
    return {kind: len(blocks) for kind, blocks in found.items() if isinstance(blocks, bpy.types.bpy_prop_collection)}


def orphans() -> set[str]:
    """What nobody uses, and nobody wants to be kept; and other files of which nothing is used."""
    kinds = ("meshes", "curves", "armatures", "materials", "actions", "objects", "collections", "node_groups")
    kinds += ("cameras", "lights", "worlds", "fonts")
    unused = {f"{kind} {block.name}" for kind in kinds for block in getattr(bpy.data, kind) if block.users == 0}
    return unused | {f"libraries {library.name}" for library in bpy.data.libraries if not library.users_id}


def our_handlers() -> int:
    lists = (getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers))
    return sum(is_ours(function) for functions in lists if isinstance(functions, list) for function in functions)


def megabytes() -> float:
    """What the process takes of the machine's memory; 0 where that is not known."""
    status = Path("/proc/self/statm")
    return int(status.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6 if status.exists() else 0.0


def rebuilt(scene, known: MotionGraph) -> MotionGraph:
    """The motion graph of a scene, made anew of its clips in the order that they have in one that is known.

    Actions are listed by their names, which are no part of a motion: renaming one makes nothing stale, although it may
    be read in another place from then on. Where to cut clips is searched for from random starts, so that the same clips
    in another order give another graph, as good as the first.
    """
    settings = scene.wayfarer.graph
    read = finish(read_character_steps(scene)).clips
    clips = finish(prepared_clips_steps(read, settings.steady_heading, settings.mirror_clips))
    resampled = [clip.resampled(known.frame_rate) for clip in clips]
    order: list[int] = []
    for clip in known.clips:
        alike = (i for i in range(len(clips)) if i not in order and is_same_motion(resampled[i], clip))
        place = next(alike, None)
        assert place is not None, f"a stale motion graph is shown as fresh: nothing is like '{clip.name}' any more"
        order.append(place)
    # Those that are too short for a graph come last.
    order += [i for i in range(len(clips)) if i not in order]
    return finish(build_motion_graph_steps([clips[i] for i in order], graph_settings(scene)))


def is_same_motion(clip: MotionClip, other: MotionClip) -> bool:
    """Whether two clips are one motion, wherever they start and whichever way they face there."""
    if clip.rotations.shape != other.rotations.shape:
        return False
    # The root's turns and way are compared with the segments.
    return np.allclose(np.abs(np.sum(clip.rotations[:, 1:] * other.rotations[:, 1:], axis=-1)), 1, atol=1e-6)


def assert_fresh_is_fresh() -> set[str]:
    """What is not called stale is what comes out when everything is computed anew, from scratch; what that was."""
    scene = bpy.context.scene
    found = store.results(scene)
    if found.graph is None or staleness.graph_is_stale(scene):
        return set()
    graph = rebuilt(scene, found.graph)
    assert graph.links.tolist() == found.graph.links.tolist(), "a stale motion graph is shown as fresh"
    for new, old in zip(graph.segments, found.graph.segments, strict=True):
        # Not to the last bit: where the character stands makes no difference but in rounding.
        np.testing.assert_allclose(new.path, old.path, 1e-5, 1e-5, err_msg="a stale motion graph is shown as fresh")
    if found.embedding is None or staleness.embedding_is_stale(scene):
        return {"graph"}
    environment = make_environment(scene, read_shapes(scene, bpy.context.evaluated_depsgraph_get()))
    embedding = embed(found.graph, environment, scene.wayfarer.embedding.to_core())
    whole = found.whole
    assert (embedding.n_nodes, embedding.planes) == (whole.n_nodes, whole.planes), "a stale embedding is shown as fresh"
    fresh = {"graph", "embedding"}
    floor = shown.find_painted(scene)
    if floor is not None and not staleness.map_is_stale(scene) and floor.mode == "OBJECT" and is_whole(floor):
        wanted = scene.wayfarer.map
        painted = finish(wanted.kind.paint_steps(found.embedding, wanted.to_core()))
        np.testing.assert_allclose(
            painted_colors(floor), painted.colors, atol=1e-6, err_msg="a stale map is shown as fresh"
        )
        fresh.add("painted")
    if shown.find_walk(scene) is not None and not staleness.walk_is_stale(scene):
        x, y, heading, segment = (found.walk.states % found.embedding.shape).T
        assert found.embedding.node_mask()[x, y, heading, segment].all(), "a stale walk is shown as fresh"
        fresh.add("walk")
    return fresh


def is_whole(floor) -> bool:
    """Whether a floor still has its cells and their colours, and nobody has merged or removed them since."""
    try:
        painted_colors(floor)
    except SceneError:
        return False
    return True


JUST_MADE = {
    "build_motion_graph": staleness.graph_is_stale,
    "embed": staleness.embedding_is_stale,
    "paint_map": staleness.map_is_stale,
    "random_walk": staleness.walk_is_stale,
}
"""What an operator has made is not stale, unless what it was made from is."""


def an_episode(artist: Artist, seen: Counter, capfd) -> None:
    handlers, piled = our_handlers(), Counter()
    for _ in range(EPISODE):
        counts, before = datablocks(), orphans()
        stale_before = [staleness.graph_is_stale(bpy.context.scene), staleness.embedding_is_stale(bpy.context.scene)]
        name = artist.step()
        printed = "".join(capfd.readouterr())
        assert "Traceback" not in printed, printed[printed.index("Traceback") :]
        seen[name if not artist.failed else f"{name} refused"] += 1
        if name in OURS:
            more = {kind: n - counts[kind] for kind, n in datablocks().items() if n != counts[kind]}
            piled.update(more if name not in PURPOSEFUL else {})
            assert sum(piled.values()) <= PILED, f"datablocks pile up: {piled}, {more} by {name}"
            # A region lets go of its object, which someone may have removed from all scenes before.
            new = orphans() - before if name != "remove_region" else set()
            # What the artist has put on one of our curves is not ours to remove with it.
            new = {orphan for orphan in new if not orphan.startswith(f"materials {OWN_MATERIAL}")}
            assert not new, f"{name} leaves {new} behind"
        if name in JUST_MADE and not artist.failed:
            index = list(JUST_MADE).index(name)
            made_of_stale = any(stale_before[:index])
            assert made_of_stale or not JUST_MADE[name](bpy.context.scene), f"what {name} has made is stale at once"
        if name in ("paint_map", "find_reach") and not artist.failed:
            assert is_whole(shown.find_painted(bpy.context.scene)), f"{name} has not painted the whole floor"
        assert our_handlers() == handlers, "handlers pile up"
        if artist.random.random() < 0.3:
            seen.update(f"fresh {kind}" for kind in assert_fresh_is_fresh())
    assert len(SESSION.all(store.SceneResults)) <= len(bpy.data.scenes) + 4, "results of scenes that are gone pile up"


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
    enough = {"graph": N_EPISODES, "embedding": N_EPISODES, "painted": (N_EPISODES + 1) // 3, "walk": N_EPISODES // 5}
    fresh = {kind: seen[f"fresh {kind}"] for kind in enough}
    assert all(fresh[kind] >= n for kind, n in enough.items()), f"{fresh} of {enough}: {seen}"
    with capfd.disabled():
        if N_EPISODES > 2:
            sys.stdout.write(f"{seen}\n")


def test_names_of_actions_are_no_part_of_a_graph(small_file):
    bpy.ops.wm.open_mainfile(filepath=small_file)
    scene = bpy.context.scene
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    known = store.results(scene).graph
    scene.wayfarer.clips[0].action.name = "zzz"
    bpy.ops.wayfarer.refresh_clips()
    # Or this would test nothing: made in the order in which they are listed now, it is another graph.
    assert finish(build_graph_steps(scene)).graph.links.tolist() != known.links.tolist()
    assert not staleness.graph_is_stale(scene) and assert_fresh_is_fresh() == {"graph"}
    # As if nobody had told of another key.
    action = scene.wayfarer.clips[0].action
    curve = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves[10]
    for point in curve.keyframe_points:
        point.co.y += 0.3
    found = store.results(scene)
    found.made_from["graph"] = (found.made_from["graph"][0], actions_fingerprint(scene))
    assert not staleness.graph_is_stale(scene)
    with pytest.raises(AssertionError, match="stale motion graph"):
        assert_fresh_is_fresh()


def test_a_stale_embedding_would_be_seen(sample_settings):
    for step in ("build_motion_graph", "embed"):
        getattr(bpy.ops.wayfarer, step)()
    assert assert_fresh_is_fresh() == {"graph", "embedding"}
    scene = bpy.context.scene
    bpy.data.objects["Table"].location.x += 1
    bpy.context.view_layer.update()
    found = store.results(scene)
    # As if nobody had told of the change.
    found.made_from["embedding"] = (
        found.made_from["embedding"][0],
        read_shapes(scene, bpy.context.evaluated_depsgraph_get()).fingerprint,
    )
    with pytest.raises(AssertionError, match="stale embedding"):
        assert_fresh_is_fresh()
