"""The sample repertoire: a body that could walk, feet that stay put, and clips that fit together."""

import itertools

import numpy as np
import pytest

from core.motion.limb import limb_frames
from core.motion.repertoire import (
    STEP_OBSTACLE,
    STEP_TAG,
    sample_bone_lengths,
    sample_repertoire,
    sample_skeleton,
)

from .rotations import as_rotation, matrices

SIDES = ("Left", "Right")
STANDING = ("stand", "pivot_left_90", "pivot_right_90", "pivot_left_180")
STRAIGHT = {"walk": 1.2, "walk_again": 1.25, "walk_slow": 0.8, "walk_brisk": 1.6}
TURNS = {
    "turn_left_30": 30,
    "turn_right_30": -30,
    "turn_left_45": 45,
    "turn_right_45": -45,
    "turn_left_60": 60,
    "turn_right_60": -60,
    "turn_left_90": 90,
    "turn_right_90": -90,
    "arc_left": 80,
    "arc_right": -52,
    "pivot_left_90": 90,
    "pivot_right_90": -90,
    "pivot_left_180": 180,
}
COST_BONES = [side + bone for side in SIDES for bone in ("UpLeg", "Leg", "Arm", "ForeArm")]
COST_BONES += ["Spine", "Spine1", "Spine2"]
FLOOR_TOE = 0.02  # height of the toe joint above the sole


@pytest.fixture(scope="module")
def clips():
    return {clip.name: clip for clip in sample_repertoire()}


@pytest.fixture(scope="module")
def walkers(clips):
    return [clip for name, clip in clips.items() if name not in STANDING]


def rest_world(skeleton):
    rotations = [as_rotation(skeleton.rest_rotations[0])[0]]
    for joint in range(1, skeleton.n_joints):
        parent = rotations[skeleton.parents[joint]]
        rotations.append(parent * as_rotation(skeleton.rest_rotations[joint])[0])
    return rotations


def joint(clip, name):
    """(F, 3) world positions of a joint."""
    return clip.world[1][:, clip.skeleton.index(name)]


def sole(clip, side):
    """(F, 4, 3) world positions of heel, ball, toe tip and toe joint of a foot."""
    skeleton, rest = clip.skeleton, rest_world(clip.skeleton)
    points = []
    for bone, offsets in (
        (side + "Foot", [(0, 0.055, -0.075), (0, -0.125, -0.075)]),
        (side + "ToeBase", [(0, -0.07, -FLOOR_TOE), (0, 0, 0)]),
    ):
        index = skeleton.index(bone)
        turned = as_rotation(clip.world[0][:, index]) * rest[index].inv()
        points += [clip.world[1][:, index] + turned.apply(offset) for offset in offsets]
    return np.stack(points, axis=1)


def runs(mask):
    """The stretches of consecutive True, as index arrays."""
    indices = np.flatnonzero(mask)
    return [run for run in np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1) if len(run)]


def steps_counted(clip):
    """How many times a heel comes down."""
    heels = [sole(clip, side)[:, 0, 2] < 0.005 for side in SIDES]
    return sum(int(np.sum(~down[:-1] & down[1:])) for down in heels)


def straight_heading(clip, first, last):
    """Mean heading of the ground path between two frames; over a stride, the hips' twist averages out."""
    return np.mean(clip.ground_path[first:last, 2])


# The character


def test_skeleton_is_a_person_facing_minus_y():
    skeleton, lengths = sample_skeleton(), sample_bone_lengths()
    rest = rest_world(skeleton)
    np.testing.assert_allclose(np.squeeze(rest[0].apply(skeleton.forward)), [0, -1, 0], atol=1e-12)
    heads = [skeleton.rest_translations[0]]
    for index in range(1, skeleton.n_joints):
        parent = skeleton.parents[index]
        heads.append(heads[parent] + rest[parent].apply(skeleton.rest_translations[index]))
    heads = np.array(heads)
    tails = heads + [rotation.apply([0, length, 0]) for rotation, length in zip(rest, lengths, strict=True)]
    assert tails[skeleton.index("Head"), 2] == pytest.approx(1.75)
    assert tails[skeleton.index("LeftToeBase"), 1] < heads[skeleton.index("LeftFoot"), 1] - 0.15
    assert heads[skeleton.index("LeftHand"), 0] > 0.4
    # Bones lie along Y and meet: each limb's child starts where its parent ends.
    for child, parent in (("Leg", "UpLeg"), ("Foot", "Leg"), ("ToeBase", "Foot"), ("ForeArm", "Arm")):
        for side in SIDES:
            tail = tails[skeleton.index(side + parent)]
            np.testing.assert_allclose(heads[skeleton.index(side + child)], tail, atol=1e-12)
    for name in skeleton.names:
        if name.startswith("Left"):
            mirrored = heads[skeleton.index(name)] * [-1, 1, 1]
            np.testing.assert_allclose(heads[skeleton.index("Right" + name[4:])], mirrored, atol=1e-12)


def test_limb_reaches_its_end_and_bends_the_right_way():
    rng = np.random.default_rng(1)
    start = rng.normal(size=(50, 3))
    direction = rng.normal(size=(50, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    end = start + direction * rng.uniform(0.15, 0.75, (50, 1))
    hinge = rng.normal(size=(50, 3))
    upper, lower = matrices(limb_frames(start, end, hinge, 0.45, 0.35))
    middle = start + 0.45 * upper[:, :, 1]
    np.testing.assert_allclose(middle + 0.35 * lower[:, :, 1], end, atol=1e-9)
    assert np.all(np.sum(np.cross(hinge, end - start) * (middle - start), axis=1) > 0)
    np.testing.assert_allclose(np.swapaxes(upper, 1, 2) @ upper, np.broadcast_to(np.eye(3), (50, 3, 3)), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(lower), 1, atol=1e-9)


def test_limb_out_of_reach_points_at_its_end():
    upper, lower = matrices(limb_frames(np.zeros((1, 3)), np.array([[0, 0, -2.0]]), np.array([[-1.0, 0, 0]]), 0.4, 0.4))
    np.testing.assert_allclose(upper[0, :, 1], [0, 0, -1], atol=1e-3)
    np.testing.assert_allclose(lower[0, :, 1], [0, 0, -1], atol=1e-3)


# The repertoire as a whole


def test_repertoire_has_its_parts(clips):
    assert 20 <= len(clips) <= 30
    assert 60 <= sum(clip.duration for clip in clips.values()) <= 105
    assert {clip.frame_rate for clip in clips.values()} == {30.0}
    assert set(TURNS) | set(STRAIGHT) <= set(clips)
    for clip in clips.values():
        np.testing.assert_allclose(clip.ground_path[0, :2], 0, atol=0.06)
        assert clip.ground_path[0, 2] == pytest.approx(-np.pi / 2, abs=0.12)


def test_same_seed_same_clips_other_seed_other_clips(clips):
    again = sample_repertoire(rng=np.random.default_rng(2004))
    other = sample_repertoire(rng=np.random.default_rng(7))
    for clip, same, different in zip(clips.values(), again, other, strict=True):
        np.testing.assert_array_equal(clip.rotations, same.rotations)
        np.testing.assert_array_equal(clip.translations, same.translations)
        n_frames = min(clip.n_frames, different.n_frames)
        assert np.abs(clip.rotations[:n_frames] - different.rotations[:n_frames]).max() > 0.01


def test_frame_rate_changes_the_sampling_and_not_the_motion(clips):
    for fine in sample_repertoire(60.0):
        clip = clips[fine.name]
        assert fine.duration == pytest.approx(clip.duration, abs=1 / 30)
        np.testing.assert_allclose(fine.translations[::2][: clip.n_frames], clip.translations, atol=2e-3)


def test_bones_keep_their_lengths_and_quaternions_are_unit_and_continuous(clips):
    rest = sample_skeleton().rest_translations
    for clip in clips.values():
        np.testing.assert_array_equal(
            clip.translations[:, 1:], np.broadcast_to(rest[1:], clip.translations[:, 1:].shape)
        )
        np.testing.assert_allclose(np.linalg.norm(clip.rotations, axis=2), 1, atol=1e-9)
        assert np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=2).min() > 0.9


def test_nothing_pops(clips):
    for clip in clips.values():
        n_frames, n_joints = clip.rotations.shape[:2]
        change = as_rotation(clip.rotations[:-1]).inv() * as_rotation(clip.rotations[1:])
        turned = change.as_rotvec().reshape(n_frames - 1, n_joints, 3)
        assert np.linalg.norm(turned, axis=2).max() < 0.6, clip.name
        assert np.linalg.norm(np.diff(turned, axis=0), axis=2).max() * 30**2 < 450, clip.name
        acceleration = np.diff(clip.translations[:, 0], 2, axis=0) * 30**2
        assert np.linalg.norm(acceleration, axis=1).max() < 9, clip.name


# Feet


def test_planted_feet_stay_planted(clips):
    for clip, side in itertools.product(clips.values(), SIDES):
        points = sole(clip, side)
        heel, toe = points[:, 0], points[:, 3]
        for point, low in ((heel, 0.0005), (toe, FLOOR_TOE + 0.0005)):
            for run in runs(point[:, 2] < low):
                still = point[run[1:-1]]  # down in the frame before and after, so down throughout
                if len(still) < 2:
                    continue
                assert np.ptp(still, axis=0).max() < 0.001, (clip.name, side)
                speed = np.linalg.norm(np.diff(still, axis=0), axis=1) * clip.frame_rate
                assert speed.max() < 0.02, (clip.name, side)


def test_each_foot_bears_the_weight_for_part_of_the_walk_and_one_always_does(walkers):
    for clip in walkers:
        points = {side: sole(clip, side) for side in SIDES}
        down = {side: (p[:, 3, 2] < FLOOR_TOE + 0.002) | (p[:, 0, 2] < 0.002) for side, p in points.items()}
        assert np.all(down["Left"] | down["Right"]), clip.name
        for side in SIDES:
            assert 0.5 < np.mean(down[side]) < 0.9, (clip.name, side)


def test_no_foot_below_the_floor_and_toes_clear_it_in_the_swing(clips):
    for clip, side in itertools.product(clips.values(), SIDES):
        points = sole(clip, side)
        assert points[:, :3, 2].min() > -0.005, (clip.name, side)
        speed = np.linalg.norm(np.gradient(points[:, 3], axis=0), axis=1) * clip.frame_rate
        swinging = speed > 2.0
        if swinging.any():
            assert points[swinging, 3, 2].min() > FLOOR_TOE + 0.005, (clip.name, side)


def test_feet_do_not_strike_each_other(clips):
    weights = np.linspace(0, 1, 8)[:, None, None]
    for clip in clips.values():
        left, right = (sole(clip, side) for side in SIDES)
        left, right = ((1 - weights) * p[:, 0] + weights * p[:, 2] for p in (left, right))
        gaps = np.linalg.norm(left[:, None] - right[None, :], axis=-1)
        assert gaps.min() > 0.06, clip.name


def test_feet_point_where_the_body_goes(walkers):
    for clip, side in itertools.product(walkers, SIDES):
        foot = joint(clip, side + "ToeBase") - joint(clip, side + "Foot")
        level = np.hypot(foot[:, 0], foot[:, 1]) > 0.08
        off = np.angle(np.exp(1j * (np.arctan2(foot[:, 1], foot[:, 0]) - clip.ground_path[:, 2])))
        assert np.abs(off[level]).max() < np.radians(35), (clip.name, side)


# Body


def test_knees_bend_forward_and_are_never_quite_straight(clips):
    for clip, side in itertools.product(clips.values(), SIDES):
        hip, knee, ankle = (joint(clip, side + bone) for bone in ("UpLeg", "Leg", "Foot"))
        heading = clip.ground_path[:, 2]
        forward = np.column_stack([np.cos(heading), np.sin(heading), 0 * heading])
        thigh, shin = knee - hip, ankle - knee
        along = (ankle - hip) / np.linalg.norm(ankle - hip, axis=1, keepdims=True)
        # The knee lies before the line from hip to ankle.
        out = thigh - np.sum(thigh * along, axis=1, keepdims=True) * along
        assert np.sum(out * forward, axis=1).min() > 0.01, (clip.name, side)
        cosine = np.sum(thigh * shin, axis=1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shin, axis=1)
        flexion = np.degrees(np.arccos(cosine))
        assert flexion.min() > 7, (clip.name, side)
        assert flexion.max() < (125 if STEP_TAG in clip.tags else 80), (clip.name, side)


@pytest.mark.parametrize(("name", "low", "high"), [("walk", 0.018, 0.045), ("walk_brisk", 0.025, 0.06)])
def test_hips_rise_and_fall_twice_a_stride(clips, name, low, high):
    clip = clips[name]
    height = clip.translations[:, 0, 2]
    assert low < np.ptp(height) < high
    middle = (height.max() + height.min()) / 2
    rises = int(np.sum((height[:-1] < middle) & (height[1:] >= middle)))
    assert abs(rises - steps_counted(clip)) <= 1


def test_hips_sway_over_the_standing_foot(clips):
    clip = clips["walk"]
    sideways = clip.translations[:, 0, 0]  # it walks along -Y; its left is +X
    only = {}
    for side, other in (SIDES, SIDES[::-1]):
        points, others = sole(clip, side), sole(clip, other)
        only[side] = (points[:, 3, 2] < FLOOR_TOE + 0.001) & (others[:, 3, 2] > FLOOR_TOE + 0.02)
    assert sideways[only["Left"]].mean() - sideways[only["Right"]].mean() > 0.02
    assert np.ptp(sideways) < 0.10


@pytest.mark.parametrize("name", STRAIGHT)
def test_arms_swing_against_the_legs_and_elbows_bend_forward(clips, name):
    clip = clips[name]

    def angle(upper, lower):
        """How far forward (-Y) of straight down a bone points."""
        bone = joint(clip, lower) - joint(clip, upper)
        return np.arctan2(-bone[:, 1], -bone[:, 2])

    for side, other in (SIDES, SIDES[::-1]):
        arm = angle(side + "Arm", side + "ForeArm")
        assert np.corrcoef(arm, angle(side + "UpLeg", side + "Foot"))[0, 1] < -0.75
        assert np.corrcoef(arm, angle(other + "UpLeg", other + "Foot"))[0, 1] > 0.75
        assert np.radians(15) < np.ptp(arm) < np.radians(60)
        assert np.all(angle(side + "ForeArm", side + "Hand") > arm + np.radians(5))
        # The arms hang: hands beside the hips, well below the shoulders.
        assert np.all(joint(clip, side + "Hand")[:, 2] < joint(clip, side + "Arm")[:, 2] - 0.35)


def test_hands_hang_beside_the_thighs(clips):
    for clip, (side, sign) in itertools.product(clips.values(), zip(SIDES, (1, -1), strict=True)):
        across = joint(clip, "LeftUpLeg") - joint(clip, "RightUpLeg")
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        beside = sign * np.sum((joint(clip, side + "Hand") - joint(clip, side + "UpLeg")) * across, axis=1)
        assert np.median(beside) > 0.09, (clip.name, side)


def test_body_leans_little_and_the_head_stays_level(clips):
    for clip in clips.values():
        trunk = joint(clip, "Neck") - joint(clip, "Hips")
        lean = np.degrees(np.arctan2(np.hypot(trunk[:, 0], trunk[:, 1]), trunk[:, 2]))
        assert lean.max() < 15, clip.name
        index = clip.skeleton.index("Head")
        up = (as_rotation(clip.world[0][:, index]) * rest_world(clip.skeleton)[index].inv()).apply([0, 0, 1])
        assert np.degrees(np.arccos(up[:, 2])).max() < (22 if STEP_TAG in clip.tags else 6), clip.name


# What the names promise


@pytest.mark.parametrize(("name", "speed"), STRAIGHT.items())
def test_straight_walks_keep_their_speed(clips, name, speed):
    path = clips[name].ground_path
    assert np.hypot(*path[-1, :2]) / clips[name].duration == pytest.approx(speed, rel=0.05)
    assert abs(path[-1, 0]) < 0.1  # along -Y


@pytest.mark.parametrize(("name", "degrees"), TURNS.items())
def test_turns_turn_as_far_as_they_say(clips, name, degrees):
    clip = clips[name]
    stride = 5 if name in STANDING else 16 if name.startswith("arc") else 32
    start, end = straight_heading(clip, 0, stride), straight_heading(clip, -stride, None)
    tolerance = 14 if name.startswith("arc") else 5
    assert np.degrees(end - start) == pytest.approx(degrees, abs=tolerance)


def test_speed_changes_go_from_slow_to_brisk_and_back(clips):
    for name, first, last in (("walk_faster", 0.8, 1.6), ("walk_slower", 1.6, 0.8)):
        speed = np.hypot(*np.diff(clips[name].ground_path[:, :2], axis=0).T) * 30
        assert speed[:8].mean() == pytest.approx(first, rel=0.1)
        assert speed[-8:].mean() == pytest.approx(last, rel=0.1)


def test_starts_and_stops_rest_at_one_end_and_walk_at_the_other(clips):
    for name, clip in clips.items():
        speed = np.hypot(*np.diff(clip.ground_path[:, :2], axis=0).T) * 30
        if name.startswith("start"):
            assert speed[:4].max() < 0.05
            assert speed[-8:].mean() == pytest.approx(1.2, rel=0.08)
        elif name.startswith("stop"):
            assert speed[:8].mean() == pytest.approx(1.2, rel=0.08)
            assert speed[-4:].max() < 0.05
        elif name in STANDING:
            assert max(speed[0], speed[-1]) < 0.05


# Stepping over


@pytest.fixture(scope="module")
def crossings(clips):
    tagged = [clip for clip in clips.values() if clip.tags]
    assert len(tagged) >= 2
    return tagged


def test_both_feet_rise_high_within_the_tagged_frames_only(crossings):
    for clip in crossings:
        assert set(clip.tags) == {STEP_TAG}
        tagged = clip.tags[STEP_TAG]
        assert len(runs(tagged)) == 1
        for side in SIDES:
            lowest_point = sole(clip, side)[:, :3, 2].min(axis=1)
            assert lowest_point[tagged].max() > 0.25, (clip.name, side)
            assert lowest_point[~tagged].max() < 0.12, (clip.name, side)


def test_tag_lasts_from_the_lift_of_one_foot_to_the_landing_of_the_other(crossings):
    for clip in crossings:
        (tagged,) = runs(clip.tags[STEP_TAG])
        first, last = tagged[0], tagged[-1]
        toes = {side: sole(clip, side)[:, 3, 2] for side in SIDES}
        peak = {side: int(np.argmax(toes[side])) for side in SIDES}
        leading, trailing = sorted(SIDES, key=peak.get)
        # The leading foot is down right before the tag and up right after its start.
        assert toes[leading][first - 1] < FLOOR_TOE + 0.001
        assert np.all(toes[leading][first + 1 : peak[leading]] > FLOOR_TOE + 0.001)
        # The trailing foot's heel is up until the tag ends, and down right after.
        heel = sole(clip, trailing)[:, 0, 2]
        assert np.all(heel[peak[trailing] : last - 1] > 0.001)
        assert heel[last + 1] < 0.001
        assert 1.1 < np.hypot(*(clip.ground_path[last] - clip.ground_path[first])[:2]) < 1.6


def test_there_is_room_for_the_obstacle(crossings):
    depth, height = STEP_OBSTACLE
    for clip in crossings:
        points = np.concatenate([sole(clip, side)[:, :3] for side in SIDES], axis=1)
        # The walk goes along -Y. Follow every point between the frames too.
        between = np.linspace(0, 1, 8, endpoint=False)[:, None, None, None]
        points = ((1 - between) * points[:-1] + between * points[1:]).reshape(-1, 3)
        ahead = -points[:, 1]
        low = np.sort(ahead[points[:, 2] < height])
        within = clip.ground_path[clip.tags[STEP_TAG], 1]
        low = low[(low > -within[0]) & (low < -within[-1])]
        assert np.diff(low).max() > depth, clip.name


# Clips as material for a motion graph


def angles_between(a, b):
    """Angles (Fa, Fb, J) between the rotations of two sets of frames."""
    return 2 * np.arccos(np.clip(np.abs(np.einsum("ijk,ljk->ilj", a, b)), 0, 1))


def test_walks_begin_and_end_in_a_common_gait_and_stands_in_a_common_stance(clips):
    bones = [sample_skeleton().index(name) for name in COST_BONES]
    gait, stance = clips["walk"].rotations[:, bones], clips["stand"].rotations[:, bones]
    own_pace = ("walk_slow", "walk_brisk", "walk_faster", "walk_slower")
    for name, clip in clips.items():
        ends = clip.rotations[[0, -1]][:, bones]
        to_gait = (angles_between(ends, gait) ** 2).sum(axis=2).min(axis=1)
        to_stance = (angles_between(ends, stance) ** 2).sum(axis=2).min(axis=1)
        at_rest = [name in STANDING or name.startswith("start"), name in STANDING or name.startswith("stop")]
        if name not in own_pace:
            assert np.all(np.where(at_rest, to_stance, to_gait) < 0.05), name


def test_no_two_clips_are_copies_or_mirror_images(clips):
    skeleton = sample_skeleton()
    swap = [
        skeleton.index({"L": "Right" + name[4:], "R": "Left" + name[5:]}[name[0]]) if name.startswith(SIDES) else i
        for i, name in enumerate(skeleton.names)
    ]
    reflect = np.array([1, 1, -1, -1])
    # A reflection in X does to this skeleton's frames what ``reflect`` and ``swap`` say.
    np.testing.assert_allclose(
        np.abs(np.sum(skeleton.rest_rotations[swap] * reflect * skeleton.rest_rotations, axis=1)),
        1,
        atol=1e-9,
    )

    def distance(a, b):
        """Root mean square angle in degrees over the best common stretch of most of the shorter clip."""
        best = np.inf
        common = int(0.85 * min(len(a), len(b)))
        for shift in range(common - len(b), len(a) - common + 1):
            first, last = max(0, shift), min(len(a), len(b) + shift)
            cosine = np.abs(np.sum(a[first:last] * b[first - shift : last - shift], axis=2))
            angle = 2 * np.arccos(np.clip(cosine, 0, 1))
            best = min(best, np.degrees(np.sqrt(np.mean(angle**2))))
        return best

    assert distance(clips["walk"].rotations, clips["walk"].rotations[3:]) < 0.01
    for a, b in itertools.combinations(clips.values(), 2):
        mirrored = b.rotations[:, swap] * reflect
        assert distance(a.rotations, b.rotations) > 1.0, (a.name, b.name)
        assert distance(a.rotations, mirrored) > 1.0, (a.name, b.name)
