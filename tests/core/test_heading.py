"""Headings that hips do not sway, and characters whose root is a bone on the ground."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.errors import ClipError
from core.motion.clip import MotionClip
from core.motion.contacts import foot_contacts
from core.motion.distance import pose_features
from core.motion.doctor import examine
from core.motion.graph import build_motion_graph
from core.motion.heading import steady_heading, with_steady_heading
from core.motion.in_place import with_root_motion
from core.motion.mirror import mirrored
from core.motion.repertoire import sample_repertoire
from core.motion.skeleton import Skeleton

from .bvh import read_bvh
from .dense_costs import transition_costs
from .motion_graphs import SHORT
from .rotations import as_quaternions, as_rotation

CLIPS = {clip.name: clip for clip in sample_repertoire()}
STRAIGHT = ("walk", "walk_again", "walk_slow", "walk_brisk")
RATE = 30.0


def spinning_top(heading):
    """A clip of one joint that only turns: no shoulders to look at."""
    skeleton = Skeleton(("root",), np.array([-1]), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 3)), np.array([1.0, 0, 0]))
    rotations = as_quaternions(Rotation.from_rotvec(heading[:, None] * [0.0, 0.0, 1.0]), (len(heading), 1))
    return MotionClip("top", skeleton, RATE, rotations, np.zeros((len(heading), 1, 3)))


def sway(heading):
    """Amplitude in degrees of what repeats with each stride in a heading that otherwise curves evenly."""
    time = np.arange(len(heading)) / RATE
    amplitudes = []
    for frequency in np.arange(0.55, 1.3, 0.05):
        angle = 2 * np.pi * frequency * time
        basis = np.column_stack([time**0, time, time**2, np.cos(angle), np.sin(angle)])
        amplitudes.append(np.hypot(*np.linalg.lstsq(basis, heading, rcond=None)[0][3:]))
    return np.degrees(max(amplitudes))


def test_hips_sway_and_the_steady_heading_does_not():
    for name in STRAIGHT:
        clip = CLIPS[name]
        assert sway(clip.root_heading) > 3
        assert sway(steady_heading(clip)) < 0.7
        assert sway(steady_heading(clip, bandwidth=None)) < 0.9  # shoulders against hips do most of it


def test_recorded_walks_sway_about_half_as_much(data_folder):
    before, after = [], []
    for name in ("16_16", "16_31", "16_32", "16_47", "05_01", "49_01", "07_03", "08_03"):
        clip = read_bvh(data_folder / "cmu_locomotion" / f"{name}.bvh")
        before.append(sway(clip.root_heading))
        after.append(sway(steady_heading(clip)))
    assert np.median(after) < 0.55 * np.median(before)


@pytest.mark.parametrize("name", ["turn_left_90", "turn_right_90", "turn_left_45", "pivot_left_180", "arc_left"])
def test_turns_are_followed(name):
    clip = CLIPS[name]
    heading = steady_heading(clip)
    assert np.abs(heading - clip.root_heading).max() < np.radians(13)
    asked = {"turn_left_90": 90, "turn_right_90": -90, "turn_left_45": 45, "pivot_left_180": 180, "arc_left": 80}[name]
    # Of the hips at the first and last frame alone one would say 100 for 90.
    assert np.degrees(heading[-1] - heading[0]) == pytest.approx(asked, abs=3 if name != "arc_left" else 10)


@pytest.mark.parametrize(("bandwidth", "most"), [(1.0, 3.5), (0.7, 7.5), (2.0, 1.0)])
def test_a_quarter_turn_in_a_second_is_rounded_off_by_what_the_docstring_says(bandwidth, most):
    share = np.clip(np.arange(151) / RATE - 2, 0, 1)
    turn = np.pi / 2 * (10 * share**3 - 15 * share**4 + 6 * share**5)
    error = steady_heading(spinning_top(turn), bandwidth) - turn
    assert np.degrees(np.abs(error).max()) < most
    # No delay: as much before the middle of the turn as after it.
    assert np.abs(error + error[::-1])[10:-10].max() < np.radians(0.2)


@pytest.mark.parametrize("bandwidth", [0.5, 1.0, 3.0])
def test_the_bandwidth_is_where_71_percent_pass(bandwidth):
    time = np.arange(1200) / RATE
    wave = 0.1 * np.sin(2 * np.pi * bandwidth * time)
    passed = steady_heading(spinning_top(wave), bandwidth)
    assert np.ptp(passed[300:900]) / np.ptp(wave) == pytest.approx(np.sqrt(0.5), abs=0.02)
    slow = 0.1 * np.sin(2 * np.pi * bandwidth / 4 * time)
    assert np.ptp(steady_heading(spinning_top(slow), bandwidth)) / np.ptp(slow) > 0.98


def test_the_steady_heading_turns_with_the_world_and_back_in_time():
    clip = CLIPS["turn_left_60"]
    heading = steady_heading(clip)
    rotations = clip.rotations.copy()
    rotations[:, 0] = as_quaternions(Rotation.from_euler("Z", 3.0) * as_rotation(rotations[:, 0]), (clip.n_frames,))
    offset = steady_heading(replace(clip, rotations=rotations)) - heading - 3.0
    np.testing.assert_allclose(offset, 2 * np.pi * np.round(offset[0] / (2 * np.pi)), atol=1e-6)
    backwards = replace(clip, rotations=clip.rotations[::-1], translations=clip.translations[::-1])
    offset = steady_heading(backwards)[::-1] - heading
    np.testing.assert_allclose(offset, 2 * np.pi * np.round(offset[0] / (2 * np.pi)), atol=np.radians(0.1))


def test_a_full_turn_is_not_wrapped():
    turn = np.linspace(0, 5 * np.pi, 200)
    np.testing.assert_allclose(steady_heading(spinning_top(turn)), turn, atol=1e-4)


def test_only_clips_that_are_given_a_heading_have_one():
    clip = CLIPS["walk"]
    assert clip.heading is None
    np.testing.assert_array_equal(clip.ground_path[:, 2], clip.root_heading)
    steady = with_steady_heading(clip)
    np.testing.assert_array_equal(steady.ground_path[:, 2], steady.heading)
    np.testing.assert_array_equal(steady.ground_path[:, :2], clip.ground_path[:, :2])
    np.testing.assert_array_equal(steady.rotations, clip.rotations)
    half = steady.resampled(15)
    np.testing.assert_allclose(half.heading, steady.heading[::2], atol=1e-9)
    with pytest.raises(ClipError, match="one angle per frame"):
        replace(clip, heading=np.zeros(3))
    with pytest.raises(ClipError, match="bandwidth"):
        steady_heading(clip, 0.0)


def test_segments_of_straight_walks_go_straight():
    wander = {}
    for heading in ("root", "steady"):
        clips = [CLIPS[name] if heading == "root" else with_steady_heading(CLIPS[name]) for name in STRAIGHT]
        graph = build_motion_graph(clips, SHORT)
        ends = np.array([segment.path[-1] for segment in graph.segments])
        wander[heading] = np.degrees(np.abs(np.column_stack([ends[:, 2], np.arctan2(ends[:, 1], ends[:, 0])]))).mean()
    assert wander["steady"] < 0.35 * wander["root"]


# Root bones: joint 0 on the ground below the hips, which it carries.


def with_root_bone(clip, steady=False):
    """The same motion of a character with a root bone on the ground that goes and turns with it."""
    skeleton, path = clip.skeleton, with_steady_heading(clip).ground_path if steady else clip.ground_path
    n_frames, n_joints = clip.n_frames, skeleton.n_joints
    turn = Rotation.from_rotvec(path[:, 2:] * [0.0, 0.0, 1.0])
    ground = np.column_stack([path[:, :2], np.zeros(n_frames)])
    rotations, translations = np.empty((n_frames, n_joints + 1, 4)), np.empty((n_frames, n_joints + 1, 3))
    rotations[:, 2:], translations[:, 2:] = clip.rotations[:, 1:], clip.translations[:, 1:]
    rotations[:, 0], translations[:, 0] = as_quaternions(turn, (n_frames,)), ground
    rotations[:, 1] = as_quaternions(turn.inv() * as_rotation(clip.rotations[:, 0]), (n_frames,))
    translations[:, 1] = turn.inv().apply(clip.translations[:, 0] - ground)
    rest = as_rotation(skeleton.rest_rotations[:1])
    facing = rest.apply(skeleton.forward)[0]
    rest_turn = Rotation.from_euler("Z", np.arctan2(facing[1], facing[0]))
    rest_rotations = np.concatenate([[rest_turn.as_quat(scalar_first=True)], skeleton.rest_rotations])
    rest_rotations[1] = as_quaternions(rest_turn.inv() * rest, (1,))[0]
    foot = skeleton.rest_translations[0] * [1, 1, 0]
    rest_translations = np.concatenate([[foot], skeleton.rest_translations])
    rest_translations[1] = rest_turn.inv().apply(skeleton.rest_translations[0] - foot)
    names, parents = ("Root", *skeleton.names), np.concatenate([[-1], skeleton.parents + 1])
    rooted = Skeleton(names, parents, rest_rotations, rest_translations, np.array([1.0, 0, 0]))
    return replace(clip, skeleton=rooted, rotations=rotations, translations=translations)


@pytest.fixture(scope="module", params=["walk", "turn_left_90", "step_over_left", "stop_left"])
def both(request):
    clip = CLIPS[request.param]
    return clip, with_root_bone(clip)


def test_a_root_bone_changes_neither_places_nor_paths_nor_contacts(both):
    clip, rooted = both
    np.testing.assert_allclose(rooted.world[1][:, 1:], clip.world[1], atol=1e-9)
    np.testing.assert_allclose(rooted.ground_path, clip.ground_path, atol=1e-9)
    np.testing.assert_array_equal(foot_contacts(rooted), foot_contacts(clip))


def test_a_root_bone_changes_neither_findings_nor_mirrors_nor_headings(both):
    clip, rooted = both
    assert examine(rooted) == ()
    np.testing.assert_allclose(mirrored(rooted).world[1][:, 1:], mirrored(clip).world[1], atol=1e-6)
    np.testing.assert_allclose(steady_heading(rooted), steady_heading(clip), atol=1e-6)
    translations = rooted.translations.copy()
    translations[:, 0, :2] = 0.0
    path = with_root_motion(replace(rooted, translations=translations)).ground_path
    gap = (path - path[0] - rooted.ground_path + rooted.ground_path[0])[:, :2]
    assert np.hypot(*gap.T).max() < 0.02 * np.hypot(*np.diff(clip.ground_path[:, :2], axis=0).T).sum()


def test_a_root_bone_does_not_change_the_cost(both):
    clip, rooted = both
    expected = transition_costs(*[pose_features(clip)] * 2)
    np.testing.assert_allclose(transition_costs(*[pose_features(rooted)] * 2), expected, atol=2e-4)
    assert expected.max() > 0.1
