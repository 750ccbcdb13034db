"""Motion on another skeleton: other names, rest poses, axes, sizes and numbers of joints."""

from dataclasses import replace

import numpy as np
import pytest

from core.errors import ClipError
from core.motion import quat
from core.motion.clip import MotionClip
from core.motion.contacts import foot_contacts
from core.motion.kinematics import local_transforms
from core.motion.repertoire import sample_repertoire
from core.motion.retarget import fit_skeleton, retarget_steps
from core.motion.skeleton import Skeleton
from core.progress import finish

WALK = next(clip for clip in sample_repertoire(30) if clip.name == "arc_left")
UNREAL = {
    "Hips": "pelvis", "Spine": "spine_01", "Spine1": "spine_02", "Neck": "neck_01", "Head": "head",
    "LeftShoulder": "clavicle_l", "LeftArm": "upperarm_l", "LeftForeArm": "lowerarm_l", "LeftHand": "hand_l",
    "RightShoulder": "clavicle_r", "RightArm": "upperarm_r", "RightForeArm": "lowerarm_r", "RightHand": "hand_r",
    "LeftUpLeg": "thigh_l", "LeftLeg": "calf_l", "LeftFoot": "foot_l", "LeftToeBase": "ball_l",
    "RightUpLeg": "thigh_r", "RightLeg": "calf_r", "RightFoot": "foot_r", "RightToeBase": "ball_r",
}  # fmt: skip


def written(
    clip: MotionClip, names=None, size: float = 1.0, axes=quat.IDENTITY, arms: float = 0.0, down: float = 0.0
) -> MotionClip:
    """The same motion of a rig with other names, ``size`` times as large, whose joints have turned axes, whose arms
    rest lowered by an angle, and whose rest pose stands ``down`` metres lower than its motion.
    """
    own = clip.skeleton
    rest_turns, rest_places = (np.array(array) for array in own.rest_world)
    for side, sign in (("Left", 1), ("Right", -1)):
        top = own.index(f"{side}Arm")
        turn = quat.about("y", sign * arms)
        for joint in (top, *own.descendants(top)):
            rest_turns[joint] = quat.multiply(turn, rest_turns[joint])
            rest_places[joint] = rest_places[top] + quat.rotate(turn, rest_places[joint] - rest_places[top])
    turns, places = clip.world
    rests = local_transforms(quat.multiply(rest_turns, axes), size * rest_places - [0, 0, down], own.parents)
    local = local_transforms(quat.multiply(turns, axes), size * places, own.parents)
    names = tuple((names or {}).get(name, name) for name in own.names)
    forward = quat.rotate(quat.inverse(axes), own.forward)
    return replace(
        clip,
        skeleton=Skeleton(names, own.parents, *rests, forward),
        rotations=local[0],
        translations=local[1],
        tags={},
    )


def carried(clip: MotionClip, own: Skeleton, example=None) -> MotionClip:
    return finish(retarget_steps(clip, fit_skeleton(own, clip.skeleton, example)))


RIGS = {
    "as it is": {},
    "other axes": {"axes": quat.about("x", np.pi / 2)},
    "lowered arms": {"arms": np.pi / 4},
    "half as large": {"size": 0.5},
    "all of it": {"size": 2.0, "arms": 0.6, "axes": quat.about("y", 2.0)},
}


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("names", [None, UNREAL], ids=["names", "roles"])
def test_the_motion_is_the_same_on_every_rig(rig, names):
    other = written(WALK, names, **RIGS[rig])
    clip = carried(other, WALK.skeleton)
    joints = [WALK.skeleton.index(name) for name in clip.skeleton.names]
    assert len(joints) >= len(UNREAL) - 2
    np.testing.assert_allclose(clip.world[1], WALK.world[1][:, joints], atol=2e-3)
    assert clip.frame_rate == WALK.frame_rate and np.abs(clip.root_heading - WALK.root_heading).max() < 1e-3


@pytest.mark.parametrize("rig", RIGS)
def test_and_from_the_sample_to_every_rig(rig):
    own = written(WALK, UNREAL, **RIGS[rig])
    clip = carried(WALK, own.skeleton)
    joints = [own.skeleton.index(name) for name in clip.skeleton.names]
    size = RIGS[rig].get("size", 1.0)
    np.testing.assert_allclose(clip.world[1], own.world[1][:, joints], atol=2e-3 * max(size, 1))


def test_feet_stay_planted_on_other_proportions():
    """Longer thighs, shorter shins and a longer trunk: standing feet slide little more than they did."""
    own = WALK.skeleton
    lengths = np.ones((own.n_joints, 1))
    lengths[[own.index(f"{side}Leg") for side in ("Left", "Right")]] = 1.25
    lengths[[own.index(f"{side}Foot") for side in ("Left", "Right")]] = 0.9
    lengths[own.index("Spine")] = 1.2
    stretched = Skeleton(own.names, own.parents, own.rest_rotations, own.rest_translations * lengths, own.forward)
    lifted = stretched.rest_translations.copy()
    lifted[0, 2] += own.rest_world[1][:, 2].min() - stretched.rest_world[1][:, 2].min()
    stretched = replace(stretched, rest_translations=lifted)
    clip = carried(written(WALK, UNREAL), stretched)
    contacts, expected = foot_contacts(clip), foot_contacts(WALK)
    assert (contacts == expected).mean() > 0.85
    ankle = clip.world[1][:, clip.skeleton.index("LeftFoot")]
    both = (contacts[1:, 0] & contacts[:-1, 0])[:, None]
    slide = np.where(both, np.diff(ankle, axis=0), 0.0)
    reference = WALK.world[1][:, WALK.skeleton.index("LeftFoot")]
    expected_slide = np.where(both, np.diff(reference, axis=0), 0.0)
    assert np.linalg.norm(slide, axis=1).sum() < 1.5 * np.linalg.norm(expected_slide, axis=1).sum()


def test_a_rest_pose_below_its_motion_is_seen_from_an_example():
    other = written(WALK, UNREAL, down=1.5)
    clip = carried(other, WALK.skeleton, example=other)
    feet = [clip.skeleton.index(f"{side}Foot") for side in ("Left", "Right")]
    own = [WALK.skeleton.index(f"{side}Foot") for side in ("Left", "Right")]
    np.testing.assert_allclose(clip.world[1][:, feet, 2], WALK.world[1][:, own, 2], atol=0.04)


def test_prefixes_and_ends_of_chains_do_not_matter():
    other = written(WALK, {name: f"mixamorig1:{name}" for name in WALK.skeleton.names})
    fit = fit_skeleton(WALK.skeleton, other.skeleton)
    assert fit.unmoved == () and fit.reason == "another rest pose"
    np.testing.assert_allclose(finish(retarget_steps(other, fit)).world[1], WALK.world[1], atol=1e-9)


def test_what_has_no_counterpart_is_named_and_left_out():
    own = WALK.skeleton
    hand = own.index("LeftHand")
    fingered = Skeleton(
        (*own.names, "LeftThumb"),
        np.append(own.parents, hand),
        np.concatenate([own.rest_rotations, [quat.IDENTITY]]),
        np.concatenate([own.rest_translations, [[0.05, 0.0, 0.0]]]),
        own.forward,
    )
    fit = fit_skeleton(fingered, written(WALK, UNREAL).skeleton)
    assert fit.unmoved == ("LeftThumb",) and fit.reason == "another skeleton"
    assert "LeftThumb" not in fit.skeleton.names


def test_a_skeleton_without_legs_is_refused():
    tail = Skeleton(("a", "b"), np.array([-1, 0]), np.tile(quat.IDENTITY, (2, 1)), np.eye(3)[:2], np.eye(3)[1])
    with pytest.raises(ClipError, match="thigh below 'a' is not known"):
        fit_skeleton(WALK.skeleton, tail)
