"""Armatures as skeletons: which bone is the root, where the character faces, what hangs from what."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.rig import bind_rig
from bl_ext.user_default.wayfarer.core.errors import ClipError
from bl_ext.user_default.wayfarer.core.motion import quat
from bl_ext.user_default.wayfarer.core.motion.kinematics import world_transforms
from bl_ext.user_default.wayfarer.core.motion.sides import mirrored_pairs

# Bone, parent, head; all bones are 10 cm long. The left is at +X: the characters face -Y.
MIXAMO = [
    ("mixamorig:Hips", None, (0, 0, 1)),
    ("mixamorig:Spine", "mixamorig:Hips", (0, 0, 1.1)),
    ("mixamorig:LeftArm", "mixamorig:Spine", (0.2, 0.1, 1.4)),
    ("mixamorig:RightArm", "mixamorig:Spine", (-0.2, 0, 1.4)),
    ("mixamorig:LeftUpLeg", "mixamorig:Hips", (0.1, 0, 0.9)),
    ("mixamorig:RightUpLeg", "mixamorig:Hips", (-0.1, 0, 0.9)),
]
UNREAL = [
    ("root", None, (0, 0, 0)),
    ("pelvis", "root", (0, 0, 1)),
    ("spine_01", "pelvis", (0, 0, 1.1)),
    ("clavicle_l", "spine_01", (0.05, 0, 1.4)),
    ("clavicle_r", "spine_01", (-0.05, 0, 1.4)),
    ("thigh_l", "pelvis", (0.1, 0, 0.9)),
    ("thigh_r", "pelvis", (-0.1, 0, 0.9)),
    ("ik_hand_root", "root", (0, 0, 0)),
    ("ik_hand_l", "ik_hand_root", (0.5, 0.2, 1)),
    ("ik_hand_r", "ik_hand_root", (-0.5, 0, 1)),
    ("ik_foot_l", "root", (0.3, 0.4, 0)),
    ("ik_foot_r", "root", (-0.3, 0, 0)),
]
BIPED = [
    ("Bip01", None, (0, 0, 1)),
    ("Bip01 Pelvis", "Bip01", (0, 0, 1)),
    ("Bip01 Spine", "Bip01 Pelvis", (0, 0, 1.1)),
    ("Bip01 L Thigh", "Bip01 Spine", (0.1, 0, 0.9)),
    ("Bip01 R Thigh", "Bip01 Spine", (-0.1, 0, 0.9)),
]
CONTROLLED = [
    ("pole.L", None, (0.4, -1, 0.5)),
    ("pole.R", None, (-0.4, -2, 0.5)),
    ("hips", None, (0, 0, 1)),
    ("thigh.L", "hips", (0.1, 0, 0.9)),
    ("thigh.R", "hips", (-0.1, 0, 0.9)),
    ("foot target.L", None, (0.1, 0, 0)),
]
SNAKE = [
    ("camera", None, (0, 2, 0)),
    ("a", None, (0, 0, 0.1)),
    ("b", "a", (0, 1, 0.1)),
    ("c", "b", (0, 2, 0.1)),
]


def build(bones, controls=(), name="Rig"):
    data = bpy.data.armatures.new(name)
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    for bone, parent, head in bones:
        new = data.edit_bones.new(bone)
        new.head, new.tail = head, np.add(head, (0.02, 0.06, 0.08))
        new.roll = len(bone)
        new.use_deform = bone not in controls
        if parent:
            new.parent = data.edit_bones[parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    return obj


def facing(binding):
    """World direction of the character in its rest pose."""
    skeleton = binding.skeleton
    return quat.rotate(skeleton.rest_rotations[0], skeleton.forward)


@pytest.mark.parametrize(
    ("bones", "controls", "root"),
    [
        (MIXAMO, (), "mixamorig:Hips"),
        (UNREAL, (), "pelvis"),
        (BIPED, (), "Bip01 Spine"),
        (CONTROLLED, ("pole.L", "pole.R", "foot target.L"), "hips"),
        (SNAKE, ("camera",), "a"),
    ],
    ids=["mixamo", "unreal", "biped", "controlled", "snake"],
)
def test_root_forward_and_rest_pose(bones, controls, root):
    obj = build(bones, controls)
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0, 0, np.pi / 2), (2, 2, 2)
    binding = bind_rig(obj)
    skeleton = binding.skeleton
    assert skeleton.names[0] == root and sorted(skeleton.names) == sorted(name for name, _, _ in bones)
    np.testing.assert_allclose(facing(binding), [1, 0, 0], atol=1e-6)
    _, positions = world_transforms(skeleton.rest_rotations[None], skeleton.rest_translations[None], skeleton.parents)
    parents = {name: parent for name, parent, _ in bones}
    for joint, name in enumerate(skeleton.names):
        expected = obj.matrix_world @ obj.data.bones[name].head_local
        np.testing.assert_allclose(positions[0, joint], expected, atol=1e-5)
        if binding.keeps_parent[joint]:
            assert skeleton.names[skeleton.parents[joint]] == parents[name]
        elif joint > 0:
            assert skeleton.parents[joint] == 0


def test_root_and_forward_can_be_chosen():
    obj = build(UNREAL)
    assert bind_rig(obj, root_bone="root").skeleton.names[0] == "root"
    with pytest.raises(ClipError, match="'tail'"):
        bind_rig(obj, root_bone="tail")
    np.testing.assert_allclose(facing(bind_rig(obj, forward=(2, 0, 0))), [1, 0, 0], atol=1e-6)
    obj["wayfarer_forward"] = (0.0, 1.0, 0.0)
    np.testing.assert_allclose(facing(bind_rig(obj)), [0, 1, 0], atol=1e-6)


@pytest.mark.parametrize(
    "value",
    [
        *("front", b"xyz", 5, 2.5, True, {"a": 1, "b": 2, "c": 3}, ["a", "b", "c"], [[1, 2], [3, 4], [5, 6]]),
        *([1.0, 2.0], [0, 1, 0, 0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.01, -1.0]),
        *([np.nan, 0.0, 1.0], [np.inf, 1.0, 0.0], [1e300, 1e300, 0.0]),
    ],
    ids=str,
)
def test_a_direction_that_nobody_can_face_is_named(value):
    obj = build(UNREAL)
    obj["wayfarer_forward"] = value
    with pytest.raises(ClipError, match=r"'Rig'.* wayfarer_forward .*three numbers; correct or remove it"):
        bind_rig(obj)
    del obj["wayfarer_forward"]
    np.testing.assert_allclose(facing(bind_rig(obj)), [0, -1, 0], atol=1e-6)


def test_forward_may_point_anywhere_in_an_armature_that_lies_in_its_object():
    """What counts is that it is level in the world; whole numbers do as well."""
    obj = build(UNREAL)
    obj.rotation_euler.x, obj["wayfarer_forward"] = np.pi / 2, [0, 0, 2]
    np.testing.assert_allclose(facing(bind_rig(obj)), [0, -1, 0], atol=1e-6)
    obj["wayfarer_forward"] = [0, 1, 0]
    with pytest.raises(ClipError, match="horizontal"):
        bind_rig(obj)


def test_upright_whatever_the_armatures_axes():
    """Y-up bones in an object turned upright, as FBX files bring them."""
    obj = build([(name, parent, (x, z, -y)) for name, parent, (x, y, z) in MIXAMO])
    obj.rotation_euler.x, obj.scale = np.pi / 2, (0.01, 0.01, 0.01)
    binding = bind_rig(obj)
    np.testing.assert_allclose(facing(binding), [0, -1, 0], atol=1e-6)
    np.testing.assert_allclose(binding.skeleton.rest_translations[0], [0, 0, 0.01], atol=1e-6)


def test_no_armature():
    mesh = bpy.data.objects.new("Mesh", bpy.data.meshes.new("Mesh"))
    with pytest.raises(ClipError, match="'Mesh' is not an armature"):
        bind_rig(mesh)
    with pytest.raises(ClipError, match="not an armature"):
        bind_rig(None)
    with pytest.raises(ClipError, match="no bones"):
        bind_rig(build([]))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("LeftUpLeg", "RightUpLeg"),
        ("mixamorig:LeftUpLeg", "mixamorig:RightUpLeg"),
        ("leftUpperLeg", "rightUpperLeg"),
        ("thigh.L", "thigh.R"),
        ("thigh.L.001", "thigh.R.001"),
        ("thigh_l", "thigh_r"),
        ("l_thigh", "r_thigh"),
        ("ik_foot_l_end", "ik_foot_r_end"),
        ("Bip01 L Thigh", "Bip01 R Thigh"),
        ("J_Bip_L_UpperLeg", "J_Bip_R_UpperLeg"),
        ("LThumb", "RThumb"),
        ("FootL", "FootR"),
        ("THIGH_LEFT", "THIGH_RIGHT"),
        ("thigh-left", "thigh-right"),
    ],
)
def test_left_and_right(left, right):
    assert mirrored_pairs(["Hips", right, left, "Lower", "Roll"]) == [(left, right)]


def test_names_without_a_partner():
    assert mirrored_pairs(["LowerBack", "thigh.L", "Shin.R", "RowerBack1", "left", "Roller", "LLeg"]) == []
