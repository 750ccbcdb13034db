"""Reading actions: always the same as what Blender itself makes of them."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge import evaluated_pose, read_actions
from bl_ext.user_default.wayfarer.addon.bridge.action_curves import actions_of
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip, read_clips
from bl_ext.user_default.wayfarer.addon.bridge.tags import read_tags, write_tags
from bl_ext.user_default.wayfarer.core.errors import ClipError

MODES = ("QUATERNION", "AXIS_ANGLE", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
CHANNELS = {"QUATERNION": ("rotation_quaternion", 4), "AXIS_ANGLE": ("rotation_axis_angle", 4)}


def armature(name="Rig", connect=False):
    """Hips, spine, two legs, and an IK target that hangs from nothing; bones point everywhere."""
    data = bpy.data.armatures.new(name)
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    bones = {}
    for bone, parent, head, tail, roll in (
        ("hips", None, (0, 0, 1), (0, 0.1, 1.2), 0.3),
        ("spine", "hips", (0, 0.1, 1.2), (0, 0, 1.7), 0.1),
        ("thigh.L", "hips", (0.1, 0, 1), (0.12, -0.05, 0.5), 1.0),
        ("shin.L", "thigh.L", (0.12, -0.05, 0.5), (0.1, 0, 0.1), -0.4),
        ("thigh.R", "hips", (-0.1, 0, 1), (-0.12, -0.05, 0.5), 0.0),
        ("shin.R", "thigh.R", (-0.12, -0.05, 0.5), (-0.1, 0, 0.1), 2.0),
        ("ik target", None, (0.3, 0.3, 0), (0.3, 0.5, 0), 0.0),
        ("ik child", "ik target", (0.3, 0.5, 0), (0.3, 0.6, 0.1), 0.0),
    ):
        new = bones[bone] = data.edit_bones.new(bone)
        new.head, new.tail, new.roll = head, tail, roll
        if parent:
            new.parent = bones[parent]
            new.use_connect = connect and bone == "spine"
        new.use_deform = not bone.startswith("ik")
    bpy.ops.object.mode_set(mode="OBJECT")
    return obj


def new_action(obj, name="walk", slot=None):
    action = bpy.data.actions.new(name)
    add_slot(action, slot or obj.name)
    return action


def add_slot(action, name):
    slot = action.slots.new("OBJECT", name)
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    strip.channelbag(slot, ensure=True)
    return slot


def add_curve(action, path, index, frames, values, interpolation="BEZIER", slot=None):
    channelbag = action.layers[0].strips[0].channelbag(slot or action.slots[0])
    curve = channelbag.fcurves.new(path, index=index)
    for frame, value in zip(frames, values, strict=True):
        key = curve.keyframe_points.insert(frame, value)
        key.interpolation = interpolation
    return curve


def animate(obj, action, modes, seed=0, frames=(1, 7, 12, 30), interpolation="BEZIER", slot=None, moving=("hips",)):
    """Random keys on all rotation channels of every bone, and on the locations of some."""
    rng = np.random.default_rng(seed)
    for bone, mode in zip(obj.pose.bones, modes, strict=True):
        bone.rotation_mode = mode
        name, count = CHANNELS.get(mode, ("rotation_euler", 3))
        for index in range(count):
            values = rng.uniform(-1.5, 1.5, len(frames))
            add_curve(action, f'pose.bones["{bone.name}"].{name}', index, frames, values, interpolation, slot)
        if bone.name in moving:
            for index in range(3):
                values = rng.uniform(-1, 1, len(frames))
                add_curve(action, f'pose.bones["{bone.name}"].location', index, frames, values, interpolation, slot)


def blender_world(obj, action, frames, slot=None):
    """World matrices (F, B, 4, 4) of all bones by the slow, obvious way."""
    obj.animation_data_create().action = action
    obj.animation_data.action_slot = slot or action.slots[0]
    result = []
    for frame in frames:
        bpy.context.scene.frame_set(int(frame), subframe=frame % 1)
        result.append([np.array(obj.matrix_world @ bone.matrix) for bone in obj.pose.bones])
    obj.animation_data.action = None
    return np.array(result)


def assert_like_blender(clip, obj, action, slot=None, atol=1e-5):
    frames = clip.first_frame + np.arange(clip.n_frames)
    expected = blender_world(obj, action, frames, slot)
    rotations, positions = clip.world
    for index, bone in enumerate(obj.pose.bones):
        joint = clip.skeleton.index(bone.name)
        np.testing.assert_allclose(positions[:, joint], expected[:, index, :3, 3], atol=atol)
        w, x, y, z = rotations[:, joint].T
        axis_y = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], axis=1)
        column = expected[:, index, :3, 1]
        column = column / np.linalg.norm(column, axis=1, keepdims=True)
        np.testing.assert_allclose(axis_y, column, atol=2 * atol)


@pytest.fixture(autouse=True)
def count_evaluations(monkeypatch):
    """How often Blender was asked to evaluate whole frames instead of curves."""
    calls = []
    real = read_actions.evaluated_matrices
    monkeypatch.setattr(read_actions, "evaluated_matrices", lambda *args: calls.append(1) or real(*args))
    return calls


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("interpolation", ["BEZIER", "LINEAR", "CONSTANT"])
def test_every_rotation_mode(mode, interpolation, count_evaluations):
    obj = armature()
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.1, 0.2, 0.9), (1.7, 1.7, 1.7)
    action = new_action(obj)
    animate(obj, action, [mode] * 8, interpolation=interpolation, moving=("hips", "shin.R", "ik target"))
    clip = read_clip(obj, action)
    assert clip.n_frames == 30 and clip.first_frame == 1 and clip.skeleton.names[0] == "hips"
    assert not count_evaluations
    assert_like_blender(clip, obj, action)


def test_both_ways_of_reading_agree():
    obj = armature()
    obj.location, obj.scale = (1, 2, 3), (0.5, 0.5, 0.5)
    action = new_action(obj)
    animate(obj, action, MODES)
    quick = read_clip(obj, action)
    obj.pose.bones["spine"].constraints.new("LIMIT_DISTANCE").influence = 0  # has no effect
    slow = read_clip(obj, action)
    np.testing.assert_allclose(slow.translations, quick.translations, atol=1e-5)
    dots = np.abs(np.sum(slow.rotations * quick.rotations, axis=2))
    np.testing.assert_allclose(dots, 1, atol=1e-9)


def test_missing_components_and_channels():
    obj = armature()
    action = new_action(obj)
    obj.pose.bones["spine"].rotation_mode = "XZY"
    add_curve(action, 'pose.bones["hips"].rotation_quaternion', 2, (1, 10), (0.2, 0.7))
    add_curve(action, 'pose.bones["hips"].location', 1, (3, 20), (0.2, 0.7))
    add_curve(action, 'pose.bones["spine"].rotation_euler', 2, (5, 8), (-1, 1))
    clip = read_clip(obj, action)
    assert clip.n_frames == 20
    assert_like_blender(clip, obj, action)


def test_a_posed_rig_is_read_from_its_rest_pose():
    obj = armature()
    action = new_action(obj)
    add_curve(action, 'pose.bones["hips"].location', 1, (1, 20), (0.2, 0.7))
    expected = read_clip(obj, action)
    obj.pose.bones["spine"].rotation_quaternion = (0.5, 0.5, 0.5, 0.5)
    np.testing.assert_array_equal(read_clip(obj, action).rotations, expected.rotations)
    obj.pose.bones["spine"].constraints.new("LIMIT_DISTANCE").influence = 0
    evaluated = read_clip(obj, action)
    np.testing.assert_allclose(evaluated.translations, expected.translations, atol=1e-6)
    np.testing.assert_allclose(np.abs(np.sum(evaluated.rotations * expected.rotations, axis=2)), 1, atol=1e-9)
    assert tuple(obj.pose.bones["spine"].rotation_quaternion) == (0.5, 0.5, 0.5, 0.5)


def test_dense_keys_are_copied():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES, frames=range(4, 40), interpolation="BEZIER")
    clip = read_clip(obj, action)
    assert clip.first_frame == 4 and clip.n_frames == 36
    assert_like_blender(clip, obj, action)


def test_keys_between_the_frames():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES, frames=np.arange(2, 9, 0.25), interpolation="LINEAR")
    clip = read_clip(obj, action)
    assert clip.n_frames == 7
    assert_like_blender(clip, obj, action)


def test_modifiers_and_extrapolation(count_evaluations):
    obj = armature()
    action = new_action(obj)
    curve = add_curve(action, 'pose.bones["hips"].location', 1, (1, 6, 11), (0, 0.7, 0.1), "LINEAR")
    curve.modifiers.new("CYCLES")
    curve = add_curve(action, 'pose.bones["hips"].location', 0, (5, 10), (0, 1), "LINEAR")
    curve.extrapolation = "LINEAR"
    add_curve(action, 'pose.bones["spine"].rotation_quaternion', 3, (1, 40), (0, 1), "LINEAR")
    clip = read_clip(obj, action)
    assert clip.n_frames == 40 and not count_evaluations
    assert_like_blender(clip, obj, action)
    assert np.ptp(clip.translations[:, 0], axis=0).min() >= 0 and np.ptp(clip.translations[:, 0], axis=0).max() > 5


def test_muted_curves_do_not_count():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    channelbag = action.layers[0].strips[0].channelbag(action.slots[0])
    for curve in list(channelbag.fcurves)[::3]:
        curve.mute = True
    add_curve(action, 'pose.bones["shin.L"].location', 0, (1, 60), (0, 5)).mute = True
    clip = read_clip(obj, action)
    assert clip.n_frames == 30
    assert_like_blender(clip, obj, action)


def test_manual_frame_range():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    action.use_frame_range, action.frame_start, action.frame_end = True, 5, 44
    clip = read_clip(obj, action)
    assert clip.first_frame == 5 and clip.n_frames == 40
    assert_like_blender(clip, obj, action)


def test_motion_of_the_object_itself(count_evaluations):
    parent = bpy.data.objects.new("Parent", None)
    parent.location, parent.rotation_euler.z = (1, 0, 0), 0.5
    bpy.context.scene.collection.objects.link(parent)
    obj = armature()
    obj.parent = parent
    obj.matrix_parent_inverse = parent.matrix_basis.inverted()
    obj.matrix_parent_inverse.translation.x += 0.3
    obj.rotation_mode, obj.scale = "YZX", (2, 2, 2)
    obj.location = (7, 8, 9)
    action = new_action(obj)
    animate(obj, action, MODES)
    for index in (0, 1):  # z stays where it is
        add_curve(action, "location", index, (1, 40), (0, 3 + index))
        add_curve(action, "rotation_euler", 2 * index, (1, 40), (0, 2))
    clip = read_clip(obj, action)
    assert clip.n_frames == 40 and not count_evaluations
    assert_like_blender(clip, obj, action, atol=2e-5)
    assert np.hypot(*np.ptp(clip.ground_path[:, :2], axis=0)) > 3


def test_animated_object_scale():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    for index in range(3):
        add_curve(action, "scale", index, (1, 30), (0.01, 0.01))
    clip = read_clip(obj, action)
    assert_like_blender(clip, obj, action)
    assert np.ptp(clip.translations[0, :, 2]) < 0.02


@pytest.mark.parametrize(
    "disturb",
    [
        lambda obj: setattr(obj.data.bones["shin.L"], "use_inherit_rotation", False),
        lambda obj: setattr(obj.data.bones["shin.L"], "inherit_scale", "NONE"),
        lambda obj: setattr(obj.data.bones["hips"], "use_local_location", False),
        lambda obj: setattr(obj, "delta_location", (1, 2, 3)),
        lambda obj: (
            setattr(obj.pose.bones["shin.L"].constraints.new("IK"), "target", obj)
            or setattr(obj.pose.bones["shin.L"].constraints["IK"], "subtarget", "ik target")
        ),
    ],
    ids=["rotation", "scale", "location", "delta", "ik"],
)
def test_rigs_that_need_evaluation(disturb, count_evaluations):
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES, moving=("hips", "ik target"))
    disturb(obj)
    clip = read_clip(obj, action)
    assert count_evaluations
    assert_like_blender(clip, obj, action)


def test_scaled_bones(count_evaluations):
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    curve = add_curve(action, 'pose.bones["hips"].scale', 0, (1, 30), (1, 1))
    read_clip(obj, action)
    assert not count_evaluations
    curve.keyframe_points[1].co.y = 1.5
    for index in (1, 2):
        add_curve(action, 'pose.bones["hips"].scale', index, (1, 30), (1, 1.5))
    add_curve(action, 'pose.bones["shin.R"].scale', 0, (1, 2), (0, 0))
    clip = read_clip(obj, action)
    assert count_evaluations
    expected = blender_world(obj, action, range(1, 31))
    for index, bone in enumerate(obj.pose.bones):
        joint = clip.skeleton.index(bone.name)
        np.testing.assert_allclose(clip.world[1][:, joint], expected[:, index, :3, 3], atol=1e-5)


def test_evaluation_leaves_everything_as_it_was():
    obj = armature()
    other, action = new_action(obj, "other"), new_action(obj)
    animate(obj, other, MODES, seed=3)
    animate(obj, action, MODES, seed=4)
    add_curve(action, "location", 0, (1, 30), (4, 9))
    second = add_slot(other, "Second")
    animate(obj, other, MODES, seed=5, slot=second)
    obj.animation_data_create().action = other
    obj.animation_data.action_slot = second
    bpy.context.scene.frame_set(9)
    obj.pose.bones["shin.L"].location = (0.1, 0.2, 0.3)
    obj.location = (1, 1, 1)
    obj.pose.bones["shin.L"].constraints.new("LIMIT_DISTANCE")
    bpy.context.view_layer.update()
    before = [np.array(bone.matrix) for bone in obj.pose.bones]
    read_clip(obj, action)
    assert obj.animation_data.action == other and obj.animation_data.action_slot == second
    assert bpy.context.scene.frame_current == 9 and tuple(obj.location) == (1, 1, 1)
    np.testing.assert_allclose(before, [np.array(bone.matrix) for bone in obj.pose.bones], atol=1e-6)


def test_evaluation_puts_back_what_else_the_action_animates():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    limit = obj.pose.bones["shin.L"].constraints.new("LIMIT_LOCATION")
    limit.influence, obj['the "switch"'], obj.pose.bones["hips"]["fk"] = 0.25, 0.5, 7
    obj.color = (0.1, 0.2, 0.3, 0.4)
    obj.data.pose_position = "REST"
    name = bpy.utils.escape_identifier('the "switch"')
    for path, index in (
        ('pose.bones["shin.L"].constraints["Limit Location"].influence', 0),
        (f'["{name}"]', 0),
        ('pose.bones["hips"]["fk"]', 0),
        ("color", 2),
        ('pose.bones["gone"]["fk"]', 0),
        ('pose.bones["hips"]', 0),
        ("data", 0),
        ("pose.bones", 0),
    ):
        add_curve(action, path, index, (1, 30), (1, 0))
    clip = read_clip(obj, action)
    assert np.ptp(clip.translations[:, 0], axis=0).max() > 0.1
    assert limit.influence == 0.25 and obj['the "switch"'] == 0.5 and obj.pose.bones["hips"]["fk"] == 7
    np.testing.assert_allclose(obj.color, (0.1, 0.2, 0.3, 0.4))
    assert obj.data.pose_position == "REST" and obj.animation_data is None


@pytest.mark.parametrize("breaks", [False, True], ids=["read", "broken off"])
def test_evaluation_keeps_poses_and_moves_that_were_not_keyed(breaks, monkeypatch):
    obj = armature()
    played, action = new_action(obj, "played"), new_action(obj)
    animate(obj, played, MODES, seed=3)
    animate(obj, action, MODES, seed=4)
    obj["dial"] = 0.0
    add_curve(played, '["dial"]', 0, (1, 30), (1, 0))
    obj.animation_data_create().action = played
    other = bpy.data.objects.new("Pillar", None)
    bpy.context.scene.collection.objects.link(other)
    moves = bpy.data.actions.new("moves")
    other.animation_data_create().action = moves
    add_curve(moves, "location", 0, (1, 30), (0, 5), slot=add_slot(moves, "Pillar"))
    other.animation_data.action_slot = moves.slots[0]
    obj.pose.bones["shin.L"].constraints.new("LIMIT_DISTANCE")
    bpy.context.scene.frame_set(9)
    # All of it is animated, and none of it keyed.
    for bone in obj.pose.bones:
        bone.location, bone.rotation_quaternion = (0.1, 0.2, 0.3), (0.5, 0.5, -0.5, 0.5)
        bone.rotation_euler, bone.rotation_axis_angle = (0.1, 0.2, 0.3), (0.4, 0.0, 0.6, 0.8)
    other.location, obj["dial"] = (7.25, 1.5, -2.0), 0.625
    bpy.context.view_layer.update()
    scenes = len(bpy.data.scenes)

    def state():
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        shown = [tuple(map(tuple, bone.matrix)) for bone in evaluated.pose.bones]
        kept = [
            tuple(map(tuple, (b.location, b.rotation_quaternion, b.rotation_euler, b.rotation_axis_angle, b.scale)))
            for b in obj.pose.bones
        ]
        return shown, kept, tuple(other.location), tuple(map(tuple, other.matrix_world)), obj["dial"]

    before = state()
    if breaks:

        def fail(*_):
            raise RuntimeError

        monkeypatch.setattr(evaluated_pose, "read_matrices", fail)
        with pytest.raises(RuntimeError):
            read_clip(obj, action)
    else:
        read_clip(obj, action)
    assert state() == before
    assert bpy.context.scene.frame_current == 9 and len(bpy.data.scenes) == scenes
    # It does not come late either.
    bpy.context.view_layer.update()
    assert state() == before


def test_keys_of_an_array_that_was_made_shorter_are_left_out():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    obj.pose.bones["shin.L"].constraints.new("LIMIT_LOCATION")
    for place in (0, 2):
        add_curve(action, '["dial"]', place, (1, 30), (1, 0))
    obj["dial"] = [1.0, 2.0, 3.0]
    whole = read_clip(obj, action)
    assert list(obj["dial"]) == [1.0, 2.0, 3.0]
    obj["dial"] = [1.0, 2.0]
    shorter = read_clip(obj, action)
    assert list(obj["dial"]) == [1.0, 2.0]
    np.testing.assert_array_equal(shorter.rotations, whole.rotations)


@pytest.mark.parametrize(
    ("of", "frame"),
    [
        *((of, float(frame)) for of in ("all last keys", "one last key") for frame in ("nan", "inf", "-inf", "3e30")),
        ("manual range", float("nan")),
        ("manual range", float("inf")),
    ],
)
def test_keys_where_no_frame_is(frame, of):
    obj = armature()
    good, broken = new_action(obj, "good"), new_action(obj, "broken")
    for action in (good, broken):
        animate(obj, action, MODES)
    curves = broken.layers[0].strips[0].channelbag(broken.slots[0]).fcurves
    if of == "manual range":
        broken.use_frame_range = True
        broken.frame_end = frame
    else:
        for curve in curves if of == "all last keys" else curves[3:4]:
            curve.keyframe_points[-1].co.x = frame
    clips, [(name, reason)] = read_clips(obj, [good, broken])
    assert [clip.name for clip in clips] == ["good"] and name == "broken"
    assert "'broken'" in reason and "not a number" in reason and "repair" in reason


def test_connected_bones_do_not_move():
    obj = armature(connect=True)
    action = new_action(obj)
    animate(obj, action, MODES, moving=("hips", "spine", "shin.L"))
    clip = read_clip(obj, action)
    assert_like_blender(clip, obj, action)
    assert np.ptp(clip.translations[:, clip.skeleton.index("spine")], axis=0).max() == 0


def test_two_slots_in_one_action():
    one, two = armature("One"), armature("Two")
    action = bpy.data.actions.new("both")
    first, second = add_slot(action, "One"), add_slot(action, "Two")
    camera = action.slots.new("CAMERA", "Camera")
    animate(one, action, MODES, seed=1, frames=(1, 20), slot=first)
    animate(two, action, MODES, seed=2, frames=(5, 14), slot=second)
    assert camera is not None
    one.animation_data_create().action = action
    one.animation_data.action_slot = second
    clip = read_clip(one, action)  # the slot that is assigned, whatever its name
    assert clip.first_frame == 5 and clip.n_frames == 10
    assert_like_blender(clip, one, action, second)  # unassigns the action
    clip = read_clip(one, action)  # the slot that it used last
    assert clip.n_frames == 10
    one.animation_data.action = action
    one.animation_data.action_slot = first
    one.animation_data.action = None
    clip = read_clip(one, action)
    assert clip.n_frames == 20
    assert_like_blender(clip, one, action, first)


def test_assigned_slot_even_if_another_animates_more():
    obj = armature()
    action = bpy.data.actions.new("both")
    more, fewer = add_slot(action, "More"), add_slot(action, "Fewer")
    animate(obj, action, MODES, slot=more)
    add_curve(action, 'pose.bones["hips"].location', 0, (3, 9), (0, 1), slot=fewer)
    assert read_clip(obj, action).n_frames == 30
    obj.animation_data_create().action = action
    obj.animation_data.action_slot = fewer
    assert read_clip(obj, action).n_frames == 7


def test_slot_of_another_object_in_the_same_action():
    obj = armature()
    action = bpy.data.actions.new("both")
    prop, own = add_slot(action, "Prop"), add_slot(action, "Rig")
    add_curve(action, "location", 0, (1, 99), (0, 5), slot=prop)
    animate(obj, action, MODES, slot=own)
    clip = read_clip(obj, action)
    assert clip.n_frames == 30
    assert_like_blender(clip, obj, action, own)


def test_frame_rates():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    bpy.context.scene.render.fps, bpy.context.scene.render.fps_base = 30, 1.001
    assert read_clip(obj, action).frame_rate == pytest.approx(29.97003)
    action["wayfarer_frame_rate"] = 120.0
    assert read_clip(obj, action).frame_rate == 120
    assert read_clip(obj, action, frame_rate=60).frame_rate == 60


@pytest.mark.parametrize("rate", [0, -1.0, float("nan"), "fast"])
def test_impossible_frame_rates(rate):
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    action["wayfarer_frame_rate"] = rate
    with pytest.raises(ClipError, match=r"wayfarer_frame_rate.*'walk'"):
        read_clip(obj, action)


def test_curve_of_a_modifier_alone():
    obj = armature()
    action = new_action(obj)
    add_curve(action, 'pose.bones["spine"].location', 0, (10, 20), (0, 1))
    curve = action.layers[0].strips[0].channelbag(action.slots[0]).fcurves.new('pose.bones["hips"].location', index=0)
    curve.modifiers.new("GENERATOR")
    clip = read_clip(obj, action)
    assert clip.first_frame == 10 and clip.n_frames == 11
    assert_like_blender(clip, obj, action)


def test_actions_of_a_character():
    obj = armature()
    walk, other, prop = new_action(obj, "walk"), new_action(obj, "other"), new_action(obj, "prop")
    add_curve(walk, 'pose.bones["hips"].location', 0, (1, 9), (0, 1))
    add_curve(other, 'pose.bones["wing"].location', 0, (1, 9), (0, 1))
    add_curve(prop, "location", 0, (1, 9), (0, 1))
    assert actions_of(obj) == [walk]


def test_names_that_need_escaping():
    obj = armature()
    obj.data.bones["hips"].name = 'the "hips"\\['
    action = new_action(obj)
    add_curve(
        action, f'pose.bones["{bpy.utils.escape_identifier(obj.data.bones[0].name)}"].location', 1, (1, 9), (0, 3)
    )
    clip = read_clip(obj, action)
    assert_like_blender(clip, obj, action)
    assert np.ptp(clip.translations[:, 0]) > 1


def test_problems_are_named():
    obj = armature()
    good, strange, short, broken = (new_action(obj, name) for name in ("good", "strange", "short", "broken"))
    animate(obj, good, MODES)
    add_curve(strange, 'pose.bones["wing"].location', 0, (1, 9), (0, 1))
    add_curve(strange, "location", 0, (1, 9), (0, 1))
    add_curve(short, 'pose.bones["hips"].location', 0, (4,), (0,))
    add_curve(broken, 'pose.bones["shin.L"].location', 0, (1, 9), (0, float("nan")), "LINEAR")
    empty = bpy.data.actions.new("empty")
    clips, problems = read_clips(obj, [strange, good, short, broken, empty])
    assert [clip.name for clip in clips] == ["good"]
    reasons = dict(problems)
    assert set(reasons) == {"strange", "short", "broken", "empty"}
    assert "none of the bones of 'Rig'" in reasons["strange"] and "'strange'" in reasons["strange"]
    assert "two frames" in reasons["short"] and "'short'" in reasons["short"]
    assert "'shin.L'" in reasons["broken"] and "'broken'" in reasons["broken"]
    with pytest.raises(ClipError, match="no actions"):
        read_clips(obj, [])


def test_uneven_scale_is_refused():
    obj = armature()
    action = new_action(obj)
    animate(obj, action, MODES)
    for scale in ((1, 1, 1.2), (-1, -1, -1), (0, 0, 0)):
        obj.scale = scale
        with pytest.raises(ClipError, match=r"'Rig'.*Scale"):
            read_clip(obj, action)


def test_tags_from_markers_and_property():
    action = bpy.data.actions.new("walk")
    for name, frame in (("step", 5), ("/step", 8), ("step", 12), ("/jump", 4), ("open", 14)):
        action.pose_markers.new(name).frame = frame
    action["wayfarer_tags"] = "walk, slow"
    frames = np.arange(1, 16)
    tags = read_tags(action, frames)
    assert set(tags) == {"step", "jump", "open", "walk", "slow"}
    assert list(frames[tags["step"]]) == [5, 6, 7, 12, 13, 14, 15]
    assert list(frames[tags["jump"]]) == [1, 2, 3]
    assert list(frames[tags["open"]]) == [14, 15]
    assert tags["walk"].all() and tags["slow"].all()


def test_tags_survive_writing():
    rng = np.random.default_rng(2)
    masks = {f"tag {i}": rng.random(50) < p for i, p in enumerate((0.1, 0.5, 0.9))} | {"all": np.ones(50, bool)}
    action = bpy.data.actions.new("walk")
    for _ in range(2):  # the second time replaces the first
        write_tags(action, masks, first_frame=-3)
        again = read_tags(action, np.arange(-3, 47))
        assert set(again) == set(masks)
        for name, mask in masks.items():
            np.testing.assert_array_equal(again[name], mask)
