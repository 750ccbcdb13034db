"""Synthesis: what is played is the clips along the walk, with nothing but the seams changed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.embedding.embedding import embed
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.motion.graph import build_motion_graph
from core.motion.heading import with_steady_heading
from core.motion.repertoire import sample_repertoire
from core.playback.synthesis import SynthesisSettings, synthesize
from core.playback.transitions import transition_gaps
from core.playback.walk import Walk, WalkSettings, random_walk_steps
from core.progress import finish

from .motion_graphs import recorded_graph, sample_graph
from .rotations import as_rotation

SETTINGS = SynthesisSettings(blend_duration=0.25)


@pytest.fixture(scope="module", params=["sample", "recorded", "tiled", "steady heading"])
def walk(request):
    graph = recorded_graph(request.getfixturevalue("data_folder")) if request.param == "recorded" else sample_graph()
    if request.param == "steady heading":
        graph = build_motion_graph([with_steady_heading(clip) for clip in sample_repertoire()])
    grid = Grid.over_rectangle((0, 0), (6, 6), 0.15, 24, tiled=request.param == "tiled")
    embedding = embed(graph, build_environment(grid, np.empty((0, 3, 3))))
    return finish(random_walk_steps(embedding, np.random.default_rng(3), WalkSettings(60.0)))


@pytest.fixture(scope="module")
def played(walk):
    return synthesize(walk, SETTINGS)


def outside(walk):
    """(F,) bool: frames farther from every seam than the longest blend."""
    window = round(SETTINGS.blend_duration * walk.embedding.graph.frame_rate)
    return np.abs(np.arange(walk.node_frames[-1] + 1)[:, None] - walk.node_frames[1:-1]).min(axis=1) > window


def turns(rotations):
    """(F - 1, J, 3) rotation vectors from each frame to the next."""
    return (
        (as_rotation(rotations[:-1]).inv() * as_rotation(rotations[1:])).as_rotvec().reshape(-1, rotations.shape[1], 3)
    )


def test_root_follows_the_checked_path(walk, played):
    path, expected = played.ground_path, walk.root_path.copy()
    expected[:, 2] += 2 * np.pi * np.rint((path[0, 2] - expected[0, 2]) / (2 * np.pi))
    away = np.linalg.norm(path[:, :2] - expected[:, :2], axis=1)
    assert away.max() <= SETTINGS.root_tolerance + 1e-9
    assert away.max() > 1e-4 or len(walk) < 2
    grid = walk.embedding.environment.grid
    assert np.allclose(path[walk.node_frames, :2], grid.positions(walk.states[:, :2]), atol=1e-9)
    turned = path[walk.node_frames, 2] / grid.heading_step - walk.states[:, 2]
    assert np.allclose((turned + grid.n_headings / 2) % grid.n_headings, grid.n_headings / 2, atol=1e-9)
    assert np.allclose(path[outside(walk)], expected[outside(walk)], atol=1e-12)
    exact = synthesize(walk, replace(SETTINGS, root_tolerance=0.0))
    assert np.allclose(exact.ground_path[:, :2], expected[:, :2], atol=1e-12)


def test_root_velocity_is_continuous_at_seams(walk, played):
    """What is added to the checked path on both sides of a seam is a cubic whose slopes make up for the jump."""
    rate, seams = walk.embedding.graph.frame_rate, walk.node_frames[1:-1]
    smooth = synthesize(walk, replace(SETTINGS, root_tolerance=1.0)).ground_path
    path = walk.root_path.copy()
    path[:, 2] += 2 * np.pi * np.rint((smooth[0, 2] - path[0, 2]) / (2 * np.pi))
    steps = np.arange(4)
    for seam, (before, after) in zip(seams, zip(walk.segments, walk.segments[1:], strict=False), strict=True):
        if min(walk.embedding.graph.segments[s].n_frames for s in (before, after)) < 16:
            continue
        # The slopes at the seam of the cubics through the added values of four frames on each side.
        slopes = [
            sign * np.polynomial.polynomial.polyfit(steps, (smooth - path)[seam + sign * steps], 3)[1]
            for sign in (-1, 1)
        ]
        jump = path[seam + 1] - 2 * path[seam] + path[seam - 1]
        # The frame's own acceleration is part of that difference; it is all that remains.
        acceleration = np.abs(np.diff(path[seam - 4 : seam + 5], n=2, axis=0))
        acceleration[[2, 3, 4]] = 0
        assert np.all(np.abs(jump + slopes[1] - slopes[0]) <= 3 * acceleration.max(axis=0) + 0.03 / rate)
    jolt, jolt_before, jolt_limited = (
        np.abs(np.diff(p, n=2, axis=0)[seams - 1]).mean(axis=0) for p in (smooth, path, played.ground_path)
    )
    assert np.all(jolt < jolt_before / 1.5) and np.all(jolt_limited < jolt_before)


def test_outside_the_windows_the_root_stands_to_its_heading_as_in_the_clip(walk, played):
    graph, window = walk.embedding.graph, round(SETTINGS.blend_duration * walk.embedding.graph.frame_rate)
    for i, index in enumerate(walk.segments):
        segment = graph.segments[index]
        clip = graph.clips[segment.clip]
        inner = np.arange(window, segment.n_frames - window)
        turned = played.ground_path[walk.node_frames[i] + inner, 2] - clip.ground_path[segment.first + inner, 2]
        expected = Rotation.from_euler("z", turned[:, None]) * as_rotation(clip.rotations[segment.first + inner, 0])
        found = as_rotation(played.rotations[walk.node_frames[i] + inner, 0])
        assert np.all((expected.inv() * found).magnitude() < 1e-9)


def test_nothing_changes_outside_the_windows(walk, played):
    graph, window = walk.embedding.graph, round(SETTINGS.blend_duration * walk.embedding.graph.frame_rate)
    untouched = 0
    for i, index in enumerate(walk.segments):
        segment = graph.segments[index]
        clip = graph.clips[segment.clip]
        inner = np.arange(window, segment.n_frames - window)
        untouched += len(inner)
        assert np.allclose(
            played.rotations[walk.node_frames[i] + inner, 1:], clip.rotations[segment.first + inner, 1:], atol=1e-9
        )
        assert np.allclose(
            played.translations[walk.node_frames[i] + inner, 0, 2],
            clip.translations[segment.first + inner, 0, 2],
            atol=1e-12,
        )
    assert untouched > 300


def test_poses_and_velocities_are_continuous_at_seams(walk, played):
    """Changes of angular velocity from frame to frame at the seams stay within what the clips themselves show."""
    graph = walk.embedding.graph
    change = np.linalg.norm(np.diff(turns(played.rotations)[:, 1:], axis=0), axis=2)
    usual = np.concatenate([np.linalg.norm(np.diff(turns(c.rotations)[:, 1:], axis=0), axis=2) for c in graph.clips])
    seams = walk.node_frames[1:-1]
    at_seams = change[seams - 1]
    assert at_seams.max() <= usual.max()
    assert np.quantile(at_seams, 0.99) <= 1.5 * np.quantile(usual, 0.99)
    # The same walk without blending breaks this: the test can tell the difference.
    hard = synthesize(walk, SynthesisSettings(blend_duration=0.0))
    jumps = np.linalg.norm(np.diff(turns(hard.rotations)[:, 1:], axis=0), axis=2)
    assert np.quantile(jumps[seams - 1], 0.99) > 1.5 * np.quantile(at_seams, 0.99)


def test_a_segment_and_its_own_continuation_play_like_the_clip(walk):
    graph = walk.embedding.graph
    follows = {
        (a, b)
        for a, b in graph.links.tolist()
        if graph.segments[a].clip == graph.segments[b].clip and graph.segments[a].last == graph.segments[b].first
    }
    pairs = list(zip(walk.segments, walk.segments[1:], strict=False))
    at = next(i for i, pair in enumerate(pairs) if pair in follows)
    both = Walk(walk.embedding, walk.states[at : at + 3], walk.stencils[at : at + 2])
    first, last = (graph.segments[s] for s in both.segments)
    clip = graph.clips[first.clip]
    played = synthesize(both, SETTINGS)
    assert np.allclose(played.rotations[:, 1:], clip.rotations[first.first : last.last + 1, 1:], atol=1e-9)


def test_quaternions_are_unit_and_bones_keep_their_lengths(walk, played):
    assert np.allclose(np.linalg.norm(played.rotations, axis=2), 1, atol=1e-9)
    clip = walk.embedding.graph.clips[0]
    length = np.linalg.norm(clip.translations[0, 1:], axis=1)
    assert np.allclose(np.linalg.norm(played.translations[:, 1:], axis=2), length, atol=1e-6)


def test_angular_velocities_of_both_sides_are_the_same_at_seams(walk):
    """What is added on each side turns the joints at such a rate that both arrive at one angular velocity."""
    gaps, h = transition_gaps(walk), 1e-5
    graph = walk.embedding.graph
    segments = [graph.segments[s] for s in walk.segments]
    for seam in range(0, len(gaps.frames), 5):
        sides = []
        for side, (segment, sign) in enumerate(((segments[seam], 0.5), (segments[seam + 1], -0.5))):
            clip, frame = graph.clips[segment.clip], segment.first if side else segment.last
            around = [as_rotation(clip.rotations[i]) for i in (max(frame - 1, 0), min(frame + 1, clip.n_frames - 1))]
            seconds = (min(frame + 1, clip.n_frames - 1) - max(frame - 1, 0)) / clip.frame_rate
            omega = (around[0].inv() * around[1]).as_rotvec()[1:] / seconds
            pose = as_rotation(clip.rotations[frame, 1:])
            vector, rate = sign * gaps.turns[seam, 1:], gaps.turn_rates[seam, side, 1:]
            ends = [pose * Rotation.from_rotvec(omega * t) * Rotation.from_rotvec(vector + rate * t) for t in (-h, h)]
            sides.append((pose * Rotation.from_rotvec(vector), (ends[0].inv() * ends[1]).as_rotvec() / (2 * h)))
        (pose_a, velocity_a), (pose_b, velocity_b) = sides
        assert (pose_a.inv() * pose_b).magnitude().max() < 1e-9
        assert np.allclose(velocity_a, velocity_b, atol=1e-5)


def test_each_transition_can_be_given_its_own_window(walk):
    gaps, rate = transition_gaps(walk), walk.embedding.graph.frame_rate
    plain = synthesize(walk, SynthesisSettings(blend_duration=0.0))
    widest = int(gaps.angles.max(axis=1).argmax())
    given = np.full(len(gaps.frames), 0.0)
    given[widest] = 0.2
    one = synthesize(walk, blend_durations=given)
    changed = np.abs(one.rotations[:, 1:] - plain.rotations[:, 1:]).max(axis=(1, 2)) > 1e-9
    assert changed.any() and np.all(np.abs(np.flatnonzero(changed) - gaps.frames[widest]) <= 0.2 * rate)
    with pytest.raises(WalkError, match="transitions"):
        synthesize(walk, blend_durations=given[1:])


def test_a_closed_walk_can_be_repeated(walk):
    """A walk that comes back to its heading and segment: the clip's end goes over into its start."""
    keys = [tuple(state) for state in walk.states[:, 2:].tolist()]
    at, again = next((i, j) for i in range(len(keys)) for j in range(i + 2, len(keys)) if keys[i] == keys[j])
    part = Walk(walk.embedding, walk.states[at : again + 1], walk.stencils[at:again])
    played = synthesize(part, SETTINGS, closed=True)
    open_end = synthesize(part, SETTINGS)
    tilt = [Rotation.from_euler("z", -c.heading[:, None]) * as_rotation(c.rotations[:, 0]) for c in (played, open_end)]
    assert (tilt[0][0].inv() * tilt[0][-1]).magnitude() < 1e-9
    assert np.allclose(played.rotations[0, 1:], played.rotations[-1, 1:], atol=1e-12)
    step = turns(np.concatenate([played.rotations[-2:, 1:], played.rotations[1:2, 1:]]))
    jolt = np.linalg.norm(np.diff(turns(played.rotations[:, 1:]), axis=0), axis=2)
    assert np.linalg.norm(np.diff(step, axis=0), axis=2).max() <= 1.5 * jolt.max()
    middle = slice(10, -10)
    assert np.allclose(played.rotations[middle, 1:], open_end.rotations[middle, 1:], atol=1e-12)
    other = next(j for j in range(1, len(keys)) if keys[j] != keys[0])
    with pytest.raises(WalkError, match="loop"):
        synthesize(Walk(walk.embedding, walk.states[: other + 1], walk.stencils[:other]), closed=True)


def test_tags_are_those_of_the_segments(walk, played):
    expected = {tag: np.zeros(played.n_frames, dtype=bool) for tag in played.tags}
    for i, index in enumerate(walk.segments):
        for tag, mask in walk.embedding.graph.segments[index].tags.items():
            expected[tag][walk.node_frames[i] : walk.node_frames[i + 1] + 1] |= mask
    for tag, mask in played.tags.items():
        assert np.array_equal(mask, expected[tag])


def test_an_empty_walk_is_refused(walk):
    with pytest.raises(WalkError, match="no steps"):
        synthesize(Walk(walk.embedding, walk.states[:1], walk.stencils[:0]))
    with pytest.raises(WalkError, match="zero or more seconds"):
        SynthesisSettings(blend_duration=-1.0)
