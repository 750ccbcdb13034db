"""What makes results stale and what does not, whom actions belong to, and what goes with undo."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.clip_actions import action_seconds, character_actions, character_problem
from bl_ext.user_default.wayfarer.addon.bridge.import_bvh import import_bvh_files_steps
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.jobs import clock
from bl_ext.user_default.wayfarer.addon.render.floor import find_floor
from bl_ext.user_default.wayfarer.addon.results import advice, clips, shown, staleness, store
from bl_ext.user_default.wayfarer.addon.scene.inputs import read_character_steps
from bl_ext.user_default.wayfarer.addon.ui import lists
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.progress import finish
from bl_ext.user_default.wayfarer.core.wording import counted

operators = bpy.ops.wayfarer


def results():
    return store.results(bpy.context.scene)


def build(*steps):
    for step in steps or ("build_motion_graph", "embed", "paint_map", "random_walk"):
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


@pytest.fixture
def settings(sample_settings):
    return sample_settings


def second_character():
    """Another sample character; the first one's stays chosen. Returns (first, second)."""
    scene = bpy.context.scene
    first = scene.wayfarer.character
    operators.add_sample_character()
    second = scene.wayfarer.character
    scene.wayfarer.character = first
    return first, second


# ------------------------------------------------------------------------------------------------- stale


def test_what_things_are_called_makes_no_difference(settings):
    build()
    settings.character.name = "Hero"
    used = next(clip.action for clip in settings.clips if clip.use)
    used.name = "zzz a stroll"
    settings.environment.regions[0].object.name = "Threshold"
    settings.environment.ground.name = "Floor Boards"
    assert stale() == FRESH
    operators.refresh_clips()
    assert settings.clips[-1].action == used and stale() == FRESH


def test_another_rest_pose_is_stale(settings):
    build("build_motion_graph")
    bpy.context.view_layer.objects.active = settings.character
    bpy.ops.object.mode_set(mode="EDIT")
    settings.character.data.edit_bones["Head"].tail.z += 0.1
    bpy.ops.object.mode_set(mode="OBJECT")
    assert staleness.graph_changes(bpy.context.scene) == (
        "Keys, tags or frame ranges of clips have changed, or the rest pose or what moves the rig has",
    )


def test_results_are_for_the_character_they_were_made_for(settings):
    build()
    first, second = second_character()
    ticked = {clip.action for clip in settings.clips if clip.action.name.startswith(("walk", "turn_left", "arc"))}
    assert ticked
    settings.character = second
    assert stale() == (True,) * 4
    assert staleness.graph_changes(bpy.context.scene) == ("It was built for another character",)
    settings.character = first
    for clip in settings.clips:
        clip.use = clip.action.name.startswith(("walk", "turn_left", "turn_right_90", "arc"))
    assert stale() == FRESH


def test_a_deleted_character_is_missed(settings):
    build()
    scene, character = bpy.context.scene, settings.character
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = character
    character.select_set(True)
    bpy.ops.object.delete()
    # The settings still hold it.
    assert settings.character is not None
    assert "no longer in this scene" in character_problem(scene)
    assert stale() == (True,) * 4
    assert "no longer in this scene" in staleness.graph_changes(scene)[0]
    with pytest.raises(RuntimeError, match="no longer in this scene"):
        operators.build_motion_graph()
    assert advice.clip_advice(scene) == [character_problem(scene)]
    bpy.data.objects.remove(character)
    assert character_problem(scene) == "Choose a character first" and stale() == (True,) * 4


def test_a_linked_character_says_what_to_do(settings, sample_file, tmp_path):
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(sample_file, link=True) as (there, here):
        here.collections = ["Wayfarer Character"]
    scene, collection = bpy.context.scene, here.collections[0]
    linked = collection.objects[0]
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    scene.collection.objects.link(instance)
    scene.wayfarer.character = linked
    assert "library override" in character_problem(scene)
    # Linked into the scene, it is a character like any other.
    bpy.data.objects.remove(instance)
    scene.collection.children.link(collection)
    rig = next(obj for obj in collection.all_objects if obj.type == "ARMATURE")
    scene.wayfarer.character = rig
    assert character_problem(scene) == ""
    with bpy.data.libraries.load(sample_file, link=True) as (there, here):
        here.actions = [name for name in there.actions if name.startswith(("walk", "turn_left", "turn_right", "arc"))]
    operators.refresh_clips()
    assert len(scene.wayfarer.clips) > 5
    build("build_motion_graph")
    operators.add_sample_room()
    scene.wayfarer.environment.cell_size, scene.wayfarer.environment.n_headings = 0.5, 12
    build("embed")
    assert results().embedding.n_nodes > 0


def animate_shape(obj):
    """Key the shape of an object: as it is at frame 1, twice as wide at frame 20."""
    obj.shape_key_add(name="Basis")
    wide = obj.shape_key_add(name="Wide")
    for point in wide.data:
        point.co.x *= 2
    for frame, value in ((1, 0.0), (20, 1.0)):
        wide.value = value
        wide.keyframe_insert("value", frame=frame)


def test_an_obstacle_that_changes_its_shape_with_the_frame_is_stale(settings):
    scene, table = bpy.context.scene, bpy.data.objects["Table"]
    table.data = table.data.copy()
    animate_shape(table)
    scene.frame_set(1)
    build("build_motion_graph", "embed")
    assert stale() == FRESH
    for frame in (20, 1, 20):
        scene.frame_set(frame)
        assert staleness.embedding_is_stale(scene) == (frame == 20)
    build("embed")
    assert stale() == FRESH
    scene.frame_set(1)
    assert staleness.embedding_changes(scene) == ("Ground, obstacles or regions have moved or changed",)


# ------------------------------------------------------------------------------------------------- actions


def test_characters_list_their_own_actions(settings):
    before = {clip.action for clip in settings.clips}
    _, second = second_character()
    assert {clip.action for clip in settings.clips} == before
    settings.character = second
    others = {clip.action for clip in settings.clips}
    assert len(others) == len(before) and not others & before
    settings.use_others = True
    assert {clip.action for clip in settings.clips} == before | others
    settings.use_others = False
    assert {clip.action for clip in settings.clips} == others


def test_a_copy_of_a_character_may_use_what_there_is(settings):
    n_clips = len(settings.clips)
    copy = settings.character.copy()
    copy.data = copy.data.copy()
    bpy.context.scene.collection.objects.link(copy)
    own = copy.animation_data.action.copy()
    copy.animation_data.action = own
    assert len(character_actions(copy)) == n_clips + 1
    # And what the copy plays is not the first one's.
    assert own not in character_actions(settings.character)


def test_actions_of_another_file(settings, sample_file, tmp_path):
    names = {clip.action.name for clip in settings.clips}
    for action in list(bpy.data.actions):
        bpy.data.actions.remove(action)
    operators.refresh_clips()
    assert len(settings.clips) == 0
    stranger = tmp_path / "strangers.blend"
    bpy.data.libraries.write(str(stranger), {bpy.data.actions.new("Nothing")})
    bpy.data.actions.remove(bpy.data.actions["Nothing"])
    with pytest.raises(RuntimeError, match="is the file that is open"):
        operators.append_actions(filepath=sample_file)
    with pytest.raises(RuntimeError, match="no file"):
        operators.append_actions(filepath=str(tmp_path / "absent.blend"))
    (tmp_path / "text.blend").write_text("no blend")
    with pytest.raises(RuntimeError, match=r"text\.blend"):
        operators.append_actions(filepath=str(tmp_path / "text.blend"))
    assert operators.append_actions(filepath=str(stranger)) == {"CANCELLED"}
    assert operators.append_actions(filepath=str(stranger), link=True) == {"CANCELLED"}
    assert len(bpy.data.actions) == 0 and not list(bpy.data.libraries)
    source = tmp_path / "library.blend"
    source.write_bytes(Path(sample_file).read_bytes())
    assert operators.append_actions(filepath=str(source), assets_only=True) == {"CANCELLED"}
    assert operators.append_actions(filepath=str(source)) == {"FINISHED"}
    assert {clip.action.name for clip in settings.clips} == names
    assert all(clip.action.use_fake_user for clip in settings.clips)
    # What was appended belongs to this file: Blender need not look for the other one ever again.
    assert not list(bpy.data.libraries)
    build("build_motion_graph")
    for action in list(bpy.data.actions):
        bpy.data.actions.remove(action)
    assert operators.append_actions(filepath=str(source), link=True) == {"FINISHED"}
    assert all(clip.action.library is not None for clip in settings.clips) and len(settings.clips) == len(names)
    assert [Path(library.filepath) for library in bpy.data.libraries] == [source]
    build("build_motion_graph")


@pytest.mark.parametrize("whose", ["action", "character"])
def test_what_is_deleted_while_clips_are_read_is_missed(settings, whose):
    """In another window, where nobody waits for the end of the work."""
    steps, second = read_character_steps(bpy.context.scene), settings.used_actions()[1]
    next(steps)
    next(steps)
    name = second.name
    bpy.data.batch_remove([second if whose == "action" else settings.character])
    with pytest.raises(ClipError, match=f"'{name}' or its character was deleted"):
        finish(steps)


def test_clips_are_measured_sorted_and_filtered(settings):
    scene = bpy.context.scene
    build("examine_clips")
    left = next(clip.action for clip in settings.clips if clip.use and clip.action.name == "turn_left_90")
    assert np.degrees(clips.motion_of(scene, left).turn) == pytest.approx(90, abs=15)
    right = next(clip.action for clip in settings.clips if clip.use and clip.action.name == "turn_right_90")
    assert np.degrees(clips.motion_of(scene, right).turn) == pytest.approx(-90, abs=15)
    walk = bpy.data.actions["walk"]
    path = read_clip(settings.character, walk).ground_path
    straight = np.hypot(*(path[-1, :2] - path[0, :2]))
    assert straight <= clips.motion_of(scene, walk).distance < 1.1 * straight
    assert action_seconds(scene, walk) == pytest.approx((walk.frame_range[1] - walk.frame_range[0]) / 30)
    settings.clip_columns = {"DURATION", "DISTANCE", "TURN"}
    numbers = lists.clip_numbers(scene, left)
    assert numbers[0].endswith(" s") and numbers[1].endswith(" m") and numbers[2].startswith("+")

    def listed():
        stand_in = type("List", (), {"filter_name": "", "bitflag_filter_item": 1})
        shown, order = lists.WAYFARER_UL_clips.filter_items(stand_in, bpy.context, settings, "clips")
        places = order or range(len(settings.clips))
        by_place = sorted(zip(places, shown, settings.clips, strict=True), key=lambda item: item[0])
        return [clip.action for _, is_shown, clip in by_place if is_shown]

    everything = [clip.action for clip in settings.clips]
    assert listed() == everything
    settings.clip_order = "DURATION"
    seconds = [action_seconds(scene, action) for action in listed()]
    assert seconds == sorted(seconds, reverse=True) and len(seconds) == len(everything)
    settings.clip_order = "TURN"
    turns = [clips.motion_of(scene, action).turn for action in listed() if clips.motion_of(scene, action)]
    assert turns == sorted(turns, reverse=True) and listed()[: len(turns)] != everything[: len(turns)]
    settings.clip_order = "NAME"
    settings.clip_filter = "USED"
    assert listed() == settings.used_actions()
    settings.clip_filter = "TAGGED"
    assert listed() and all(action.name.startswith("step_over") for action in listed())
    # So has whatever a character of another size plays; its old size is known.
    measured = clips.motion_of(scene, left), clips.health_of(scene, left)
    assert None not in measured
    for size in (2, 1):
        settings.character.scale = (size,) * 3
        bpy.context.view_layer.update()
        now = clips.motion_of(scene, left), clips.health_of(scene, left)
        assert now == (measured if size == 1 else (None, None))
    # A changed action has to be measured anew.
    left.use_frame_range, left.frame_start, left.frame_end = True, 1, 12
    assert clips.motion_of(scene, left) is None and action_seconds(scene, left) == pytest.approx(11 / 30)


# --------------------------------------------------------------------------------------------------- undo


def undoable(step):
    bpy.ops.ed.undo_push(message=f"before {step}")
    assert getattr(operators, step)("EXEC_DEFAULT", True) == {"FINISHED"}


def test_map_and_walk_go_with_undo_and_come_back_with_redo(settings):
    build("build_motion_graph", "embed")
    scene = bpy.context.scene
    undoable("paint_map")
    undoable("random_walk")
    assert shown.find_painted(scene) is not None and shown.find_walk(scene) is not None
    walk = results().walk
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert shown.find_walk(scene) is None and results().walk is None
    assert shown.find_painted(scene) is not None
    bpy.ops.ed.undo()
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert shown.find_painted(scene) is None and results().painted is None
    assert stale() == FRESH and results().embedding is not None
    for _ in range(3):
        bpy.ops.ed.redo()
    scene = bpy.context.scene
    assert shown.find_painted(scene) is not None and results().walk is walk


def test_undo_shows_the_map_that_was_there_before(settings):
    build("build_motion_graph", "embed")
    settings.map.quantity = "COVERAGE"
    undoable("paint_map")
    first = results().painted
    bpy.context.scene.wayfarer.map.quantity = "WHY_NOT"
    undoable("paint_map")
    assert results().painted is not first and not staleness.map_is_stale(bpy.context.scene)
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert results().painted is first and shown.find_painted(scene) is not None
    # The choice was made before the step, so that the floor lags behind it again.
    assert scene.wayfarer.map.quantity == "WHY_NOT" and staleness.map_is_stale(scene)


def test_a_deleted_floor_and_a_deleted_walk_are_missed(settings):
    build()
    scene = bpy.context.scene
    bpy.data.objects.remove(find_floor(scene))
    assert shown.find_painted(scene) is None and not staleness.map_is_stale(scene)
    bpy.data.actions.remove(settings.character.animation_data.action)
    assert shown.find_walk(scene) is None and not staleness.walk_is_stale(scene)
    build("paint_map", "random_walk")
    assert shown.find_painted(scene) is not None and shown.find_walk(scene) is not None and stale() == FRESH


def test_a_deleted_ground_is_told(settings):
    build("build_motion_graph", "embed")
    scene, ground = bpy.context.scene, settings.environment.ground
    for collection in list(ground.users_collection):
        collection.objects.unlink(ground)
    assert any("ground 'Ground' is no longer" in sentence for sentence in advice.environment_advice(scene))


# ------------------------------------------------------------------------------------------------- advice


def test_regions_that_make_no_sense_are_told(settings):
    scene, region = bpy.context.scene, settings.environment.regions[0]
    sentences = advice.environment_advice(scene)
    assert len(sentences) == 1 and "speaks of 'step', but no ticked clip carries that tag" in sentences[0]
    for clip in settings.clips:
        clip.use = True
    assert advice.environment_advice(scene) == []
    region.object = None
    assert "no object" in advice.environment_advice(scene)[0]


def test_a_margin_counts_where_something_grows(settings):
    scene, region = bpy.context.scene, settings.environment.regions[0]
    build("build_motion_graph", "embed")
    region.margin = 0.1
    assert staleness.embedding_is_stale(scene)
    region.rule = "CONFINE"
    region.margin = 0.0
    build("embed")
    region.margin = 0.1
    assert not staleness.embedding_is_stale(scene)


def test_a_ground_at_another_height_than_the_character_is_told(settings):
    """Walks keep the height of the clips."""
    scene, environment = bpy.context.scene, settings.environment
    environment.ground_source, environment.ground_height = "TYPED", 1.5
    build("build_motion_graph", "embed")
    assert advice.embedding_advice(scene)[0].startswith("The ground is 1.50 m above 'Wayfarer Character'")
    settings.character.location.z = 1.5
    bpy.context.view_layer.update()
    assert advice.embedding_advice(scene) == []


def test_what_disappoints_is_told(settings):
    scene = bpy.context.scene
    build("build_motion_graph")
    far = bpy.data.objects.new("Far Away", bpy.data.objects["Table"].data)
    settings.environment.obstacles.objects.link(far)
    far.location = (50, 0, 0)
    bpy.context.view_layer.update()
    build("embed")
    assert advice.embedding_advice(scene) == ["Obstacles outside the ground make no difference: 'Far Away'"]
    far.location = (0.3, 0.4, 0)
    bpy.context.view_layer.update()
    settings.environment.radius = 5.0
    build("embed")
    assert advice.embedding_advice(scene)[0].startswith("The character cannot go anywhere")
    assert advice.clip_advice(scene) == []
    settings.character.scale = (0.01,) * 3
    bpy.context.view_layer.update()
    assert advice.clip_advice(scene)[0].startswith("'Wayfarer Character' is 0.01")


def test_a_start_far_away_is_told(settings):
    build("build_motion_graph", "embed", "random_walk")
    walk = results().walk
    x, y = walk.root_path[0, :2]
    assert advice.start_advice(None, walk) == "" and advice.start_advice((x + 0.5, y), walk) == ""
    assert "3.00 m from the place" in advice.start_advice((x, y - 3), walk)


# ------------------------------------------------------------------------------------------------- import


def test_a_cancelled_import_leaves_nothing(sample_file, tmp_path, capfd):
    text = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0 1 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 1 0
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.033333
0 1 0 0 0 0 0 0 0
0 1 1 0 0 0 0 0 0
0 1 2 0 0 0 0 0 0
"""
    paths = [tmp_path / f"clip_{number}.bvh" for number in range(4)]
    for path in paths:
        path.write_text(text)
    kinds = ("objects", "armatures", "actions", "collections")

    def contents():
        return {kind: sorted(block.name for block in getattr(bpy.data, kind)) for kind in kinds}

    for name in ("Chosen", "Other"):
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, None))
    chosen, other = bpy.data.objects["Chosen"], bpy.data.objects["Other"]
    other.select_set(True)
    bpy.context.view_layer.objects.active = chosen
    before = contents()
    steps = import_bvh_files_steps(paths, 1.0)
    messages = []
    while "Importing clip_2.bvh" not in messages:
        messages.append(next(steps).message)
    assert [f"Importing clip_{number}.bvh" in messages for number in range(4)] == [True, True, True, False]
    assert len(bpy.data.actions) == 2
    steps.close()
    assert contents() == before
    assert bpy.context.view_layer.objects.active == chosen and list(bpy.context.selected_objects) == [other]
    # Only the files that were selected.
    files = [{"name": path.name} for path in paths[1:3]]
    assert operators.import_bvh(directory=str(tmp_path), files=files, scale=1.0) == {"FINISHED"}
    assert "feet of the skeleton" in capfd.readouterr().out
    assert [clip.action.name for clip in bpy.context.scene.wayfarer.clips] == ["clip_1", "clip_2"]


# ------------------------------------------------------------------------------------------------- words


def test_numbers_in_sentences():
    assert [counted(n, "clip") for n in (0, 1, 2, 1200)] == ["0 clips", "1 clip", "2 clips", "1,200 clips"]
    assert [clock(seconds) for seconds in (0, 59.9, 60, 125, 3600, 3725)] == [
        "0 s",
        "59 s",
        "1:00",
        "2:05",
        "1:00:00",
        "1:02:05",
    ]


@pytest.mark.parametrize(
    ("group", "name", "value"),
    [("graph", "max_cost", 0.125), ("environment", "n_headings", 36), ("embedding", "footprint_rule", "CONSERVATIVE")],
)
def test_settings_are_kept_as_presets(group, name, value):
    settings = getattr(bpy.context.scene.wayfarer, group)
    default, add = getattr(settings, name), getattr(operators, f"add_{group}_preset")
    setattr(settings, name, value)
    assert add(name="Test Preset") == {"FINISHED"}
    setattr(settings, name, default)
    panel = getattr(bpy.types, f"WAYFARER_PT_{group}_presets")
    folder = Path(bpy.utils.user_resource("SCRIPTS", path=f"presets/{panel.preset_subdir}"))
    path = folder / "Test_Preset.py"
    try:
        assert bpy.ops.script.execute_preset(filepath=str(path), menu_idname=panel.__name__) == {"FINISHED"}
        assert getattr(settings, name) == value
        # What belongs to one file only is in no preset.
        assert "objects" not in path.read_text() and "ground" not in path.read_text()
    finally:
        path.unlink()
