"""The whole road by the operators of the panel: clips in, map and walking character out."""

import gc
import os
import weakref
from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.owned import WALK_CURVE as WALK_NAME
from bl_ext.user_default.wayfarer.addon.bridge.owned import WALK_PROPERTY
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.render.floor import FLOOR_NAME
from bl_ext.user_default.wayfarer.addon.results import store
from bl_ext.user_default.wayfarer.core.maps.colors import BLOCKED, UNREACHED, linear
from bl_ext.user_default.wayfarer.core.playback.synthesis import SynthesisSettings, synthesize

operators = bpy.ops.wayfarer
STEP_Y = 1.45
WALKS = ("walk", "turn_left", "turn_right_90", "arc")


def data_folder() -> Path:
    default = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    return Path(os.environ.get("WAYFARER_DATA", default))


def scene_results():
    return store.results(bpy.context.scene)


def prepare(sample_file, ticked=None, cell_size=0.25, n_headings=12):
    """The sample in its room, on a coarse grid, with only those clips ticked whose names start like this."""
    bpy.ops.wm.open_mainfile(filepath=sample_file)
    settings = bpy.context.scene.wayfarer
    settings.environment.cell_size, settings.environment.n_headings = cell_size, n_headings
    settings.walk.duration = 10.0
    if ticked is not None:
        for clip in settings.clips:
            clip.use = clip.action.name.startswith(ticked)
    return settings


def build(*steps):
    for step in steps or ("build_motion_graph", "embed", "paint_map", "random_walk"):
        assert getattr(operators, step)() == {"FINISHED"}


def painted_colors() -> np.ndarray:
    """(nx, ny, 4) colours that the floor shows."""
    floor = bpy.data.objects[FLOOR_NAME]
    layer = floor.data.color_attributes.active_color
    colors = np.empty(4 * len(floor.data.vertices), dtype=np.float32)
    layer.data.foreach_get("color", colors)
    return colors.reshape(*scene_results().embedding.environment.grid.shape[:2], 4, 4)[:, :, 0]


def root_positions(action, armature) -> np.ndarray:
    return read_clip(armature, action).ground_path[:, :2]


@pytest.mark.parametrize("fps", [30, 24])
def test_from_clips_to_a_walking_character(fps, sample_file):
    settings = prepare(sample_file, cell_size=0.125, n_headings=24)
    scene = bpy.context.scene
    scene.render.fps = fps
    settings.walk.duration = 20.0
    build()
    found = scene_results()
    assert found.embedding.n_nodes == found.summary.nodes > 0
    assert found.walk.duration >= 20.0

    # Both sides of the step can be reached, and nothing stands in an obstacle.
    grid = found.embedding.environment.grid
    covered = found.embedding.node_mask().any(axis=(2, 3))
    free = found.embedding.environment.free_cells()
    y = grid.positions(np.argwhere(np.ones_like(free)))[:, 1].reshape(free.shape)
    for side in (y > STEP_Y + 0.6, y < STEP_Y - 0.6):
        assert covered[side & free].mean() > 0.9
    assert not covered[~free].any()

    # The floor shows it.
    colors = painted_colors()
    np.testing.assert_allclose(colors[~free][:, :3], np.tile(linear(BLOCKED), ((~free).sum(), 1)), atol=1e-6)
    assert not np.isclose(colors[covered][:, :3], linear(UNREACHED), atol=1e-3).all(axis=1).any()
    busiest = np.unravel_index(covered.argmax(), covered.shape)
    assert colors[busiest][:3].min() > linear(BLOCKED).max()

    # The character goes exactly where the walk says, for as long as the timeline lasts.
    # It may leave the walk's path by a little where two segments meet.
    character, path = settings.character, synthesize(found.walk).ground_path
    assert np.abs(path[:, :2] - found.walk.root_path[:, :2]).max() <= SynthesisSettings().root_tolerance
    action = character.animation_data.action
    assert (scene.frame_start, scene.frame_end) == (1, int(action.frame_range[1]))
    assert scene.frame_end - 1 == pytest.approx(found.walk.duration * fps, abs=1)
    rate = fps / found.embedding.graph.frame_rate
    for frame in np.linspace(scene.frame_start, scene.frame_end, 7).round().astype(int).tolist():
        scene.frame_set(frame)
        root = character.matrix_world @ character.pose.bones["Hips"].head
        sample = (frame - 1) / rate
        expected = [np.interp(sample, np.arange(len(path)), path[:, axis]) for axis in (0, 1)]
        np.testing.assert_allclose(root[:2], expected, atol=2e-3)

    # Every frame keeps clear of obstacles, and is tagged where it is over the step.
    cells = np.floor((root_positions(action, character) - grid.origin) / grid.sample_size).astype(int)
    assert not found.embedding.environment.blocked[tuple(cells.T)].any()

    # The curve lies on the path.
    curve = bpy.data.objects[WALK_NAME].data.splines[0]
    points = np.empty(4 * len(curve.points), dtype=np.float32)
    curve.points.foreach_get("co", points)
    walked = found.walk.root_path[:, :2]
    nearest = [np.linalg.norm(walked - point[:2], axis=1).min() for point in points.reshape(-1, 4)]
    assert max(nearest) < 1e-4


def test_each_step_says_what_comes_before_it(sample_file):
    def refusal(name):
        with pytest.raises(RuntimeError) as error:
            getattr(operators, name)()
        return str(error.value)

    for step in ("refresh_clips", "build_motion_graph", "random_walk"):
        assert "Choose a character first" in refusal(step)
    assert "Build the motion graph first" in refusal("embed")
    assert "Embed the motion graph first" in refusal("paint_map")
    assert "Choose a region first" in refusal("remove_region")

    settings = prepare(sample_file, ())
    assert "tick at least one" in refusal("build_motion_graph")
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(WALKS)
    build("build_motion_graph")
    ground, obstacles = settings.environment.ground, settings.environment.obstacles
    settings.environment.ground = settings.environment.obstacles = None
    assert "Choose a ground or obstacles" in refusal("embed")
    settings.environment.ground, settings.environment.obstacles = ground, obstacles
    assert "Embed the motion graph first" in refusal("random_walk")
    settings.environment.radius = 5.0
    build("embed")
    assert scene_results().embedding.n_nodes == 0
    assert "empty" in refusal("random_walk")


def test_the_sample_is_tagged_where_it_steps_over(sample_file):
    prepare(sample_file)
    tagged = [
        clip.action.name
        for clip in bpy.context.scene.wayfarer.clips
        if {marker.name for marker in clip.action.pose_markers} == {"step", "/step"}
    ]
    assert tagged and all(name.startswith("step_over") for name in tagged)


def test_without_step_frames_the_far_end_is_out_of_reach(sample_file):
    prepare(sample_file, WALKS)
    build("build_motion_graph", "embed")
    found = scene_results()
    grid = found.embedding.environment.grid
    covered = found.embedding.node_mask().any(axis=(2, 3))
    y = grid.positions(np.argwhere(covered))[:, 1]
    assert len(y) and (y.max() < STEP_Y or y.min() > STEP_Y)


def test_a_new_walk_replaces_the_old_one(sample_file):
    settings = prepare(sample_file, WALKS)
    settings.walk.use_markers = True
    build()
    scene = bpy.context.scene
    mine = scene.timeline_markers.new("mine", frame=3)
    n_clips, first = len(settings.clips), root_positions(settings.character.animation_data.action, settings.character)
    assert len(scene.timeline_markers) == len(scene_results().walk) + 1
    settings.walk.seed = 5
    build("random_walk")
    assert [action.name for action in bpy.data.actions if WALK_PROPERTY in action] == ["Wayfarer Walk"]
    assert len([obj for obj in bpy.data.objects if obj.name.startswith(WALK_NAME)]) == 1
    assert len(scene.timeline_markers) == len(scene_results().walk) + 1
    assert scene.timeline_markers["mine"] == mine
    second = root_positions(settings.character.animation_data.action, settings.character)
    assert len(first) != len(second) or np.abs(first - second).max() > 0.1
    # A baked walk is no clip.
    operators.refresh_clips()
    assert len(settings.clips) == n_clips


@pytest.mark.parametrize("start", ["CURSOR", "ACTIVE_OBJECT"])
def test_a_walk_starts_where_it_is_told_to(start, sample_file):
    settings = prepare(sample_file, WALKS)
    build("build_motion_graph", "embed")
    place = (-1.5, 0.5)
    bpy.context.scene.cursor.location = (*place, 3.0)
    target = bpy.data.objects.new("Target", None)
    bpy.context.scene.collection.objects.link(target)
    target.location = (*place, 0.0)
    bpy.context.view_layer.objects.active = target
    settings.walk.start = start
    build("random_walk")
    found = scene_results()
    covered = np.argwhere(found.embedding.node_mask().any(axis=(2, 3)))
    distances = np.linalg.norm(found.embedding.environment.grid.positions(covered) - place, axis=1)
    assert np.hypot(*(found.walk.root_path[0, :2] - place)) == pytest.approx(distances.min(), abs=1e-6)


def test_saved_and_opened_again(tmp_path, sample_file):
    settings = prepare(sample_file, WALKS)
    settings.graph.max_cost = 0.25
    settings.clips[2].use = not settings.clips[2].use
    build()
    before = {
        "clips": [(clip.action.name, clip.use) for clip in settings.clips],
        "walk": root_positions(settings.character.animation_data.action, settings.character),
        "colors": painted_colors(),
    }
    shape = scene_results().embedding.environment.grid.shape[:2]
    n_nodes, old = scene_results().embedding.n_nodes, weakref.ref(scene_results().embedding)
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)

    settings = bpy.context.scene.wayfarer
    assert settings.graph.max_cost == pytest.approx(0.25)
    assert [(clip.action.name, clip.use) for clip in settings.clips] == before["clips"]
    assert settings.environment.regions[0].object.name == "Step"
    # What was computed comes from the file, not from what the session before left in memory.
    gc.collect()
    assert old() is None
    assert scene_results().embedding.n_nodes == n_nodes
    np.testing.assert_array_equal(
        root_positions(settings.character.animation_data.action, settings.character), before["walk"]
    )
    layer = bpy.data.objects[FLOOR_NAME].data.color_attributes.active_color
    colors = np.empty(4 * len(layer.data), dtype=np.float32)
    layer.data.foreach_get("color", colors)
    np.testing.assert_array_equal(colors.reshape(*shape, 4, 4)[:, :, 0], before["colors"])
    build()


def test_bvh_folder_becomes_a_walking_character():
    folder = data_folder() / "cmu16"
    if not folder.is_dir():
        pytest.skip(f"the CMU clips are not at {folder}; set WAYFARER_DATA to the folder that holds cmu16")
    bpy.context.scene.render.fps = 30
    assert operators.import_bvh(directory=str(folder)) == {"FINISHED"}
    operators.add_sample_room()
    settings = bpy.context.scene.wayfarer
    assert len(settings.clips) == len(list(folder.glob("*.bvh")))
    tagged = {clip.action.name for clip in settings.clips if len(clip.action.pose_markers)}
    assert tagged == {"16_09", "16_10"}
    settings.walk.duration = 15.0
    build()
    found = scene_results()
    played = {found.embedding.graph.clips[segment.clip].name for segment in found.graph.segments}
    assert played & tagged
    covered = found.embedding.node_mask().any(axis=(2, 3))
    y = found.embedding.environment.grid.positions(np.argwhere(covered))[:, 1]
    assert y.max() > STEP_Y + 1 and y.min() < STEP_Y - 1
    action = settings.character.animation_data.action
    path = synthesize(found.walk).ground_path
    np.testing.assert_allclose(root_positions(action, settings.character), path[:, :2], atol=2e-3)
