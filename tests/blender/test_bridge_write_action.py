"""Writing clips on rigs and reading them back."""

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bl_ext.user_default.wayfarer.addon.bridge.create_armature import create_armature
from bl_ext.user_default.wayfarer.addon.bridge.read_actions import read_clip
from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig
from bl_ext.user_default.wayfarer.addon.bridge.write_action import (
    animated_bones,
    assign_action,
    write_clip,
)
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.motion import quat
from bl_ext.user_default.wayfarer.core.motion.clip import MotionClip
from bl_ext.user_default.wayfarer.core.motion.kinematics import world_transforms
from bl_ext.user_default.wayfarer.core.motion.repertoire import (
    sample_bone_lengths,
    sample_repertoire,
    sample_skeleton,
)
from bl_ext.user_default.wayfarer.core.motion.skeleton import Skeleton

MODES = ("QUATERNION", "AXIS_ANGLE", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def random_walk(skeleton, n_frames=60, seed=0, frame_rate=24.0, moving=()):
    """A clip in which every joint turns smoothly and widely, also through Euler angles' poles."""
    rng = np.random.default_rng(seed)
    times = np.linspace(0, 1, n_frames)[:, None, None]
    rates, phases = rng.uniform(1, 6, (2, 1, skeleton.n_joints, 3))
    vectors = 1.8 * np.sin(rates * times + phases)
    turns = Rotation.from_rotvec(vectors.reshape(-1, 3))
    rests = Rotation.from_quat(np.tile(skeleton.rest_rotations, (n_frames, 1)), scalar_first=True)
    rotations = (rests * turns).as_quat(scalar_first=True).reshape(n_frames, -1, 4)
    translations = np.tile(skeleton.rest_translations, (n_frames, 1, 1))
    translations[:, 0] += np.array([2.0, -1.0, 0.1]) * times[:, 0] + np.array([5.0, 3.0, 0.0])
    for joint in moving:
        translations[:, joint] += 0.1 * np.sin(3 * times[:, 0])
    return MotionClip("walk", skeleton, frame_rate, rotations, translations)


def sample_armature(name="Character"):
    armature = create_armature(sample_skeleton(), {}, name, bpy.context.scene.collection)
    bpy.context.view_layer.update()
    return armature


def assert_same_motion(clip, other, names=None, atol=1e-4):
    """Joint positions agree for all joints (metres), world rotations too if they are said to."""
    names = names or clip.skeleton.names
    mine = [clip.skeleton.index(name) for name in names]
    theirs = [other.skeleton.index(name) for name in names]
    np.testing.assert_allclose(other.world[1][:, theirs], clip.world[1][:, mine], atol=atol)


def assert_same_rotations(clip, other, atol=1e-4):
    assert clip.skeleton.names == other.skeleton.names
    dots = np.abs(np.sum(clip.rotations * other.rotations, axis=2))
    np.testing.assert_allclose(2 * np.arccos(np.minimum(dots, 1)), 0, atol=2e-3)
    np.testing.assert_allclose(dots, 1, atol=atol)


@pytest.mark.parametrize("mode", MODES)
def test_round_trip_in_every_rotation_mode(mode):
    armature = sample_armature()
    for bone in armature.pose.bones:
        bone.rotation_mode = mode
    armature.location = (3.0, -2.0, 0.5)
    armature.rotation_euler = (0.1, 0.2, 1.3)
    armature.scale = (0.7, 0.7, 0.7)
    binding = bind_rig(armature)
    clip = random_walk(binding.skeleton, moving=[3])
    action = write_clip(armature, clip, "baked", first_frame=11)
    again = read_clip(armature, action)
    assert again.first_frame == 11 and again.frame_rate == clip.frame_rate
    assert_same_rotations(clip, again)
    np.testing.assert_allclose(again.translations, clip.translations, atol=1e-4)
    np.testing.assert_allclose(again.ground_path, clip.ground_path, atol=1e-4)


AXIS_ORDERS = {"X": (0, 1, 2), "Y": (1, 0, 2), "Z": (1, 2, 0)}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("about", AXIS_ORDERS)
def test_curves_do_not_jump(mode, about):
    armature = sample_armature()
    for bone in armature.pose.bones:
        bone.rotation_mode = mode
    skeleton = bind_rig(armature).skeleton
    # Whole turns of every joint about nearly one axis. About the middle axis of an Euler order they pass both
    # poles, where the angles run, but they do not jump there: the second solution goes on where the first ends.
    n_frames = 600
    angles = np.linspace(0, 5 * np.pi, n_frames)
    axis = np.array([1.0, 0.2, 0.1])[list(AXIS_ORDERS[about])] / np.linalg.norm([1.0, 0.2, 0.1])
    turns = Rotation.from_rotvec(angles[:, None] * axis)
    rotations = np.stack(
        [
            (Rotation.from_quat(rest, scalar_first=True) * turns).as_quat(scalar_first=True)
            for rest in skeleton.rest_rotations
        ],
        axis=1,
    )
    rotations[::2] *= -1  # the same rotations
    clip = MotionClip("spin", skeleton, 24.0, rotations, np.tile(skeleton.rest_translations, (n_frames, 1, 1)))
    action = write_clip(armature, clip, "spin")
    steps = []
    for curve in action.layers[0].strips[0].channelbag(action.slots[0]).fcurves:
        if ".rotation" in curve.data_path:
            keys = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
            curve.keyframe_points.foreach_get("co", keys)
            steps.append(np.abs(np.diff(keys[1::2])).max())
    assert len(steps) == skeleton.n_joints * (4 if mode in ("QUATERNION", "AXIS_ANGLE") else 3)
    assert max(steps) < 0.5
    again = read_clip(armature, action)
    assert_same_rotations(clip, again)


@pytest.mark.parametrize("mode", MODES[2:])
def test_euler_angles_pass_their_poles(mode):
    """Turns about the middle axis alone: past a quarter turn only the second solution goes on evenly."""
    armature = sample_armature()
    for bone in armature.pose.bones:
        bone.rotation_mode = mode
    skeleton = bind_rig(armature).skeleton
    turns = Rotation.from_euler(mode[1], np.linspace(0, 5 * np.pi, 121)[:, None] + 0.01)
    rests = Rotation.from_quat(skeleton.rest_rotations, scalar_first=True)
    rotations = np.stack([(rest * turns).as_quat(scalar_first=True) for rest in rests], axis=1)
    clip = MotionClip("spin", skeleton, 24.0, rotations, np.tile(skeleton.rest_translations, (121, 1, 1)))
    action = write_clip(armature, clip, "spin")
    for curve in action.layers[0].strips[0].channelbag(action.slots[0]).fcurves:
        keys = np.empty(2 * 121, dtype=np.float32)
        curve.keyframe_points.foreach_get("co", keys)
        if curve.data_path.endswith("rotation_euler"):
            step = 5 * np.pi / 120 if curve.array_index == "XYZ".index(mode[1]) else 0
            np.testing.assert_allclose(np.diff(keys[1::2]), step, atol=1e-3)


def test_blender_shows_what_was_written():
    armature = sample_armature()
    armature.location = (1.0, 2.0, 0.0)
    armature.rotation_euler = (0.0, 0.0, 2.0)
    armature.scale = (2.0, 2.0, 2.0)
    for index, bone in enumerate(armature.pose.bones):
        bone.rotation_mode = MODES[index % len(MODES)]
    clip = random_walk(bind_rig(armature).skeleton, moving=[5])
    action = write_clip(armature, clip, "baked")
    assert armature.animation_data is None
    assign_action(armature, action)
    for frame in (1, 17, 60):
        bpy.context.scene.frame_set(frame)
        for joint, name in enumerate(clip.skeleton.names):
            head = armature.matrix_world @ armature.pose.bones[name].head
            np.testing.assert_allclose(head, clip.world[1][frame - 1, joint], atol=2e-5)


def with_other_axes(skeleton, seed=5):
    """The same rest pose with arbitrarily turned joint axes."""
    turns = Rotation.random(skeleton.n_joints, random_state=seed)
    local = Rotation.from_quat(skeleton.rest_rotations, scalar_first=True)
    parents = np.maximum(skeleton.parents, 0)
    before = turns[parents].inv()
    rotations = (before * local * turns).as_quat(scalar_first=True)
    translations = before.apply(skeleton.rest_translations)
    rotations[0] = (local[0] * turns[0]).as_quat(scalar_first=True)
    translations[0] = skeleton.rest_translations[0]
    return Skeleton(skeleton.names, skeleton.parents, rotations, translations, turns[0].inv().apply(skeleton.forward))


@pytest.mark.parametrize("turned", [0.0, 2.5])
def test_joint_axes_need_not_be_the_bones(turned):
    armature = sample_armature()
    armature.rotation_euler.z = turned
    clip = random_walk(with_other_axes(sample_skeleton()), moving=[4])
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert_same_motion(clip, again)
    np.testing.assert_allclose(again.ground_path, clip.ground_path, atol=1e-4)


def test_vertical_chain_without_pairs():
    chain = Skeleton(
        ("a", "b", "c"),
        np.array([-1, 0, 1]),
        np.tile([1.0, 0, 0, 0], (3, 1)),
        np.array([[0.0, 0, 1], [0, 0, 0.5], [0, 0, 0.5]]),
        np.array([1.0, 0.0, 0.0]),
    )
    armature = create_armature(chain, {"c": np.array([0, 0, 2.4])}, "Chain", bpy.context.scene.collection)
    clip = random_walk(chain)
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert_same_motion(clip, again)


def test_bones_above_the_clips_root():
    chain = Skeleton(
        ("b", "c"),
        np.array([-1, 0]),
        np.tile([1.0, 0, 0, 0], (2, 1)),
        np.array([[0.0, 0.2, 1], [0, 0, 0.5]]),
        np.array([1.0, 0.0, 0.0]),
    )
    longer = Skeleton(
        ("a", *chain.names),
        np.array([-1, 0, 1]),
        np.tile([1.0, 0, 0, 0], (3, 1)),
        np.array([[0.0, 0, 0.3], [0, 0.2, 0.7], [0, 0, 0.5]]),
        chain.forward,
    )
    armature = create_armature(longer, {}, "Chain", bpy.context.scene.collection)
    clip = random_walk(chain)
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert again.skeleton.names[0] == "a"
    assert_same_motion(clip, again)


def test_armature_can_be_turned_between_reading_and_writing():
    armature = sample_armature()
    armature.rotation_euler = (0.4, -0.3, 1.0)
    clip = random_walk(bind_rig(armature).skeleton)
    armature.rotation_euler = (-0.5, 0.2, -2.0)
    armature.location = (4, 4, 0)
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert_same_rotations(clip, again)
    assert_same_motion(clip, again)


def test_created_armature_has_the_skeletons_rest_pose():
    skeleton = sample_skeleton()
    again = bind_rig(sample_armature()).skeleton
    assert set(again.names) == set(skeleton.names) and again.names[0] == skeleton.names[0]
    for joint, name in enumerate(skeleton.names):
        bone = again.index(name)
        if joint > 0:
            assert again.names[again.parents[bone]] == skeleton.names[skeleton.parents[joint]]
        np.testing.assert_allclose(again.rest_translations[bone], skeleton.rest_translations[joint], atol=1e-6)
    np.testing.assert_allclose(again.forward, skeleton.forward, atol=1e-6)


def test_created_bones_can_have_the_joints_axes():
    skeleton = sample_skeleton()
    rotations, positions = world_transforms(
        skeleton.rest_rotations[None], skeleton.rest_translations[None], skeleton.parents
    )
    along = quat.rotate(rotations[0], [0.0, 1.0, 0.0])
    tails = dict(zip(skeleton.names, positions[0] + sample_bone_lengths()[:, None] * along, strict=True))
    armature = create_armature(skeleton, tails, "Character", bpy.context.scene.collection)
    again = bind_rig(armature).skeleton
    for joint, name in enumerate(skeleton.names):
        dot = abs(again.rest_rotations[again.index(name)] @ skeleton.rest_rotations[joint])
        assert dot == pytest.approx(1, abs=1e-9)
        tail = armature.data.bones[name].tail_local
        np.testing.assert_allclose(tail, tails[name], atol=1e-6)


def test_created_in_a_collection_that_is_not_shown():
    collection = bpy.data.collections.new("Elsewhere")
    armature = create_armature(sample_skeleton(), {}, "Character", collection)
    assert list(armature.users_collection) == [collection]
    assert len(armature.data.bones) == sample_skeleton().n_joints
    clip = random_walk(bind_rig(armature).skeleton)
    assert_same_motion(clip, read_clip(armature, write_clip(armature, clip, "baked")))


def test_resampled_to_the_scene():
    armature = sample_armature()
    bpy.context.scene.render.fps = 30
    clip = random_walk(bind_rig(armature).skeleton, n_frames=121, frame_rate=120.0)
    action = write_clip(armature, clip, "baked")
    assert tuple(action.frame_range) == (1, 31)
    np.testing.assert_allclose(read_clip(armature, action).translations, clip.translations[::4], atol=1e-4)


def test_tags_are_written_and_read():
    armature = sample_armature()
    clip = random_walk(bind_rig(armature).skeleton)
    step = np.zeros(clip.n_frames, dtype=bool)
    step[5:20] = step[40:] = True
    tags = {"step": step, "walk": np.ones(clip.n_frames, dtype=bool)}
    clip = MotionClip("walk", clip.skeleton, 24.0, clip.rotations, clip.translations, tags)
    again = read_clip(armature, write_clip(armature, clip, "baked", first_frame=7))
    assert set(again.tags) == {"step", "walk"}
    for name, mask in tags.items():
        np.testing.assert_array_equal(again.tags[name], mask)


def test_sample_character_shows_its_repertoire():
    armature = sample_armature()
    bpy.context.scene.render.fps = 30
    clips = sample_repertoire()
    for clip in clips:
        again = read_clip(armature, write_clip(armature, clip, clip.name))
        expected = clip.resampled(30.0)
        assert_same_motion(expected, again)
        np.testing.assert_allclose(again.ground_path, expected.ground_path, atol=1e-4)
        assert {name: list(mask) for name, mask in again.tags.items()} == {
            name: list(mask) for name, mask in expected.tags.items() if np.any(mask)
        }


def test_a_minute_of_a_long_chain():
    chain = Skeleton(
        tuple(f"bone {i}" for i in range(31)),
        np.arange(-1, 30),
        np.tile([1.0, 0, 0, 0], (31, 1)),
        np.tile([0.0, 0, 0.1], (31, 1)),
        np.array([0.0, -1.0, 0.0]),
    )
    armature = create_armature(chain, {}, "Chain", bpy.context.scene.collection)
    for bone in armature.pose.bones:
        bone.rotation_mode = "XYZ"
    clip = random_walk(chain, n_frames=1800)
    assert_same_motion(clip, read_clip(armature, write_clip(armature, clip, "long")))


def test_nothing_else_changes():
    armature = sample_armature()
    clip = random_walk(bind_rig(armature).skeleton)
    first = write_clip(armature, clip, "first")
    assign_action(armature, first)
    bpy.context.scene.frame_set(20)
    pose = [np.array(bone.matrix_basis) for bone in armature.pose.bones]
    second = write_clip(armature, clip, "second", first_frame=100)
    assert second != first and armature.animation_data.action == first
    assert tuple(first.frame_range) == (1, 60) and bpy.context.scene.frame_current == 20
    for before, bone in zip(pose, armature.pose.bones, strict=True):
        np.testing.assert_array_equal(before, np.array(bone.matrix_basis))


@pytest.mark.parametrize("setting", ["use_inherit_rotation", "use_local_location"])
def test_bones_that_do_not_follow_their_parent(setting):
    armature = sample_armature()
    armature.rotation_euler.z = 1.0
    for name in ("Hips", "Spine1", "Head", "LeftLeg"):
        setattr(armature.data.bones[name], setting, False)
    clip = random_walk(bind_rig(armature).skeleton, moving=[2, 3])
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert_same_rotations(clip, again)
    np.testing.assert_allclose(again.translations, clip.translations, atol=1e-4)


def test_only_the_controls_of_a_constrained_rig():
    armature = sample_armature()
    copy = armature.pose.bones["LeftLeg"].constraints.new("COPY_ROTATION")
    copy.target, copy.subtarget = armature, "RightLeg"
    copy.mix_mode, copy.target_space, copy.owner_space = "ADD", "LOCAL", "LOCAL"
    controls = {"Hips", "LeftUpLeg", "RightLeg", "LeftFoot"}
    source = random_walk(bind_rig(armature).skeleton)
    posed = write_clip(armature, source, "posed", only_bones=controls)
    assert animated_bones(armature, [posed]) == controls
    clip = read_clip(armature, posed)
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert_same_motion(clip, again)
    doubled = read_clip(armature, write_clip(armature, clip, "doubled", only_bones=clip.skeleton.names))
    foot = clip.skeleton.index("LeftFoot")
    assert np.abs(doubled.world[1][:, foot] - clip.world[1][:, foot]).max() > 0.05


def test_connected_root_cannot_travel():
    armature = sample_armature()
    clip = random_walk(bind_rig(armature).skeleton)
    bpy.ops.object.mode_set(mode="EDIT")
    ground = armature.data.edit_bones.new("ground")
    ground.tail = armature.data.edit_bones["Hips"].head
    armature.data.edit_bones["Hips"].parent = ground
    armature.data.edit_bones["Hips"].use_connect = True
    bpy.ops.object.mode_set(mode="OBJECT")
    n_actions = len(bpy.data.actions)
    with pytest.raises(ClipError, match=r"'Hips'.*Connected"):
        write_clip(armature, clip, "baked")
    assert len(bpy.data.actions) == n_actions


def test_root_below_a_ground_bone():
    armature = sample_armature()
    clip = random_walk(bind_rig(armature).skeleton)
    bpy.ops.object.mode_set(mode="EDIT")
    ground = armature.data.edit_bones.new("ground")
    ground.tail = (0.1, 0.2, 0.3)
    armature.data.edit_bones["Hips"].parent = ground
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bind_rig(armature).skeleton.names[0] == "Hips"
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert_same_motion(clip, again)


@pytest.mark.parametrize("root", ["ground", "Spine"])
def test_another_root_than_the_rigs_own(root):
    armature = sample_armature()
    bpy.ops.object.mode_set(mode="EDIT")
    ground = armature.data.edit_bones.new("ground")
    ground.tail = (0.1, 0.2, 0.3)
    armature.data.edit_bones["Hips"].parent = ground
    bpy.ops.object.mode_set(mode="OBJECT")
    clip = random_walk(bind_rig(armature, root_bone=root).skeleton)
    assert clip.skeleton.names[0] == root
    again = read_clip(armature, write_clip(armature, clip, "baked"))
    assert again.skeleton.names[0] == "Hips"
    assert_same_motion(clip, again)


def test_one_group_for_each_bone():
    armature = sample_armature()
    clip = random_walk(bind_rig(armature).skeleton, moving=[3])
    action = write_clip(armature, clip, "baked")
    channelbag = action.layers[0].strips[0].channelbag(action.slots[0])
    assert sorted(group.name for group in channelbag.groups) == sorted(clip.skeleton.names)
    for curve in channelbag.fcurves:
        assert f'"{curve.group.name}"' in curve.data_path
    assert len(action.slots) == 1 and action.slots[0].identifier == "OBCharacter"


def test_no_such_root():
    armature = sample_armature()
    clip = random_walk(bind_rig(armature).skeleton)
    armature.data.bones["Hips"].name = "Pelvis"
    with pytest.raises(ClipError, match="Hips"):
        write_clip(armature, clip, "baked")
