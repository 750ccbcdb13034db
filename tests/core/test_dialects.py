"""The sample's skeleton under the names of many programs, and under names that say nothing."""

from dataclasses import replace

import numpy as np
import pytest

from core.motion import quat
from core.motion.anatomy import find_body_root, find_facing
from core.motion.contacts import foot_joints
from core.motion.distance import joint_weights
from core.motion.joint_roles import JointRole
from core.motion.repertoire import sample_repertoire
from core.motion.skeleton import Skeleton

TRUNK = ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head")
LIMBS = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
SAMPLE = sample_repertoire(30.0)[0].skeleton
UNREADABLE = {name: f"b{(7 * place) % 101}" for place, name in enumerate(SAMPLE.names)}

# Trunk, limbs with {} for the side, and the words for left and right.
DIALECTS = {
    "Poser": (
        "hip abdomen chest chest2 neck head",
        "{}Collar {}Shldr {}ForeArm {}Hand {}Thigh {}Shin {}Foot {}Toe",
        *"lr",
    ),
    "DAZ Genesis 8": (
        "hip abdomenLower abdomenUpper chestLower neckLower head",
        "{}Collar {}ShldrBend {}ForearmBend {}Hand {}ThighBend {}Shin {}Foot {}Toe",
        *"lr",
    ),
    "DAZ Genesis 9": (
        "hip spine1 spine2 spine3 neck1 head",
        "{}_shoulder {}_upperarm {}_forearm {}_hand {}_thigh {}_shin {}_foot {}_toes",
        *"lr",
    ),
    "MotionBuilder": (
        "Character1_Hips Character1_Spine Character1_Spine1 Character1_Spine2 Character1_Neck Character1_Head",
        "Character1_{0}Shoulder Character1_{0}Arm Character1_{0}ForeArm Character1_{0}Hand Character1_{0}UpLeg "
        "Character1_{0}Leg Character1_{0}Foot Character1_{0}ToeBase",
        "Left",
        "Right",
    ),
    "Mixamo without a separator": (
        "mixamorigHips mixamorigSpine mixamorigSpine1 mixamorigSpine2 mixamorigNeck mixamorigHead",
        "mixamorig{0}Shoulder mixamorig{0}Arm mixamorig{0}ForeArm mixamorig{0}Hand mixamorig{0}UpLeg mixamorig{0}Leg "
        "mixamorig{0}Foot mixamorig{0}ToeBase",
        "Left",
        "Right",
    ),
    "Maya": (
        "Hips_JNT Spine_JNT Spine1_JNT Chest_JNT Neck_JNT Head_JNT",
        "{}_Clavicle_JNT {}_UpperArm_JNT {}_LowerArm_JNT {}_Wrist_JNT {}_UpperLeg_JNT {}_LowerLeg_JNT {}_Ankle_JNT "
        "{}_Ball_JNT",
        "L",
        "R",
    ),
    "Maya, by joint": (
        "hips_jnt spine_01_jnt spine_02_jnt spine_03_jnt neck_jnt head_jnt",
        "clav_{0}_jnt shoulder_{0}_jnt elbow_{0}_jnt wrist_{0}_jnt hip_{0}_jnt knee_{0}_jnt ankle_{0}_jnt ball_{0}_jnt",
        "lf",
        "rt",
    ),
    "Biped": (
        "Bip01|Bip01 Spine|Bip01 Spine1|Bip01 Spine2|Bip01 Neck|Bip01 Head",
        "Bip01 {0} Clavicle|Bip01 {0} UpperArm|Bip01 {0} Forearm|Bip01 {0} Hand|Bip01 {0} Thigh|Bip01 {0} Calf|"
        "Bip01 {0} Foot|Bip01 {0} Toe0",
        "L",
        "R",
    ),
    "Source": (
        "ValveBiped.Bip01_Pelvis ValveBiped.Bip01_Spine ValveBiped.Bip01_Spine1 ValveBiped.Bip01_Spine2 "
        "ValveBiped.Bip01_Neck1 ValveBiped.Bip01_Head1",
        "ValveBiped.Bip01_{0}_Clavicle ValveBiped.Bip01_{0}_UpperArm ValveBiped.Bip01_{0}_Forearm "
        "ValveBiped.Bip01_{0}_Hand ValveBiped.Bip01_{0}_Thigh ValveBiped.Bip01_{0}_Calf ValveBiped.Bip01_{0}_Foot "
        "ValveBiped.Bip01_{0}_Toe0",
        "L",
        "R",
    ),
    "Auto-Rig Pro": (
        "root.x spine_01.x spine_02.x spine_03.x neck.x head.x",
        "shoulder.{0} arm_stretch.{0} forearm_stretch.{0} hand.{0} thigh_stretch.{0} leg_stretch.{0} foot.{0} "
        "toes_01.{0}",
        *"lr",
    ),
    "VRM": (
        "J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_Chest J_Bip_C_UpperChest J_Bip_C_Neck J_Bip_C_Head",
        "J_Bip_{0}_Shoulder J_Bip_{0}_UpperArm J_Bip_{0}_LowerArm J_Bip_{0}_Hand J_Bip_{0}_UpperLeg J_Bip_{0}_LowerLeg "
        "J_Bip_{0}_Foot J_Bip_{0}_ToeBase",
        "L",
        "R",
    ),
    "MMD": (
        "センター 上半身 上半身2 上半身3 首 頭",
        "{0}肩 {0}腕 {0}ひじ {0}手首 {0}足 {0}ひざ {0}足首 {0}つま先",
        *"左右",
    ),
    "MMD in Blender": (
        "センター 上半身 上半身2 上半身3 首 頭",
        "肩.{0} 腕.{0} ひじ.{0} 手首.{0} 足.{0} ひざ.{0} 足首.{0} つま先.{0}",
        "L",
        "R",
    ),
    "MMD in English": (
        "center upper_body upper_body2 upper_body3 neck head",
        "shoulder_{0} arm_{0} elbow_{0} wrist_{0} leg_{0} knee_{0} ankle_{0} toe_{0}",
        "L",
        "R",
    ),
    "Second Life": (
        "mPelvis mTorso mChest mSpine3 mNeck mHead",
        "mCollar{0} mShoulder{0} mElbow{0} mWrist{0} mHip{0} mKnee{0} mAnkle{0} mFoot{0}",
        "Left",
        "Right",
    ),
    "without separators": (
        "hips spine chest upperchest neck head",
        "{0}collar {0}upperarm {0}forearm {0}hand {0}thigh {0}shin {0}foot {0}toe",
        "left",
        "right",
    ),
    "a prefix and camel case": (
        "HeroHips HeroSpine HeroSpine1 HeroSpine2 HeroNeck HeroHead",
        "Hero{0}Clavicle Hero{0}UpperArm Hero{0}Forearm Hero{0}Hand Hero{0}Thigh Hero{0}Calf Hero{0}Foot Hero{0}Toe",
        "L",
        "R",
    ),
}


def dialect(name):
    trunk, limbs, *sides = DIALECTS[name]
    separator = "|" if "|" in trunk else " "
    found: dict[str, str] = dict(zip(TRUNK, trunk.split(separator), strict=True))
    for side, word in zip(("Left", "Right"), sides, strict=True):
        found |= {side + joint: limb.format(word) for joint, limb in zip(LIMBS, limbs.split(separator), strict=True)}
    return found


def renamed(skeleton, names):
    return replace(skeleton, names=tuple(names.get(name, name) for name in skeleton.names))


def with_fingers(skeleton, finger="{}Finger{}{}"):
    """Five fingers of three bones on each hand."""
    names, parents, places = list(skeleton.names), list(skeleton.parents), list(skeleton.rest_world[1])
    for side in ("Left", "Right"):
        hand = names.index(f"{side}Hand")
        along = places[hand] - places[names.index(f"{side}ForeArm")]
        for number in range(5):
            below = hand
            for joint in range(3):
                names.append(finger.format(side, number, joint))
                parents.append(below)
                start = places[hand] + along * 0.3 + [0.0, 0.02 * (number - 2), 0.0] if joint == 0 else places[below]
                places.append(start + along * 0.15)
                below = len(names) - 1
    return as_skeleton(names, parents, places)


def as_skeleton(names, parents, places):
    """The skeleton of joints at these places in the world, all unturned, that faces -Y."""
    parents, places = np.array(parents), np.array(places, dtype=float)
    local = places.copy()
    local[1:] -= places[parents[1:]]
    upright = np.tile([1.0, 0, 0, 0], (len(names), 1))
    return Skeleton(tuple(names), parents, upright, local, np.array([0.0, -1.0, 0.0]))


def by_role(skeleton):
    return {key: joints for key, joints in skeleton.roles.items() if key[0] is not JointRole.HEAD}


@pytest.mark.parametrize("name", DIALECTS)
def test_the_sample_under_the_names_of_other_programs(name):
    skeleton = renamed(SAMPLE, dialect(name))
    assert by_role(skeleton) == by_role(SAMPLE)
    assert foot_joints(skeleton) == foot_joints(SAMPLE)
    np.testing.assert_array_equal(skeleton.partners, SAMPLE.partners)


def test_names_that_say_nothing_leave_the_shape():
    skeleton = renamed(with_fingers(SAMPLE), UNREADABLE)
    assert by_role(skeleton) == by_role(SAMPLE)
    assert foot_joints(skeleton) == foot_joints(SAMPLE)
    assert np.flatnonzero(skeleton.fingers).tolist() == list(range(22, 52))


@pytest.mark.parametrize("name", ["MotionBuilder", "MMD", "Poser", "Auto-Rig Pro"])
def test_fingers_weigh_nothing(name):
    skeleton = renamed(with_fingers(SAMPLE), dialect(name))
    np.testing.assert_array_equal(joint_weights(skeleton), np.pad(joint_weights(SAMPLE), (0, 30)))


def test_twist_bones_and_helpers_are_no_limbs():
    names, parents, places = list(SAMPLE.names), list(SAMPLE.parents), list(SAMPLE.rest_world[1])
    names = [dialect("Auto-Rig Pro")[name] for name in names]
    for name, parent, place in [
        ("thigh_twist.l", "thigh_stretch.l", (0.09, 0, 0.7)),
        ("thigh_twist.r", "thigh_stretch.r", (-0.09, 0, 0.7)),
        ("knee.l", "root.x", (0.09, -1, 0.5)),
        ("knee.r", "root.x", (-0.09, -1, 0.5)),
        ("kneeIK.l", "root.x", (0.09, -1, 0.5)),
        ("kneeIK.r", "root.x", (-0.09, -1, 0.5)),
    ]:
        parents.append(names.index(parent))
        names.append(name)
        places.append(np.array(place, dtype=float))
    assert by_role(as_skeleton(names, parents, places)) == by_role(SAMPLE)


def test_feet_of_which_one_has_toes():
    """Toes are not the other foot."""
    names = [UNREADABLE[name] for name in SAMPLE.names]
    keep = [joint for joint, name in enumerate(SAMPLE.names) if name != "RightToeBase"]
    places = SAMPLE.rest_world[1][keep]
    parents = [keep.index(SAMPLE.parents[joint]) if joint else -1 for joint in keep]
    skeleton = as_skeleton([names[joint] for joint in keep], parents, places)
    left, right = foot_joints(skeleton)
    assert [SAMPLE.names[keep[joint]] for joint in (*left, *right)] == ["LeftFoot", "LeftToeBase", "RightFoot"]


def test_a_body_whose_trunk_and_legs_part_below_several_mother_bones():
    """MMD: mother, center, groove and waist, of which the waist carries both; IK targets and doubles of the legs."""
    names = [dialect("MMD")[name] for name in SAMPLE.names]
    parents, places = [int(parent) for parent in SAMPLE.parents], [*SAMPLE.rest_world[1]]
    names[0] = "腰"
    legs = [joint for joint, name in enumerate(SAMPLE.names) if name.endswith("UpLeg")]
    n_body = len(names)
    for name, parent, place in [
        ("下半身", 0, (0, 0, 0.95)),
        ("グルーブ", -1, (0, 0, 0.6)),
        ("センター", -1, (0, 0, 0.6)),
        ("全ての親", -1, (0, 0, 0)),
        ("左足IK", n_body + 3, (0.09, 0.01, 0.07)),
        ("右足IK", n_body + 3, (-0.09, 0.01, 0.07)),
        ("左足D", n_body, (0.09, 0, 0.92)),
        ("右足D", n_body, (-0.09, 0, 0.92)),
    ]:
        names.append(name)
        parents.append(parent)
        places.append(np.array(place, dtype=float))
    parents[0], parents[n_body + 1], parents[n_body + 2] = n_body + 1, n_body + 2, n_body + 3
    for leg in legs:
        parents[leg] = n_body
    root = find_body_root(names, np.array(parents), np.array(places), np.ones(len(names), dtype=bool))
    assert names[root] == "腰"
    facing = find_facing(names, np.array(parents), np.array(places))
    assert facing is not None
    np.testing.assert_allclose(facing, [0, -1, 0], atol=1e-6)


@pytest.mark.parametrize("turn", [90, 180, 250])
def test_feet_say_where_a_body_without_names_faces(turn):
    names = [UNREADABLE[name] for name in SAMPLE.names]
    places = quat.rotate(quat.about("z", np.radians(turn)), SAMPLE.rest_world[1])
    expected = quat.rotate(quat.about("z", np.radians(turn)), [0.0, -1.0, 0.0])
    facing = find_facing(names, np.asarray(SAMPLE.parents), places)
    assert facing is not None
    np.testing.assert_allclose(facing, expected, atol=1e-6)


def hung(skeleton, bones):
    """The skeleton with more bones: (name, name of the bone that it hangs from, metres from there)."""
    names, parents, places = list(skeleton.names), list(skeleton.parents), list(skeleton.rest_world[1])
    for name, above, offset in bones:
        parents.append(names.index(above))
        places.append(places[parents[-1]] + np.array(offset))
        names.append(name)
    return as_skeleton(names, parents, places)


@pytest.mark.parametrize(
    "bones",
    [
        [("sword", "RightHand", (0, -0.1, 0)), ("tip", "sword", (0, -1.2, 0))],
        [("hat", "Head", (0, 0, 0.2)), ("feather", "hat", (0, 0, 0.8))],
        [("tail", "Hips", (0, 0.15, 0)), ("tail2", "tail", (0, 0.2, -0.2)), ("tail3", "tail2", (0, 0.2, -0.3))],
        [
            (f"skirt{side}{row}", "Hips" if row == 0 else f"skirt{side}{row - 1}", (0.15 * side * (row == 0), 0, z))
            for side in (1, -1)
            for row, z in enumerate((-0.05, -0.28, -0.28, -0.28))
        ],
    ],
    ids=["sword", "hat", "tail", "skirt"],
)
def test_what_a_body_without_names_holds_and_wears_is_no_limb(bones):
    whole = hung(SAMPLE, bones)
    nameless = {name: f"x{place}" for place, name in enumerate(whole.names)} | UNREADABLE
    skeleton = renamed(whole, nameless)
    assert by_role(skeleton) == by_role(SAMPLE)
    assert foot_joints(skeleton) == foot_joints(SAMPLE)
