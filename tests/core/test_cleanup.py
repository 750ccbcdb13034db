"""Foot contact clean-up: planted feet stand still, and nothing else is touched."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from core.embedding.embedding import embed
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.motion.contacts import ContactSettings, foot_contacts, foot_joints, joint_contacts
from core.motion.repertoire import sample_repertoire, sample_skeleton
from core.motion.skeleton import Skeleton
from core.playback.cleanup import CleanupSettings, clean_feet, hold_plants
from core.playback.coupled_joints import find_coupled_joints
from core.playback.knee_easing import _UNSEEN, eased_foot_move
from core.playback.loop import loop_steps
from core.playback.plants import Plant, clip_plants, repeated, walk_plants
from core.playback.quality import foot_slide
from core.playback.synthesis import synthesize
from core.playback.two_bone import Leg, find_leg, leg_turns
from core.playback.walk import WalkSettings, random_walk_steps
from core.progress import finish

from .motion_graphs import recorded_graph, sample_graph
from .rotations import as_quaternions, as_rotation, matrices

SETTINGS = CleanupSettings()
CLIP = sample_repertoire()[0]


@cache
def hall(data_folder=None):
    """An empty hall for the recorded clips, or for the sample character."""
    graph = recorded_graph(data_folder) if data_folder else sample_graph()
    return embed(graph, build_environment(Grid.over_rectangle((0, 0), (6, 6), 0.15, 24), np.empty((0, 3, 3))))


@pytest.fixture(scope="module", params=[*(f"sample {seed}" for seed in range(8)), "recorded 3"])
def walk(request):
    """Walks of which every limit below holds: several by chance, which turn on the spot a lot."""
    motion, seed = request.param.split()
    embedding = hall(request.getfixturevalue("data_folder")) if motion == "recorded" else hall()
    return finish(random_walk_steps(embedding, np.random.default_rng(int(seed)), WalkSettings(40.0)))


@pytest.fixture(scope="module")
def played(walk):
    return synthesize(walk)


@pytest.fixture(scope="module")
def cleaned(walk, played):
    return clean_feet(walk, played, SETTINGS)


def leg_of(skeleton, side):
    leg = find_leg(skeleton, side, foot_joints(skeleton))
    assert isinstance(leg, Leg)
    return leg


def far_from(plants, n_frames, window):
    """(F,) bool: frames farther than ``window`` frames from every plant."""
    far = np.ones(n_frames, dtype=bool)
    for plant in plants:
        far[max(plant.first - window, 0) : plant.last + window + 1] = False
    return far


def test_feet_stand_still_no_worse_than_in_the_clips(walk, played, cleaned):
    plants, rate = walk_plants(walk), played.frame_rate
    graph = walk.embedding.graph
    source = np.concatenate([foot_slide(clip_plants(clip), clip.world[1], rate) for clip in graph.clips])
    before = foot_slide(plants, played.world[1], rate)
    after = foot_slide(plants, cleaned.clip.world[1], rate)
    # Steps that the clips lack are no slide.
    up = [cleaned.lifted[plant.first : plant.last + 1, plant.side] for plant in plants]
    after = after[~np.concatenate([lifted[1:] & lifted[:-1] for lifted in up])]
    assert before.mean() > 0.05  # there is something to do
    assert after.mean() <= 0.02 and after.mean() <= source.mean()


def test_each_plant_keeps_one_place_and_its_heights(played, cleaned):
    before, after = played.world[1], cleaned.clip.world[1]
    spreads = []
    for plant in cleaned.plants:
        frames = np.arange(plant.first, plant.last + 1)
        changes = np.flatnonzero(np.diff(plant.pivots)) + 1
        for stretch, pivots in zip(np.split(frames, changes), np.split(plant.pivots, changes), strict=True):
            spreads.append(np.ptp(after[stretch, pivots[0]], axis=0)[:2].max())
            spreads.append(np.abs(after[stretch, pivots[0], 2] - before[stretch, pivots[0], 2]).max())
    # A nearly straight leg gives way by less than anyone sees, where its foot comes down or leaves.
    assert np.mean(np.array(spreads) < 5e-4) > 0.96 and max(spreads) < 1e-3


def test_feet_keep_their_orientation_and_the_root_its_path(played, cleaned):
    feet = [joint for foot in foot_joints(played.skeleton) for joint in foot]
    turned = as_rotation(played.world[0][:, feet]).inv() * as_rotation(cleaned.clip.world[0][:, feet])
    assert turned.magnitude().max() < 1e-6
    assert np.array_equal(played.ground_path, cleaned.clip.ground_path)
    assert np.array_equal(played.translations[:, 1:], cleaned.clip.translations[:, 1:])  # bones keep their lengths


def test_frames_far_from_plants_are_untouched(walk, played):
    """With a short window there are such frames: jumps, and the middle of every step."""
    settings = CleanupSettings(window=0.1)
    cleaned = clean_feet(walk, played, settings)
    window = round(settings.window * played.frame_rate)
    far = far_from(cleaned.plants, played.n_frames, window)
    assert far.sum() > 5 or not far.any()
    assert np.array_equal(played.rotations[far], cleaned.clip.rotations[far])
    assert np.array_equal(played.translations[far], cleaned.clip.translations[far])
    assert not cleaned.touched[far].any()
    same = np.all(played.rotations == cleaned.clip.rotations, axis=(1, 2))
    assert np.array_equal(cleaned.touched | same, np.ones(played.n_frames, dtype=bool))
    # A foot is left alone far from its own plants, as the clips have them, but for hips lowered for the other one.
    for side, foot in enumerate(foot_joints(played.skeleton)):
        own = far_from([plant for plant in walk_plants(walk) if plant.side == side], played.n_frames, window)
        assert own.sum() > 20
        # Where those would make its knee snap, it gives way.
        away = np.abs(played.world[1][own][:, foot] - cleaned.clip.world[1][own][:, foot]).max(axis=(1, 2))
        assert np.mean(away < 1e-5) > 0.9 and away.max() < 0.01


def test_only_legs_and_hips_change(played, cleaned):
    skeleton = played.skeleton
    feet = foot_joints(skeleton)
    legs = [find_leg(skeleton, side, feet) for side in (0, 1)]
    moved = {joint for leg in legs for joint in (leg.thigh, leg.shin, leg.foot)}
    others = [joint for joint in range(skeleton.n_joints) if joint not in moved]
    assert np.array_equal(played.rotations[:, others], cleaned.clip.rotations[:, others])
    drop = played.translations[:, 0, 2] - cleaned.clip.translations[:, 0, 2]
    assert drop.min() >= 0 and drop.max() == pytest.approx(cleaned.largest_drop)
    assert drop.max() <= SETTINGS.max_drop + 1e-12 and np.abs(np.diff(drop, n=2)).max() < 0.006
    assert 0 < cleaned.largest_shift <= SETTINGS.max_shift


def test_knees_do_not_pop(played, cleaned):
    """Nearly straight legs that have to reach a little farther are what makes knees pop."""
    feet = foot_joints(played.skeleton)
    for side in (0, 1):
        knee = find_leg(played.skeleton, side, feet).shin
        turns = [
            (as_rotation(clip.rotations[:-1, knee]).inv() * as_rotation(clip.rotations[1:, knee])).as_rotvec()
            for clip in (played, cleaned.clip)
        ]
        before, after = (np.linalg.norm(np.diff(turn, axis=0), axis=1) for turn in turns)
        assert after.max() < 1.6 * before.max()
        assert np.quantile(after, 0.95) < 1.2 * np.quantile(before, 0.95)


def test_plants_are_those_of_the_clips_joined_across_seams(walk):
    """The slow obvious way: every frame of the walk asks the source frames played there."""
    graph = walk.embedding.graph
    feet = foot_joints(graph.clips[0].skeleton)
    expected = np.zeros((walk.node_frames[-1] + 1, 2, 2), dtype=bool)
    for i, index in enumerate(walk.segments):
        segment = graph.segments[index]
        source = joint_contacts(graph.clips[segment.clip])
        for k in range(segment.n_frames):
            for side in (0, 1):
                expected[walk.node_frames[i] + k, side] |= source[side][segment.first + k]
    found = np.zeros_like(expected)
    plants = walk_plants(walk)
    for plant in plants:
        assert plant.first == 0 or not expected[plant.first - 1, plant.side].any()
        assert plant.last == len(expected) - 1 or not expected[plant.last + 1, plant.side].any()
        for frame, pivot in zip(range(plant.first, plant.last + 1), plant.pivots.tolist(), strict=True):
            found[frame, plant.side] = expected[frame, plant.side]
            assert pivot == feet[plant.side][np.flatnonzero(expected[frame, plant.side])[-1]]
    assert np.array_equal(found, expected)
    assert sum(np.any((plant.first < walk.node_frames) & (walk.node_frames < plant.last)) for plant in plants) > 5


def test_joint_contacts_are_those_of_the_feet():
    clip = CLIP
    left, right = joint_contacts(clip)
    assert np.array_equal(np.column_stack([left.any(axis=1), right.any(axis=1)]), foot_contacts(clip))


@given(seed=st.integers(0, 10_000), extra=st.booleans())
def test_a_leg_reaches_any_place_within_reach(seed, extra):
    """Random legs, hips and targets; joints between thigh and shin are carried along; the bend's side is kept."""
    rng = np.random.default_rng(seed)
    names = ("hips", "thigh", "twist", "shin", "foot") if extra else ("hips", "thigh", "shin", "foot")
    n = len(names)
    skeleton = Skeleton(
        names,
        np.arange(-1, n - 1),
        Rotation.random(n, random_state=seed).as_quat(scalar_first=True),
        rng.uniform(0.2, 0.5, (n, 3)),
        np.array([1.0, 0.0, 0.0]),
    )
    leg = Leg(1, n - 2, n - 1)
    n_frames = 12
    rotations = np.tile(skeleton.rest_rotations, (n_frames, 1, 1))
    # The knee bends one way about one axis, as knees do.
    bend = Rotation.from_rotvec(rng.uniform(0.2, 0.6, (n_frames, 1)) * np.array([0.0, 0.6, 0.8]))
    rotations[:, leg.shin] = as_quaternions(as_rotation(rotations[:, leg.shin]) * bend, (n_frames,))
    translations = np.tile(skeleton.rest_translations, (n_frames, 1, 1))
    clip = replace(CLIP, skeleton=skeleton, rotations=rotations, translations=translations, tags={}, heading=None)
    world, positions = clip.world
    hip, knee, ankle = (positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    upper, lower = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    hips_move = rng.uniform(-0.05, 0.05, (n_frames, 3))
    direction = ankle - hip + rng.uniform(-0.3, 0.3, (n_frames, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    low, high = np.abs(upper - lower) * 1.05 + 0.02, 0.97 * (upper + lower)
    target = hip + hips_move + direction * rng.uniform(low, high)[:, None]
    thigh, shin = matrices(leg_turns(leg, world, positions, hips_move, target - ankle))
    new_knee = hip + hips_move + np.einsum("fij,fj->fi", thigh, knee - hip)
    reached = new_knee + np.einsum("fij,fj->fi", shin, ankle - knee)
    assert np.abs(reached - target).max() < 1e-4
    for turn in (thigh, shin):
        assert np.allclose(turn @ turn.transpose(0, 2, 1), np.eye(3), atol=1e-9)
    still = matrices(leg_turns(leg, world, positions, np.zeros((n_frames, 3)), np.zeros((n_frames, 3))))
    assert all(np.array_equal(turn, np.tile(np.eye(3), (n_frames, 1, 1))) for turn in still)


def test_a_leg_out_of_reach_points_at_its_target():
    clip = CLIP
    world, positions = clip.world
    leg = find_leg(clip.skeleton, 0, foot_joints(clip.skeleton))
    move = np.tile([0.0, 0.0, -5.0], (clip.n_frames, 1))
    thigh, shin = matrices(leg_turns(leg, world, positions, np.zeros_like(move), move))
    hip, knee, ankle = (positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    bones = np.einsum("fij,fj->fi", thigh, knee - hip) + np.einsum("fij,fj->fi", shin, ankle - knee)
    aim = ankle + move - hip
    cosine = np.sum(bones * aim, axis=1) / np.linalg.norm(bones, axis=1) / np.linalg.norm(aim, axis=1)
    assert cosine.min() > 0.9999


def renamed(skeleton, names):
    return replace(skeleton, names=tuple(names))


def test_legs_are_told_by_names_or_by_what_the_feet_hang_from():
    skeleton = sample_skeleton()
    feet = foot_joints(skeleton)
    named = [find_leg(skeleton, side, feet) for side in (0, 1)]
    assert [skeleton.names[j] for j in (named[0].thigh, named[0].shin, named[0].foot)] == [
        "LeftUpLeg",
        "LeftLeg",
        "LeftFoot",
    ]
    anonymous = renamed(skeleton, (f"bone{i}" for i in range(skeleton.n_joints)))
    assert [find_leg(anonymous, side, feet) for side in (0, 1)] == named


def test_a_foot_without_a_leg_is_left_as_it_is():
    """A stump: the left foot hangs from the hips. Its sentence says so, and the right one is held all the same."""
    skeleton = sample_skeleton()
    parents = skeleton.parents.copy()
    parents[skeleton.index("LeftFoot")] = skeleton.index("LeftUpLeg")
    stump = replace(skeleton, parents=parents)
    feet = foot_joints(stump)
    assert "'LeftFoot'" in find_leg(stump, 0, feet) and isinstance(find_leg(stump, 1, feet), Leg)
    clip = replace(CLIP, skeleton=stump)
    plants = [Plant(side, 3, 20, np.full(18, feet[side][1])) for side in (0, 1)]
    cleaned = hold_plants(clip, plants, SETTINGS)
    assert len(cleaned.untreated) == 1 and "LeftFoot" in cleaned.describe()
    assert {plant.side for plant in cleaned.plants} == {1}
    slide = foot_slide(list(cleaned.plants), cleaned.clip.world[1], clip.frame_rate)
    assert slide.max() < 1e-4 and cleaned.touched.any()
    assert np.array_equal(clip.rotations[:, feet[0]], cleaned.clip.rotations[:, feet[0]])


def test_feet_stand_on_where_a_loop_begins_anew(walk):
    """Two laps of a closed walk: the pose goes on, and a foot that stands at the end stands on."""
    part = finish(loop_steps(walk.embedding, np.random.default_rng(2), WalkSettings(6.0)))
    clip = synthesize(part, closed=True)
    cleaned = clean_feet(part, clip, closed=True).clip
    lap = clip.n_frames - 1
    positions = cleaned.world[1]
    away = clip.world[1][-1] - clip.world[1][0]
    assert np.allclose(positions[-1] - away, positions[0], atol=1e-5)
    assert np.allclose(cleaned.rotations[0, 1:], cleaned.rotations[-1, 1:], atol=1e-5)
    twice = np.concatenate([positions[:-1], positions + away[0] * [1.0, 1.0, 0.0]])
    plants = repeated(walk_plants(part), lap, 2)
    across = [plant for plant in plants if plant.first < lap < plant.last]
    assert across
    assert foot_slide(plants, twice, clip.frame_rate).mean() < 0.02
    assert foot_slide(across, twice, clip.frame_rate).max() < 0.3
    open_end = clean_feet(part, clip).clip.world[1]
    assert np.abs(open_end[-1] - away - open_end[0]).max() > 1e-4


def test_controls_go_with_the_feet_that_follow_them():
    """Two controls that hang from the root: one goes with the left foot, one with the body. And one below the first."""
    clip, skeleton = CLIP, CLIP.skeleton
    n, foot = skeleton.n_joints, foot_joints(CLIP.skeleton)[0][0]
    rotations, positions = clip.world
    root, offset = as_rotation(rotations[:, 0]), np.array([0.02, -0.05, 0.01])
    place = positions[:, foot] + as_rotation(rotations[:, foot]).apply(offset)
    control = root.inv().apply(place - positions[:, 0])
    turn = as_quaternions(root.inv() * as_rotation(rotations[:, foot]), (clip.n_frames,))
    rigged = Skeleton(
        (*skeleton.names, "foot_control", "body_control", "toe_control"),
        np.concatenate([skeleton.parents, [0, 0, n]]),
        np.concatenate([skeleton.rest_rotations, turn[:1], [[1.0, 0, 0, 0]], [[1.0, 0, 0, 0]]]),
        np.concatenate([skeleton.rest_translations, control[:1], [[0.0, 0, 0.1]], [[0.0, 0.1, 0]]]),
        skeleton.forward,
    )
    still = np.tile(rigged.rest_rotations[n + 1 :], (clip.n_frames, 1, 1))
    rest = np.tile(rigged.rest_translations[n + 1 :], (clip.n_frames, 1, 1))
    clip = replace(
        clip,
        skeleton=rigged,
        rotations=np.concatenate([clip.rotations, turn[:, None], still], axis=1),
        translations=np.concatenate([clip.translations, control[:, None], rest], axis=1),
    )
    legs = [leg_of(rigged, side) for side in (0, 1)]
    assert find_coupled_joints(rigged, legs, *clip.world) == {n: foot, n + 2: foot}
    # It makes no difference how long the character stands before it walks.
    longer = clip.taken(np.concatenate([np.zeros(20 * clip.n_frames, dtype=int), np.arange(clip.n_frames)]))
    assert find_coupled_joints(rigged, legs, *longer.world) == {n: foot, n + 2: foot}
    # The body is pushed about, so that planted feet slide.
    push = 0.03 * np.sin(np.arange(clip.n_frames) / 3)
    pushed = clip.translations.copy()
    pushed[:, 0, 1] += push
    cleaned = hold_plants(replace(clip, translations=pushed), clip_plants(clip), SETTINGS)
    assert cleaned.largest_shift > 0.02
    rotations, positions = cleaned.clip.world
    for joint in (n, n + 2):
        away = as_rotation(rotations[:, foot]).inv().apply(positions[:, joint] - positions[:, foot])
        expected = offset + (joint == n + 2) * np.array([0.0, 0.1, 0.0])
        assert np.abs(away - expected).max() < 1e-9
        assert (as_rotation(rotations[:, foot]).inv() * as_rotation(rotations[:, joint])).magnitude().max() < 1e-7
    assert np.array_equal(cleaned.clip.rotations[:, n + 1], clip.rotations[:, n + 1])
    assert np.array_equal(cleaned.clip.translations[:, n + 1], clip.translations[:, n + 1])


def test_nothing_is_coupled_to_a_foot_that_stands_most_of_the_time():
    """While a character stands, all of it is one piece: what counts is what goes with the foot when it walks."""
    clip = next(clip for clip in sample_repertoire() if clip.name == "stand")
    legs = [leg_of(clip.skeleton, side) for side in (0, 1)]
    longer = clip.taken(np.concatenate([np.zeros(20 * clip.n_frames, dtype=int), np.arange(clip.n_frames)]))
    assert find_coupled_joints(clip.skeleton, legs, *longer.world) == {}


def test_a_character_without_feet_keeps_its_motion(walk):
    clip = synthesize(walk)
    settings = CleanupSettings(contacts=ContactSettings(feet=(("NoSuchFoot",), ("Neither",))))
    cleaned = clean_feet(walk, clip, settings)
    assert cleaned.clip is clip and not cleaned.plants and not cleaned.touched.any()
    assert "NoSuchFoot" in cleaned.describe()


def dragged(start, way=0.5):
    """The rest pose for 60 frames, dragged along x in the ten frames from ``start`` on."""
    clip = replace(
        CLIP,
        rotations=np.tile(CLIP.skeleton.rest_rotations, (60, 1, 1)),
        translations=np.tile(CLIP.skeleton.rest_translations, (60, 1, 1)),
        tags={},
        heading=None,
    )
    share = np.clip((np.arange(60) - start) / 10, 0, 1)
    clip.translations[:, 0, 0] += way * (3 * share**2 - 2 * share**3)
    return clip


def test_a_plant_that_travels_too_far_is_parted():
    """A foot that is dragged for half a metre is not held in one place: it makes a step at its fastest frame."""
    clip = dragged(25)
    toe = foot_joints(clip.skeleton)[0][1]
    cleaned = hold_plants(clip, [Plant(0, 0, 59, np.full(60, toe))], SETTINGS)
    assert len(cleaned.plants) == 2
    first, second = cleaned.plants
    assert first.last < 30 < second.first
    assert foot_slide([first, second], cleaned.clip.world[1], 30.0).max() < 1e-3
    assert cleaned.largest_shift <= SETTINGS.max_shift
    whole = hold_plants(clip, [Plant(0, 0, 59, np.full(60, toe))], CleanupSettings(max_shift=1.0))
    assert len(whole.plants) == 1


def test_a_foot_stands_until_the_other_one_does():
    """Where the one comes down a frame after the other was last planted, none would stand in between."""
    clip = dragged(25, way=0.15)
    feet = foot_joints(clip.skeleton)
    plants = [Plant(0, 10, 29, np.full(20, feet[0][1])), Plant(1, 30, 49, np.full(20, feet[1][1]))]
    cleaned = hold_plants(clip, plants, SETTINGS)
    at = cleaned.clip.world[1][29:31, feet[0][1], :2]
    assert np.linalg.norm(np.diff(clip.world[1][29:31, feet[0][1], :2], axis=0)) > 0.01
    assert np.linalg.norm(np.diff(at, axis=0)) < 1e-4
    assert [(plant.first, plant.last) for plant in cleaned.plants] == [(10, 30), (30, 49)]


def test_a_foot_is_lifted_for_the_step_between_two_parts():
    """Up and down once, without jerks, and in the air while it travels from the one place straight to the other."""
    clip = dragged(25)
    toe = foot_joints(clip.skeleton)[0][1]
    plant = Plant(0, 0, 59, np.full(60, toe))
    cleaned = hold_plants(clip, [plant], SETTINGS)
    first, second = cleaned.plants
    place, raised = cleaned.clip.world[1][:, toe], cleaned.clip.world[1][:, toe, 2] - clip.world[1][:, toe, 2]
    between = slice(first.last + 1, second.first)
    assert 0.03 < raised.max() < 0.0601 and raised.min() > -1e-6
    assert np.abs(np.delete(raised, np.r_[between])).max() < 1e-4
    assert np.all(np.diff(place[:, 0]) > -1e-6) and np.ptp(place[:, 1]) < 1e-4
    assert np.count_nonzero(np.diff(np.sign(np.diff(raised[first.last : second.first + 1])))) <= 2
    assert np.abs(np.diff(place, n=2, axis=0)).max() < 0.04  # 36 m/s2, less than a foot's in walking
    assert np.array_equal(cleaned.lifted[:, 0], raised > 0.01) and not cleaned.lifted[:, 1].any()
    down = ~(cleaned.lifted[1:, 0] & cleaned.lifted[:-1, 0])
    travelled = plant.speeds(cleaned.clip.world[1], 1.0)
    assert travelled.sum() == pytest.approx(0.5, abs=0.02) and travelled[down].sum() < 0.1 * travelled.sum()


@pytest.mark.parametrize("start", [-4, 52])
def test_a_foot_that_travels_near_an_end_of_its_plant_comes_later_or_leaves_earlier(start):
    clip = dragged(start, 0.8)
    toe = foot_joints(clip.skeleton)[0][1]
    cleaned = hold_plants(clip, [Plant(0, 0, 59, np.full(60, toe))], SETTINGS)
    (held,) = cleaned.plants
    window = round(SETTINGS.window * clip.frame_rate)
    assert 0 < held.first <= window if start < 0 else 59 > held.last >= 59 - window
    assert foot_slide([held], cleaned.clip.world[1], 30.0).max() < 1e-3
    assert cleaned.lifted[:, 0].any() and not cleaned.lifted[held.first : held.last + 1, 0].any()


def test_hardly_a_foot_slides_while_it_is_on_the_ground(walk, played, cleaned):
    """The frames of steps that count as lifted are few, and so is what the others slide by."""
    plants, positions = walk_plants(walk), cleaned.clip.world[1]
    raised = positions[..., 2] - played.world[1][..., 2]
    speeds = []
    for plant in plants:
        up = cleaned.lifted[plant.first : plant.last + 1, plant.side]
        heights = raised[np.arange(plant.first, plant.last + 1), plant.pivots]
        assert np.all(heights[up] > 0.009)
        speeds.append(plant.speeds(positions, played.frame_rate)[~(up[1:] & up[:-1])])
    counted = np.concatenate(speeds)
    assert len(counted) > 0.95 * sum(plant.n_frames - 1 for plant in plants)
    assert counted.mean() < 0.004 and counted.max() < 0.5


def test_knees_are_accelerated_no_more_than_in_the_motion(played, cleaned):
    """No more than the motion there, or than it usually is, or than one notices; without easing, many are."""
    unseen = _UNSEEN / played.frame_rate**2
    for side in (0, 1):
        leg = leg_of(played.skeleton, side)
        before, after = (knee_accelerations(leg, clip.world[1]) for clip in (played, cleaned.clip))
        lifted = np.flatnonzero(cleaned.lifted[:, side])
        allowed = np.maximum(before, max(np.percentile(before, 99.5), unseen))
        near = np.min(np.abs(np.arange(1, played.n_frames - 1)[:, None] - lifted), axis=1, initial=99) < 8
        assert np.all((after <= 1.1 * allowed + 0.005) | near)


def knee_accelerations(leg, positions):
    """(F - 2,) radians per frame and frame."""
    thigh, shin = positions[:, leg.thigh] - positions[:, leg.shin], positions[:, leg.foot] - positions[:, leg.shin]
    cosine = np.sum(thigh * shin, axis=1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shin, axis=1)
    return np.abs(np.diff(np.arccos(np.clip(cosine, -1, 1)), 2))


@given(seed=st.integers(0, 10_000))
def test_an_eased_knee_gives_way_along_its_leg_only_where_it_would_snap(seed):
    """Random moves of a walking foot: nothing changes where the knee is calm, and the foot stays on the leg's line."""
    rng = np.random.default_rng(seed)
    leg, positions = leg_of(CLIP.skeleton, 0), CLIP.world[1]
    move = np.zeros((CLIP.n_frames, 3))
    first = int(rng.integers(5, CLIP.n_frames - 25))
    move[first : first + 15, :2] = rng.uniform(-0.06, 0.06, 2)
    hips = np.zeros_like(move)
    eased = eased_foot_move(leg, positions, hips, move, np.ones(CLIP.n_frames, dtype=bool), CLIP.frame_rate)
    outside = np.all(move == 0, axis=1)
    assert np.array_equal(eased[outside], move[outside])
    along = positions[:, leg.foot] + move - positions[:, leg.thigh]
    changed = eased - move
    assert np.abs(np.cross(along, changed)).max() < 1e-9 and np.linalg.norm(changed, axis=1).max() < 0.06
    still = np.zeros_like(move)
    assert np.array_equal(eased_foot_move(leg, positions, hips, still, outside, CLIP.frame_rate), still)
