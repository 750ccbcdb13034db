"""Results in the .blend: there again after reopening, fresh or stale as they were, and no burden in between."""

import importlib
from pathlib import Path

import addon_utils
import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.exports import results as results_export
from bl_ext.user_default.wayfarer.addon.render.floor import find_floor
from bl_ext.user_default.wayfarer.addon.results import file as storage
from bl_ext.user_default.wayfarer.addon.results import shown, staleness, store
from bl_ext.user_default.wayfarer.addon.ui import overlay

from .registered import EXTENSION
from .saved_results import sealed

operators = bpy.ops.wayfarer


def scene_results():
    return store.results(bpy.context.scene)


def build(*steps):
    for step in steps or ("build_motion_graph", "embed", "count_lost_links", "paint_map", "random_walk"):
        assert getattr(operators, step)() == {"FINISHED"}


def stale() -> tuple[bool, ...]:
    """Of graph, embedding, map and walk."""
    scene = bpy.context.scene
    return (
        staleness.graph_is_stale(scene),
        staleness.embedding_is_stale(scene),
        staleness.map_is_stale(scene),
        staleness.walk_is_stale(scene),
    )


FRESH = (False,) * 4


def save(path: Path) -> str:
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return str(path)


def reopen(path: str):
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    return bpy.context.scene.wayfarer


@pytest.fixture
def built(sample_settings):
    build()
    return sample_settings


def test_everything_is_there_again(built, tmp_path):
    before = scene_results()
    numbers, lost = before.summary, store.lost_links(bpy.context.scene)
    path = save(tmp_path / "kept.blend")
    assert before.stored_bytes > 1000
    settings = reopen(path)
    after, scene = scene_results(), bpy.context.scene
    assert after is not before and after.problem == ""
    assert after.embedding.planes == before.embedding.planes
    assert after.embedding.unrolling.valid == before.embedding.unrolling.valid
    assert after.embedding.graph is after.graph and after.walk.embedding is after.embedding
    np.testing.assert_array_equal(after.graph.links, before.graph.links)
    np.testing.assert_array_equal(after.walk.states, before.walk.states)
    np.testing.assert_array_equal(after.walk.root_path, before.walk.root_path)
    assert after.graph_summary.hubs(3).tolist() == before.graph_summary.hubs(3).tolist()
    assert after.summary == numbers and store.lost_links(scene) == lost
    assert after.ground_height == before.ground_height
    assert stale() == FRESH
    assert shown.find_painted(scene) is not None and shown.find_walk(scene) is not None
    # Work goes on without anything being computed again.
    settings.walk.duration = 3.0
    build("paint_map", "random_walk")
    assert stale() == FRESH
    assert after.embedding.planes == before.embedding.planes


def test_what_has_changed_is_stale_after_reopening(built, tmp_path):
    environment = built.environment
    environment.radius = 0.3
    path = save(tmp_path / "radius.blend")
    settings = reopen(path)
    assert stale() == (False, True, True, True)
    settings.environment.radius = 0.25
    assert stale() == FRESH
    next(clip for clip in settings.clips if clip.use).use = False
    path = save(tmp_path / "ticks.blend")
    reopen(path)
    assert stale() == (True,) * 4
    assert staleness.graph_changes(bpy.context.scene) == ("Other clips are ticked",)


def test_what_moved_after_embedding_is_stale_after_reopening(built, tmp_path):
    bpy.data.objects["Table"].location.x += 0.5
    reopen(save(tmp_path / "moved.blend"))
    assert stale() == (False, True, True, True)
    assert staleness.embedding_changes(bpy.context.scene) == ("Ground, obstacles or regions have moved or changed",)


def test_what_shows_an_embedding_that_was_replaced_is_stale_after_reopening(built, tmp_path):
    build("embed")
    before = stale(), staleness.walk_changes(bpy.context.scene), scene_results().summary
    assert before[:2] == ((False, False, True, True), ("The motion graph was embedded anew",))
    for name in ("anew.blend", "again.blend"):
        reopen(save(tmp_path / name))
        scene = bpy.context.scene
        assert (stale(), staleness.walk_changes(scene), scene_results().summary) == before
        assert shown.find_painted(scene) is not None and shown.find_walk(scene) is not None
    files = results_export.export_results(scene, tmp_path / "out", as_json=False, as_csv=False, as_pictures=True)
    assert [file.name for file in files] == ["map.svg", "map.png"]
    build("paint_map", "random_walk")
    assert stale() == FRESH


def test_a_walk_that_was_pruned_away_is_stale_after_reopening(built, tmp_path):
    build("prune")
    changes = staleness.walk_changes(bpy.context.scene)
    assert changes == ("The embedding was pruned",)
    reopen(save(tmp_path / "pruned.blend"))
    assert stale() == (False, False, True, True) and staleness.walk_changes(bpy.context.scene) == changes
    # What was replaced cannot come back, and the walk is not known to fit.
    build("restore_embedding")
    assert staleness.walk_changes(bpy.context.scene) == changes


def test_a_walk_that_fits_again_is_fresh_after_reopening(built, tmp_path):
    build("prune", "random_walk", "restore_embedding", "paint_map")
    assert stale() == FRESH
    links = scene_results().walk.states.tolist()
    reopen(save(tmp_path / "restored.blend"))
    assert stale() == FRESH and scene_results().walk.states.tolist() == links


def test_a_floor_of_which_nothing_is_known_does_not_look_fresh(built, tmp_path):
    built.keep_results = False
    reopen(save(tmp_path / "without.blend"))
    scene = bpy.context.scene
    assert find_floor(scene) is not None and shown.find_painted(scene) is None
    assert overlay.is_outdated(scene)


def test_a_graph_built_anew_is_kept_beside_the_embedding(built, tmp_path):
    built.graph.max_cost = 0.2
    build("build_motion_graph")
    n_links, n_nodes = len(scene_results().graph.links), scene_results().embedding.n_nodes
    reopen(save(tmp_path / "graph.blend"))
    found = scene_results()
    assert len(found.graph.links) == n_links and found.embedding.n_nodes == n_nodes
    assert found.embedding.graph is not found.graph
    assert stale() == (False, True, True, True)
    assert staleness.embedding_changes(bpy.context.scene) == ("The motion graph was built anew",)


def test_nothing_stays_in_the_open_scene(built, tmp_path):
    scene = bpy.context.scene
    path = save(tmp_path / "clean.blend")
    assert storage.PROPERTY not in scene
    with pytest.raises(RuntimeError):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "absent" / "folder.blend"))
    assert storage.PROPERTY not in scene
    reopen(path)
    assert storage.PROPERTY not in bpy.context.scene
    bpy.ops.ed.undo_push(message="first")
    bpy.context.scene.frame_start = 5
    bpy.ops.ed.undo_push(message="second")
    bpy.ops.ed.undo()
    assert storage.PROPERTY not in bpy.context.scene and scene_results().embedding is not None
    # A second save writes what was never looked at, and it is the same.
    sizes = []
    for _ in range(2):
        bpy.ops.wm.open_mainfile(filepath=path)
        bpy.ops.wm.save_mainfile()
        sizes.append(scene_results().stored_bytes)
    assert sizes[0] == sizes[1] > 1000


def test_whoever_switches_the_extension_on_later_finds_them(built, tmp_path, wayfarer):
    path, before = save(tmp_path / "later.blend"), scene_results().summary
    addon_utils.disable(EXTENSION, default_set=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert storage.PROPERTY in bpy.context.scene
    addon_utils.enable(EXTENSION, default_set=True)
    assert importlib.import_module(f"{EXTENSION}.addon.results.store").results(bpy.context.scene).summary == before
    assert storage.PROPERTY not in bpy.context.scene


def test_switching_the_extension_off_and_on_keeps_results(built, tmp_path, wayfarer):
    before, stale_before = scene_results().summary, stale()
    addon_utils.disable(EXTENSION, default_set=True)
    addon_utils.enable(EXTENSION, default_set=True)
    again = importlib.import_module(f"{EXTENSION}.addon.results.staleness")
    store_again = importlib.import_module(f"{EXTENSION}.addon.results.store")
    found = store_again.results(bpy.context.scene)
    assert found.summary == before and found.embedding.n_nodes == before.nodes
    assert (again.graph_is_stale(bpy.context.scene), again.walk_is_stale(bpy.context.scene)) == (False, False)
    assert stale_before == FRESH and storage.PROPERTY not in bpy.context.scene
    # While it is off, files are saved and opened with what it has left there.
    addon_utils.disable(EXTENSION, default_set=True)
    bpy.ops.wm.open_mainfile(filepath=save(tmp_path / "off.blend"))
    addon_utils.enable(EXTENSION, default_set=True)
    assert importlib.import_module(f"{EXTENSION}.addon.results.store").results(bpy.context.scene).summary == before


def test_what_is_no_result_is_refused(built):
    scene = bpy.context.scene
    scene[storage.PROPERTY] = {"header": {"a": 1}, "embedding": [1, 2], "graph": b"x"}
    storage.take_saved()
    assert "cannot be used" in scene_results().problem
    # Of what lay there, nothing is held that went with it.
    assert storage.encoded_results(scene) == {"graph": b"x"}


def test_left_out_when_not_wanted(built, tmp_path):
    large = Path(save(tmp_path / "with.blend")).stat().st_size
    with_results = scene_results().stored_bytes
    built.keep_results = False
    path = save(tmp_path / "without.blend")
    assert Path(path).stat().st_size < large - 0.9 * with_results
    settings = reopen(path)
    assert scene_results().graph is None and scene_results().embedding is None
    assert shown.find_painted(bpy.context.scene) is None and not settings.keep_results


def in_header(**values):
    return lambda parts: parts.update(sealed(parts, parts, **values))


def flip(name):
    def change(parts):
        raw = bytearray(parts[name])
        raw[len(raw) // 2] ^= 0xFF
        parts[name] = bytes(raw)

    return change


DAMAGES = {
    "a bit of the embedding": flip("embedding"),
    "a bit of the rest": flip("results"),
    "no header": lambda parts: parts.pop("results"),
    "no embedding": lambda parts: parts.pop("embedding"),
    "half a header": lambda parts: parts.update(results=parts["results"][: len(parts["results"]) // 2]),
    "of an earlier version": lambda parts: parts.update(header="{}"),
    "cut short": lambda parts: parts.update(embedding=parts["embedding"][:200]),
    "other types": lambda parts: parts.update(embedding="text", results=5),
    "a later version": in_header(version=99),
    "no fingerprints": in_header(made_from={}),
    "other numbers": in_header(lost_links={"what": 1}),
    "no summary": in_header(summary=3),
    "no list": in_header(made_for=None),
}


def test_damaged_results_are_told_and_left_out(built):
    scene = bpy.context.scene
    sound = storage.encoded_results(scene)
    for name, change in DAMAGES.items():
        parts = dict(sound)
        change(parts)
        scene[storage.PROPERTY] = parts
        storage.take_saved()
        found = scene_results()
        assert found.graph is None and found.embedding is None and found.walk is None, name
        assert "cannot be used" in found.problem and found.problem.endswith("Compute anew"), name
        assert stale() == FRESH and shown.find_painted(scene) is None, name
        # A later version may be able to read them: saving does not lose them.
        assert storage.encoded_results(scene) == parts, name
    # And the way on is open.
    build()
    assert scene_results().problem == ""
    scene[storage.PROPERTY] = sound
    storage.take_saved()
    assert scene_results().walk is not None and scene_results().problem == ""


def test_something_else_under_our_name(built):
    scene = bpy.context.scene
    scene[storage.PROPERTY] = 17
    storage.take_saved()
    assert "cannot be used" in scene_results().problem and storage.PROPERTY not in scene


def test_an_appended_scene_brings_its_results(built, tmp_path):
    n_nodes = scene_results().embedding.n_nodes
    path = save(tmp_path / "library.blend")
    for link in (False, True):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        with bpy.data.libraries.load(path, link=link) as (there, here):
            here.scenes = there.scenes
        scene = here.scenes[0]
        assert store.results(scene).embedding.n_nodes == n_nodes


def test_a_copy_of_a_scene_starts_without_results(built):
    copy = bpy.context.scene.copy()
    assert storage.PROPERTY not in copy
    assert store.results(copy).graph is None
    assert scene_results().graph is not None
