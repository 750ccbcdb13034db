"""Transition costs against a textbook implementation, pair by pair; guessed joint roles."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.errors import ClipError
from core.motion.clip import MotionClip
from core.motion.contacts import foot_contacts, foot_joints
from core.motion.distance import (
    CostSettings,
    close_pairs_steps,
    joined,
    joint_weights,
    pair_costs,
    pose_features,
    squared_angles,
)
from core.motion.joint_roles import JointRole
from core.motion.skeleton import Skeleton
from core.progress import finish

from .bvh import read_bvh
from .dense_costs import transition_costs

NAMES = (
    "Hips",
    "LeftUpLeg",
    "LeftLeg",
    "LeftFoot",
    "RightUpLeg",
    "RightLeg",
    "RightFoot",
    "Spine",
    "LeftArm",
)
PARENTS = (-1, 0, 1, 2, 0, 4, 5, 0, 7)
WEIGHTED = {"LeftUpLeg", "LeftLeg", "RightUpLeg", "RightLeg", "Spine", "LeftArm"}


def skeleton(names=NAMES, parents=PARENTS, rest_translations=None):
    n_joints = len(names)
    rest = np.zeros((n_joints, 3)) if rest_translations is None else np.array(rest_translations, dtype=float)
    upright = np.tile([1.0, 0, 0, 0], (n_joints, 1))
    return Skeleton(tuple(names), np.array(parents), upright, rest, np.array([1.0, 0, 0]))


def random_clip(rng, n_frames=30, rate=30.0, scale=1.0):
    """Joints that turn at random, at any angle; the root stays upright enough to have a heading."""
    rotations = Rotation.random(n_frames * len(NAMES), rng=rng).as_quat(scalar_first=True)
    rotations = rotations.reshape(n_frames, len(NAMES), 4)
    turned = np.cumsum(rng.normal(size=n_frames))
    tilts = Rotation.from_euler("YX", rng.uniform(-0.6, 0.6, (n_frames, 2)))
    rotations[:, 0] = (Rotation.from_euler("Z", turned[:, None]) * tilts).as_quat(scalar_first=True)
    # Both quaternions of a rotation are the same rotation.
    rotations *= rng.choice([-1, 1], (n_frames, len(NAMES), 1))
    translations = rng.normal(size=(n_frames, len(NAMES), 3)) * scale
    return MotionClip("random", skeleton(), rate, rotations, translations)


def rate_of_change(values, difference, rate):
    """Central differences, one-sided ones of second order at the ends."""
    inner = [difference(values[i - 1], values[i + 1]) * rate / 2 for i in range(1, len(values) - 1)]
    first, second = difference(values[0], values[1]) * rate, difference(values[1], values[2]) * rate
    last, before = difference(values[-2], values[-1]) * rate, difference(values[-3], values[-2]) * rate
    return [1.5 * first - 0.5 * second, *inner, 1.5 * last - 0.5 * before]


def textbook_costs(clip_a, clip_b, weights):
    """D of Lee et al. 2002 with the root terms, one pair and one joint after the other."""

    def turn(before, after):
        return (before.inv() * after).as_rotvec()

    described = []
    for clip in (clip_a, clip_b):
        root = [Rotation.from_quat(q, scalar_first=True) for q in clip.rotations[:, 0]]
        forward = np.array([r.apply(clip.skeleton.forward) for r in root])
        heading = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))
        joints = {"root": [Rotation.from_rotvec([0, 0, -h]) * r for h, r in zip(heading, root, strict=True)]}
        for name in weights:
            of_joint = clip.rotations[:, clip.skeleton.names.index(name)]
            joints[name] = [Rotation.from_quat(q, scalar_first=True) for q in of_joint]
        spins = {name: rate_of_change(of_joint, turn, clip.frame_rate) for name, of_joint in joints.items()}
        position = clip.translations[:, 0]
        velocity = rate_of_change(position, lambda a, b: b - a, clip.frame_rate)
        velocity = [Rotation.from_rotvec([0, 0, -h]).apply(v) for h, v in zip(heading, velocity, strict=True)]
        turn_rate = rate_of_change(heading, lambda a, b: b - a, clip.frame_rate)
        described.append((joints, spins, position[:, 2], velocity, turn_rate))
    joints_a, spins_a, height_a, velocity_a, turn_a = described[0]
    joints_b, spins_b, height_b, velocity_b, turn_b = described[1]
    costs = np.zeros((clip_a.n_frames, clip_b.n_frames))
    for i in range(clip_a.n_frames):
        for j in range(clip_b.n_frames):
            for name, weight in {"root": 1.0, **weights}.items():
                angle = (joints_b[name][j].inv() * joints_a[name][i]).magnitude()
                costs[i, j] += weight * angle**2
                costs[i, j] += 0.02 * weight * np.sum((spins_a[name][i] - spins_b[name][j]) ** 2)
            costs[i, j] += (height_a[i] - height_b[j]) ** 2
            costs[i, j] += 0.5**2 * np.sum((velocity_a[i] - velocity_b[j]) ** 2)
            costs[i, j] += 0.5**2 * (turn_a[i] - turn_b[j]) ** 2
    return costs


def test_random_poses_cost_what_the_textbook_says():
    rng = np.random.default_rng(1)
    a, b = random_clip(rng, 17), random_clip(rng, 9)
    expected = textbook_costs(a, b, dict.fromkeys(WEIGHTED, 1.0))
    costs = transition_costs(pose_features(a), pose_features(b))
    # Random poses at 30 frames per second spin fast: the costs are in the hundreds.
    np.testing.assert_allclose(costs, expected, rtol=1e-6, atol=1e-4)
    assert expected.max() > 100


def test_recorded_poses_cost_what_the_textbook_says(data_folder):
    clips = [read_bvh(data_folder / "cmu16" / f"16_{n}.bvh").resampled(30.0) for n in ("09", "27")]
    short = [
        MotionClip(c.name, c.skeleton, 30.0, c.rotations[:40:2], c.translations[:40:2], first_frame=0) for c in clips
    ]
    names = ["LowerBack", "Spine", "Spine1"]
    names += [s + n for s in ("Left", "Right") for n in ("UpLeg", "Leg", "Arm", "ForeArm")]
    for a, b in ((short[0], short[0]), (short[0], short[1])):
        expected = textbook_costs(a, b, dict.fromkeys(names, 1.0))
        np.testing.assert_allclose(transition_costs(pose_features(a), pose_features(b)), expected, atol=1e-4)


def test_weights_enter_angles_and_angular_velocities():
    rng = np.random.default_rng(2)
    clip = random_clip(rng, 6, rate=3.0)
    weights = {**dict.fromkeys(WEIGHTED, 1.0), "LeftFoot": 0.25, "Spine": 0.0}
    features = pose_features(clip, CostSettings(joint_weights={"LeftFoot": 0.25, "Spine": 0.0}))
    np.testing.assert_allclose(transition_costs(features, features), textbook_costs(clip, clip, weights), atol=1e-4)


def test_place_and_heading_are_free():
    rng = np.random.default_rng(3)
    clip = random_clip(rng)
    turn = Rotation.from_rotvec([0, 0, 2.0])
    rotations, translations = clip.rotations.copy(), clip.translations.copy()
    root = Rotation.from_quat(rotations[:, 0], scalar_first=True)
    rotations[:, 0] = (turn * root).as_quat(scalar_first=True)
    translations[:, 0] = turn.apply(translations[:, 0]) + [5, -7, 0]
    moved = MotionClip("moved", clip.skeleton, 30.0, rotations, translations)
    assert np.diag(transition_costs(pose_features(clip), pose_features(moved))).max() < 1e-4
    translations[:, 0, 2] += 0.5
    raised = MotionClip("raised", clip.skeleton, 30.0, rotations, translations)
    np.testing.assert_allclose(np.diag(transition_costs(pose_features(clip), pose_features(raised))), 0.25, atol=1e-4)


def test_costs_are_symmetric_and_a_frame_costs_nothing_against_itself():
    features = pose_features(random_clip(np.random.default_rng(4), 300, scale=10))
    costs = transition_costs(features, features)
    np.testing.assert_allclose(costs, costs.T, rtol=1e-5)
    assert np.diag(costs).max() < 1e-4


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_squared_angles(dtype):
    angles = np.concatenate([[0], np.logspace(-7, np.log10(np.pi), 2000)])
    cosines = np.concatenate([np.cos(angles / 2), -np.cos(angles / 2), [1.0000001]]).astype(dtype)
    expected = np.concatenate([angles, angles, [0]]) ** 2
    np.testing.assert_allclose(squared_angles(cosines), expected, atol=3e-6 if dtype == np.float32 else 2e-8)


def smooth_clip(rng, n_frames):
    """Slowly varying poses, so that many pairs are close."""
    phase = np.linspace(0, 20, n_frames)[:, None]
    angles = np.sin(phase + rng.uniform(0, 6, len(NAMES))) * rng.uniform(0.2, 0.5, len(NAMES))
    rotations = Rotation.from_rotvec(angles.reshape(-1, 1) * [0, 1, 0]).as_quat(scalar_first=True)
    translations = np.zeros((n_frames, len(NAMES), 3))
    translations[:, 0, 0] = phase[:, 0] * 0.2
    return MotionClip("smooth", skeleton(), 30.0, rotations.reshape(n_frames, len(NAMES), 4), translations)


@pytest.mark.parametrize("max_cost", [1e-3, 0.1, 0.5])
def test_close_pairs_are_all_pairs_below_the_threshold(max_cost):
    rng = np.random.default_rng(5)
    features = joined([pose_features(smooth_clip(rng, 150)), pose_features(smooth_clip(rng, 80))])
    costs = transition_costs(features, features).astype(float)
    first, second, close = finish(close_pairs_steps(features, max_cost))
    np.testing.assert_allclose(close, costs[first, second], atol=1e-5)
    assert (first < second).all() and (close <= max_cost).all()
    found = np.zeros(costs.shape, dtype=bool)
    found[first, second] = True
    upper = np.triu(np.ones(costs.shape, dtype=bool), 1)
    assert not (upper & (costs < max_cost - 1e-5) & ~found).any()
    assert len(first) == np.count_nonzero(found)
    assert 0 < len(first) < np.count_nonzero(upper)


@pytest.mark.parametrize(("max_cost", "scale"), [(0.3, 1.0), (2.0, 1.0), (40.0, 1.0), (900.0, 30.0)])
def test_no_pair_is_lost_by_skipping(max_cost, scale):
    """Random poses, fast and far apart: the bound is loose and its rounding at its worst."""
    rng = np.random.default_rng(7)
    parts = [pose_features(smooth_clip(rng, 100)), pose_features(random_clip(rng, 60, scale=scale))]
    features = joined([*parts, parts[0]])
    classes = rng.integers(0, 3, features.n_frames)
    i, j = np.triu_indices(features.n_frames, 1)
    costs = pair_costs(features, i, j)
    for labels in (None, classes):
        near = costs <= max_cost
        if labels is not None:
            near &= labels[i] == labels[j]
        found = finish(close_pairs_steps(features, max_cost, labels))
        order = np.lexsort((found[1], found[0]))
        assert labels is not None or (order == np.arange(len(order))).all()
        found = [part[order] for part in found]
        np.testing.assert_array_equal(np.column_stack(found[:2]), np.column_stack([i[near], j[near]]))
        np.testing.assert_allclose(found[2], costs[near], rtol=1e-12)
        assert 0 < len(found[0]) < len(i)


def test_no_pair_of_recorded_frames_is_lost_by_skipping(data_folder):
    files = sorted((data_folder / "cmu_locomotion").glob("*.bvh"))[::10]
    clips = [read_bvh(file).resampled(30.0) for file in files]
    features = joined([pose_features(clip) for clip in clips])
    contacts = np.concatenate([foot_contacts(clip) for clip in clips]) @ [1, 2]
    dense = transition_costs(features, features)
    same = contacts[:, None] == contacts
    for max_cost in (0.1, 0.3, 1.0):
        first, second, costs = finish(close_pairs_steps(features, max_cost, contacts))
        found = np.zeros(dense.shape, dtype=bool)
        found[first, second] = True
        # Costs that differ from the threshold by less than single precision may be on either side of it.
        assert not (np.triu(same & (dense < max_cost - 1e-5), 1) & ~found).any()
        assert not (found & (dense > max_cost + 1e-5)).any()
        assert same[first, second].all()
        np.testing.assert_allclose(costs, dense[first, second], atol=1e-5)
        assert len(first) > 100


def test_a_root_on_the_ground_leaves_the_height_to_the_hips():
    names = ("root", "pelvis", "thigh_l", "calf_l", "foot_l", "thigh_r", "calf_r", "foot_r")
    character = skeleton(names, (-1, 0, 1, 2, 3, 1, 5, 6))
    rotations = np.tile([1.0, 0, 0, 0], (20, 8, 1))
    translations = np.zeros((20, 8, 3))
    translations[:, 1, 2] = 1.0
    upright = MotionClip("upright", character, 30.0, rotations, translations)
    lower = translations.copy()
    lower[:, 1, 2] = 0.5
    low = MotionClip("low", character, 30.0, rotations, lower)
    bent = rotations.copy()
    bent[:, 1] = Rotation.from_euler("Y", 0.4).as_quat(scalar_first=True)
    leaning = MotionClip("leaning", character, 30.0, bent, translations)
    features = pose_features(upright)
    np.testing.assert_allclose(transition_costs(features, pose_features(low)), 0.25, atol=1e-5)
    np.testing.assert_allclose(transition_costs(features, pose_features(leaning)), 0.16, atol=1e-5)


def test_no_close_pairs():
    first, second, costs = finish(close_pairs_steps(pose_features(random_clip(np.random.default_rng(6), 20)), 1e-6))
    assert len(first) == len(second) == len(costs) == 0


@pytest.mark.parametrize(
    ("thigh", "shin", "foot", "upper", "lower", "spine", "ignored"),
    [
        ("LeftUpLeg", "LeftLeg", "LeftFoot", "LeftArm", "LeftForeArm", "Spine1", "LeftShoulder"),
        ("mixamorig:LeftUpLeg", "mixamorig:LeftLeg", "mixamorig:LeftFoot", "mixamorig:LeftArm",
         "mixamorig:LeftForeArm", "mixamorig:Spine2", "mixamorig:LeftShoulder"),
        ("thigh.L", "shin.L", "foot.L", "upper_arm.L", "forearm.L", "spine.002", "shoulder.L"),
        ("DEF-thigh.L", "DEF-shin.L", "DEF-foot.L", "DEF-upper_arm.L", "DEF-forearm.L", "DEF-spine.002",
         "DEF-shoulder.L"),
        ("thigh_l", "calf_l", "foot_l", "upperarm_l", "lowerarm_l", "spine_01", "clavicle_l"),
        ("Bip01 L Thigh", "Bip01 L Calf", "Bip01 L Foot", "Bip01 L UpperArm", "Bip01 L Forearm", "Bip01 Spine1",
         "Bip01 L Clavicle"),
        ("J_Bip_L_UpperLeg", "J_Bip_L_LowerLeg", "J_Bip_L_Foot", "J_Bip_L_UpperArm", "J_Bip_L_LowerArm",
         "J_Bip_C_Spine", "J_Bip_L_Shoulder"),
        ("lThigh", "lShin", "lFoot", "lUpperArm", "lForeArm", "abdomen", "lCollar"),
        ("LeftHip", "LeftKnee", "LeftAnkle", "LeftShoulder", "LeftElbow", "Chest", "LeftCollar"),
    ],
)  # fmt: skip
def test_roles_are_known_by_the_usual_names(thigh, shin, foot, upper, lower, spine, ignored):
    left = (thigh, shin, foot, ignored, upper, lower)
    right = tuple(mirrored(name) for name in left)
    names = ("root", *left[:3], *right[:3], spine, *left[3:], *right[3:])
    parents = (-1, 0, 1, 2, 0, 4, 5, 0, 7, 8, 9, 7, 11, 12)
    character = skeleton(names, parents)
    roles = character.roles
    for side, (of_thigh, of_shin, of_foot, _, of_upper, of_lower) in (("left", left), ("right", right)):
        found = [
            names[roles[role, side][0]]
            for role in (
                JointRole.THIGH,
                JointRole.SHIN,
                JointRole.FOOT,
                JointRole.UPPER_ARM,
                JointRole.LOWER_ARM,
            )
        ]
        assert found == [of_thigh, of_shin, of_foot, of_upper, of_lower]
    assert roles[JointRole.SPINE, ""] == (names.index(spine),)
    weights = joint_weights(character)
    unweighted = {name for name, weight in zip(names, weights, strict=True) if weight == 0}
    assert unweighted == {left[2], right[2], ignored, right[3]}


def mirrored(name):
    for left, right in (("Left", "Right"), (".L", ".R"), ("_l", "_r"), (" L ", " R "), ("_L_", "_R_")):
        if left in name:
            return name.replace(left, right)
    return "r" + name[1:]


def test_neck_bones_called_spine_do_not_count():
    names = ("spine", "spine.001", "spine.002", "shoulder.L", "upper_arm.L", "spine.003", "spine.004")
    roles = skeleton(names, (-1, 0, 1, 2, 3, 2, 5)).roles
    assert roles[JointRole.SPINE, ""] == (1, 2)


TABLE = ("top", "a1", "a2", "a3", "b1", "b2", "b3", "c1", "c2")
TABLE_PARENTS = (-1, 0, 1, 2, 0, 4, 5, 0, 7)
TABLE_REST = [(0, 0, 1), (0, -1, 0), (0, 0, -0.9), (0.2, 0, -0.1), (0, 1, 0), (0, 0, -0.9), (0.2, 0, -0.1),
              (0, 0, 0.5), (0, 0, 0.5)]  # fmt: skip


def test_unknown_names_weigh_all_joints_but_leaves():
    weights = joint_weights(skeleton(TABLE, TABLE_PARENTS))
    assert [name for name, weight in zip(TABLE, weights, strict=True) if weight] == [
        "top",
        "a1",
        "a2",
        "b1",
        "b2",
        "c1",
    ]


def test_unknown_feet_are_the_lowest_chains_left_first():
    character = skeleton(TABLE, TABLE_PARENTS, TABLE_REST)
    assert foot_joints(character) == ((5, 6), (2, 3))  # it faces +X, so that +Y is to its left


def test_feet_of_a_one_legged_character_must_be_named():
    names, parents = ("hop", "leg", "toe1", "toe2"), (-1, 0, 1, 1)
    pogo = skeleton(names, parents, [(0, 0, 1), (0, 0, -0.9), (0.1, 0, -0.1), (0.1, 0.1, -0.1)])
    with pytest.raises(ClipError, match="feet of the skeleton rooted at 'hop'"):
        foot_joints(pogo)
    assert foot_joints(pogo, (("leg", "toe1"), ("toe2",))) == ((1, 2), (3,))


def test_unknown_bones_and_negative_weights_are_refused():
    with pytest.raises(ClipError, match="'Tail'"):
        joint_weights(skeleton(), {"Tail": 1.0})
    with pytest.raises(ClipError, match="'Spine' is -1"):
        joint_weights(skeleton(), {"Spine": -1.0})


def spinning(n_frames, turns=1.0, swing=0.0):
    """A clip in which every joint goes around evenly, or to and fro by ``swing`` radians, so many times."""
    at = np.linspace(0, 2 * np.pi * turns, n_frames)
    angles = at if swing == 0.0 else swing * np.sin(at)
    rotations = np.zeros((n_frames, len(NAMES), 4))
    rotations[..., 0] = 1.0
    moving = Rotation.from_euler("X", angles[:, None]).as_quat(scalar_first=True)
    rotations[:, 1:] = moving[:, None]
    return MotionClip("spinning", skeleton(), 30.0, rotations, np.zeros((n_frames, len(NAMES), 3)))


@pytest.mark.parametrize("swing", [0.0, 0.8])
def test_the_seam_of_a_loop_costs_nothing(swing):
    """The pose is the same and so is the velocity, although the clip ends there."""
    clip = spinning(13, swing=swing)
    costs = transition_costs(pose_features(clip), pose_features(clip))
    assert costs[-1, 0] == pytest.approx(0.0, abs=1e-5) and costs[0, -1] == pytest.approx(0.0, abs=1e-5)
    # Central differences around the seam, as in the middle of the same motion twice over.
    twice = spinning(25, turns=2.0, swing=swing)
    middle = transition_costs(pose_features(clip), pose_features(twice))
    assert middle[0, 12] == pytest.approx(0.0, abs=1e-5)


def test_a_pose_that_is_passed_the_other_way_is_no_seam():
    """To and fro: half a swing ends where it began, and moves the other way there."""
    clip = spinning(13, turns=0.5, swing=0.8)
    assert transition_costs(pose_features(clip), pose_features(clip))[-1, 0] > 1.0


def test_rates_at_the_ends_are_as_exact_as_elsewhere():
    whole = spinning(61, swing=0.8)
    part = whole.taken(slice(20, 41))
    costs = transition_costs(pose_features(whole), pose_features(part))
    assert costs[20, 0] < 0.02 and costs[40, 20] < 0.02
