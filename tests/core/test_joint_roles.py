"""Roles and weights guessed for the whole skeletons that people work with."""

import numpy as np
import pytest

from core.motion.contacts import foot_joints
from core.motion.distance import joint_weights
from core.motion.joint_roles import JointRole

from .rigs import rig


def both(*names):
    return {name.replace("*", side) for name in names for side in ("Left", "Right")}


def sided(*names):
    return {name.replace("*", side) for name in names for side in "lr"}


def dotted(*names):
    return {f"{name}.{side}" for name in names for side in "LR"}


LIMBS = ("*UpLeg", "*Leg", "*Arm", "*ForeArm")
UNREAL_LIMBS = ("thigh_*", "calf_*", "upperarm_*", "lowerarm_*")
RIGIFY_LIMBS = ("thigh", "shin", "upper_arm", "forearm")

CASES = {
    "cmu": (
        None,
        31,
        {"Hips", "LowerBack", "Spine", "Spine1", *both(*LIMBS)},
        (("LeftFoot", "LeftToeBase"), ("RightFoot", "RightToeBase")),
        "Hips",
    ),
    "mixamo": (
        None,
        65,
        {f"mixamorig:{name}" for name in ("Hips", "Spine", "Spine1", "Spine2", *both(*LIMBS))},
        tuple((f"mixamorig:{side}Foot", f"mixamorig:{side}ToeBase") for side in ("Left", "Right")),
        "mixamorig:Hips",
    ),
    "unreal4": (
        None,
        68,
        {"root", "pelvis", "spine_01", "spine_02", "spine_03", *sided(*UNREAL_LIMBS)},
        (("foot_l", "ball_l"), ("foot_r", "ball_r")),
        "pelvis",
    ),
    "unreal5": (
        None,
        159,
        {"root", "pelvis", *(f"spine_0{i}" for i in range(1, 6)), *sided(*UNREAL_LIMBS)},
        (("foot_l", "ball_l"), ("foot_r", "ball_r")),
        "pelvis",
    ),
    "rigify_metarig": (
        None,
        159,
        {"spine", "spine.001", "spine.002", "spine.003", *dotted(*RIGIFY_LIMBS)},
        (("foot.L", "toe.L"), ("foot.R", "toe.R")),
        "spine",
    ),
    "rigify_generated_body": (
        "ORG-spine",
        216,
        {
            "ORG-spine",
            *(f"DEF-{name}" for name in ("spine", "spine.001", "spine.002", "spine.003", *dotted(*RIGIFY_LIMBS))),
        },
        (("DEF-foot.L", "DEF-toe.L"), ("DEF-foot.R", "DEF-toe.R")),
        "ORG-spine",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_whole_skeletons_are_understood(name):
    root, n_bones, weighted, feet, hips = CASES[name]
    skeleton = rig(name, root)
    assert skeleton.n_joints == n_bones
    weights = joint_weights(skeleton)
    assert set(np.unique(weights)) == {0, 1}
    assert {bone for bone, weight in zip(skeleton.names, weights, strict=True) if weight} == weighted
    assert tuple(tuple(skeleton.names[joint] for joint in foot) for foot in foot_joints(skeleton)) == feet
    assert skeleton.names[skeleton.hips] == hips


@pytest.mark.parametrize("prefix", ["mixamorig1:", "mixamorig_", "mixamorig9:", ""])
def test_mixamo_bones_under_the_prefixes_that_exporters_leave(prefix):
    skeleton = rig("mixamo")
    renamed = type(skeleton)(
        tuple(name.replace("mixamorig:", prefix) for name in skeleton.names),
        skeleton.parents,
        skeleton.rest_rotations,
        skeleton.rest_translations,
        skeleton.forward,
    )
    np.testing.assert_array_equal(joint_weights(renamed), joint_weights(skeleton))
    assert foot_joints(renamed) == foot_joints(skeleton)


def test_an_unreal_character_read_from_its_pelvis_has_no_further_hips():
    skeleton = rig("unreal4", "pelvis")
    assert skeleton.names[0] == "pelvis" and skeleton.hips == 0
    assert (JointRole.HIPS, "") not in skeleton.roles
    assert joint_weights(skeleton)[skeleton.index("root")] == 0


def test_weights_can_be_edited_bone_by_bone():
    skeleton = rig("unreal5")
    weights = joint_weights(skeleton, {"hand_l": 0.5, "spine_03": 0.0})
    changed = np.flatnonzero(weights != joint_weights(skeleton))
    assert {skeleton.names[joint]: weights[joint] for joint in changed} == {"hand_l": 0.5, "spine_03": 0.0}
