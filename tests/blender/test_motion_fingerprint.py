"""Whatever changes what a character does, or how it is read, makes the motion graph stale; nothing else does."""

import math

import bpy
import pytest

from bl_ext.user_default.wayfarer.addon import state
from bl_ext.user_default.wayfarer.addon.inputs import read_character_steps
from bl_ext.user_default.wayfarer.addon.motion_fingerprint import action_fingerprint, actions_fingerprint
from bl_ext.user_default.wayfarer.core.progress import finish


def curve(action):
    curves = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves
    return next(each for each in curves if len(each.keyframe_points) > 5 and "rotation" in each.data_path)


def interpolate(action, how: str):
    for point in curve(action).keyframe_points:
        point.interpolation = how


def pull_handle(action):
    point = curve(action).keyframe_points[3]
    point.handle_right_type = "FREE"
    point.handle_right.y += 1


def ease(action):
    point = curve(action).keyframe_points[3]
    point.interpolation, point.easing = "ELASTIC", "EASE_IN"
    before = actions_fingerprint(bpy.context.scene)
    point.period = 7.0
    assert actions_fingerprint(bpy.context.scene) != before


def shake(action):
    modifier = curve(action).modifiers.new("NOISE")
    before = actions_fingerprint(bpy.context.scene)
    modifier.strength = 3.0
    assert actions_fingerprint(bpy.context.scene) != before


def restrict(rig):
    constraint = rig.pose.bones["Spine"].constraints.new("LIMIT_ROTATION")
    before = actions_fingerprint(bpy.context.scene)
    constraint.use_limit_x, constraint.max_x = True, 0.1
    assert actions_fingerprint(bpy.context.scene) != before


def drive(rig):
    """By what a driver reads and how, and by its curve."""
    rig["switch"] = 0.25
    driver = rig.pose.bones["Spine"].constraints.new("LIMIT_SCALE").driver_add("influence")
    # Blender 4.5 begins a driver with a modifier instead.
    for value in (0.0, 1.0):
        driver.keyframe_points.insert(value, value)
    variable = driver.driver.variables.new()
    (target,) = variable.targets
    target.id, target.data_path, driver.driver.expression = rig, '["switch"]', variable.name
    known = {now()}

    def swap_type():
        variable.type = "TRANSFORMS"

    changes = {
        "switch": lambda: rig.__setitem__("switch", 0.75),
        "kind": swap_type,
        "transform": lambda: setattr(target, "transform_type", "ROT_Z"),
        "space": lambda: setattr(target, "transform_space", "LOCAL_SPACE"),
        "order": lambda: setattr(target, "rotation_mode", "SWING_TWIST_Y"),
        "key": lambda: setattr(driver.keyframe_points[1].co, "y", 2.0),
        "modifier": lambda: driver.modifiers.new("STEPPED"),
    }
    for name, change in changes.items():
        change()
        assert now() not in known, name
        known.add(now())


OF_ACTION = {
    "a key": lambda action: setattr(curve(action).keyframe_points[2].co, "y", 1.5),
    "steps": lambda action: interpolate(action, "CONSTANT"),
    "bends": lambda action: interpolate(action, "BEZIER"),
    "a handle": pull_handle,
    "easing": ease,
    "a modifier": shake,
    "extrapolation": lambda action: setattr(curve(action), "extrapolation", "LINEAR"),
    "mute": lambda action: setattr(curve(action), "mute", True),
    "range": lambda action: setattr(action, "use_frame_range", True),
    "a tag": lambda action: action.pose_markers.new("step"),
    "a rate": lambda action: action.__setitem__("wayfarer_frame_rate", 12.0),
}
OF_RIG = {
    "a tilt": lambda rig: setattr(rig.rotation_euler, "x", math.pi / 2),
    "size": lambda rig: setattr(rig, "scale", (2, 2, 2)),
    "a constraint": restrict,
    "a driver": drive,
    "inheritance": lambda rig: setattr(rig.data.bones["Spine"], "use_inherit_rotation", False),
    "rotation mode": lambda rig: setattr(rig.pose.bones["Spine"], "rotation_mode", "XZY"),
    "forward": lambda rig: rig.__setitem__("wayfarer_forward", [0.0, 1.0, 0.0]),
    "deforming": lambda rig: setattr(rig.data.bones["Spine"], "use_deform", False),
}
NOTHING = {
    "its place": lambda rig, action: setattr(rig, "location", (3, 2, 1)),
    "its heading": lambda rig, action: setattr(rig.rotation_euler, "z", 1.0),
    "its name": lambda rig, action: setattr(rig, "name", "Somebody"),
    "the action's name": lambda rig, action: setattr(action, "name", "Something"),
    "its pose": lambda rig, action: setattr(rig.pose.bones["Spine"], "location", (1, 1, 1)),
    "the frame": lambda rig, action: bpy.context.scene.frame_set(20),
}


@pytest.fixture
def opened(small_file):
    bpy.ops.wm.open_mainfile(filepath=small_file)
    settings = bpy.context.scene.wayfarer
    # What plays would move it back.
    settings.character.animation_data.action = None
    return settings


def now() -> str:
    bpy.context.view_layer.update()
    return actions_fingerprint(bpy.context.scene)


def test_what_changes_the_motion_is_seen(opened, small_file):
    known = {now()}
    for name, change in {**OF_ACTION, **OF_RIG}.items():
        change(opened.character if name in OF_RIG else opened.used_actions()[0])
        assert now() not in known, name
        known.add(now())


def test_nothing_else_is(opened):
    before = now()
    for name, change in NOTHING.items():
        change(opened.character, opened.used_actions()[0])
        assert now() == before, name


def test_what_moves_with_the_frame_is_told_by_its_curves(opened):
    """Rigs switch between their chains by keys of influences, or by properties that drive them."""
    scene, rig, action = bpy.context.scene, opened.character, opened.used_actions()[0]
    rig.animation_data.action = action
    spine = rig.pose.bones["Spine"]
    keyed, driven, armature = (spine.constraints.new(kind) for kind in ("LIMIT_SCALE", "LIMIT_ROTATION", "ARMATURE"))
    weighted = armature.targets.new()
    spine["switch"] = 0.0
    driver = driven.driver_add("influence").driver
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = rig, 'pose.bones["Spine"]["switch"]'
    driver.expression = variable.name
    for frame, value in ((1, 0.0), (20, 1.0)):
        spine["switch"] = keyed.influence = weighted.weight = value
        spine.keyframe_insert('["switch"]', frame=frame)
        keyed.keyframe_insert("influence", frame=frame)
        rig.keyframe_insert(weighted.path_from_id("weight"), frame=frame)
    scene.frame_set(1)
    before, shown = now(), (keyed.influence, driven.influence, weighted.weight)
    scene.frame_set(20)
    assert (keyed.influence, driven.influence, weighted.weight) != shown
    assert now() == before
    curves = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves
    curves.find(keyed.path_from_id("influence")).keyframe_points[1].co.y = 0.5
    assert now() != before


def test_known_fingerprints_are_not_taken_again(opened):
    scene = bpy.context.scene
    seen = finish(read_character_steps(scene)).seen
    assert actions_fingerprint(scene, seen) == actions_fingerprint(scene)
    assert actions_fingerprint(scene, {**seen, next(iter(seen)): "another"}) != actions_fingerprint(scene)


def test_results_of_deleted_scenes_are_forgotten(opened):
    first = bpy.context.scene
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    for _ in range(12):
        other = bpy.data.scenes.new("Other")
        assert state.results(other).graph is None
        bpy.data.scenes.remove(other)
    assert state.n_kept() <= 5 and state.results(first).graph is not None


def test_a_namesake_that_is_not_in_use_makes_no_difference(sample_settings, tmp_path):
    """An action of another file may bear the name of one of this file."""
    scene, action = bpy.context.scene, sample_settings.used_actions()[0]
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {action})
    with bpy.data.libraries.load(path, link=True) as (_, here):
        here.actions = [action.name]
    [linked] = here.actions
    curve(action).keyframe_points[3].co.y += 1
    sample_settings.refresh_clips()
    for clip in sample_settings.clips:
        clip.use = clip.use and clip.action != action
    used = sample_settings.used_actions()
    assert linked.name == action.name and linked in used and action not in used
    seen = {each.name: action_fingerprint(scene, each) for each in used}
    assert seen[linked.name] != action_fingerprint(scene, action)
    # Both have been looked at, one after the other.
    both = seen | {action.name: action_fingerprint(scene, action)}
    assert actions_fingerprint(scene, seen) == actions_fingerprint(scene, both) == actions_fingerprint(scene)
    assert bpy.ops.wayfarer.examine_clips() == {"FINISHED"}
    assert bpy.ops.wayfarer.build_motion_graph() == {"FINISHED"}
    assert not state.graph_is_stale(scene)
    curve(linked).keyframe_points[3].co.y += 1
    assert state.graph_is_stale(scene)
