"""Synthesis: what is played is the clips along the walk, with nothing but the seams changed."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.embedding.embedding import embed
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.motion.graph import build_motion_graph
from core.motion.heading import with_steady_heading
from core.motion.kinematics import as_rotation
from core.motion.repertoire import sample_repertoire
from core.playback.synthesis import SynthesisSettings, synthesize
from core.playback.walk import Walk, random_walk

from .motion_graphs import recorded_graph, sample_graph

SETTINGS = SynthesisSettings(blend_duration=0.25)


@pytest.fixture(scope="module", params=["sample", "recorded", "tiled", "steady heading"])
def walk(request):
    graph = recorded_graph(request.getfixturevalue("data_folder")) if request.param == "recorded" else sample_graph()
    if request.param == "steady heading":
        graph = build_motion_graph([with_steady_heading(clip) for clip in sample_repertoire()])
    grid = Grid.over_rectangle((0, 0), (6, 6), 0.15, 24, tiled=request.param == "tiled")
    embedding = embed(graph, build_environment(grid, np.empty((0, 3, 3))))
    return random_walk(embedding, np.random.default_rng(3), 60.0)


@pytest.fixture(scope="module")
def played(walk):
    return synthesize(walk, SETTINGS)


def turns(rotations):
    """(F - 1, J, 3) rotation vectors from each frame to the next."""
    return (
        (as_rotation(rotations[:-1]).inv() * as_rotation(rotations[1:])).as_rotvec().reshape(-1, rotations.shape[1], 3)
    )


def test_root_follows_the_checked_path(walk, played):
    path = played.ground_path
    assert np.allclose(path[:, :2], walk.root_path[:, :2], atol=1e-12)
    off = (path[:, 2] - walk.root_path[:, 2]) / (2 * np.pi)
    assert np.allclose(off, np.rint(off[0]), atol=1e-9)


def test_outside_the_windows_the_root_stands_to_its_heading_as_in_the_clip(walk, played):
    graph, window = walk.embedding.graph, round(SETTINGS.blend_duration * walk.embedding.graph.frame_rate)
    for i, index in enumerate(walk.segments):
        segment = graph.segments[index]
        clip = graph.clips[segment.clip]
        inner = np.arange(window, segment.n_frames - window)
        turned = played.ground_path[walk.seams[i] + inner, 2] - clip.ground_path[segment.first + inner, 2]
        expected = Rotation.from_euler("z", turned[:, None]) * as_rotation(clip.rotations[segment.first + inner, 0])
        found = as_rotation(played.rotations[walk.seams[i] + inner, 0])
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
            played.rotations[walk.seams[i] + inner, 1:], clip.rotations[segment.first + inner, 1:], atol=1e-9
        )
        assert np.allclose(
            played.translations[walk.seams[i] + inner, 0, 2], clip.translations[segment.first + inner, 0, 2], atol=1e-12
        )
    assert untouched > 300


def test_poses_and_velocities_are_continuous_at_seams(walk, played):
    """Changes of angular velocity from frame to frame at the seams stay within what the clips themselves show."""
    graph = walk.embedding.graph
    change = np.linalg.norm(np.diff(turns(played.rotations)[:, 1:], axis=0), axis=2)
    usual = np.concatenate([np.linalg.norm(np.diff(turns(c.rotations)[:, 1:], axis=0), axis=2) for c in graph.clips])
    seams = walk.seams[1:-1]
    at_seams = change[seams - 1]
    assert at_seams.max() <= usual.max()
    assert np.quantile(at_seams, 0.99) <= 1.5 * np.quantile(usual, 0.99)
    # The same walk without blending breaks this: the test can tell the difference.
    hard = synthesize(walk, SynthesisSettings(blend_duration=0.0))
    jumps = np.linalg.norm(np.diff(turns(hard.rotations)[:, 1:], axis=0), axis=2)
    assert np.quantile(jumps[seams - 1], 0.99) > 2 * np.quantile(at_seams, 0.99)


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


def test_tags_are_those_of_the_segments(walk, played):
    expected = {tag: np.zeros(played.n_frames, dtype=bool) for tag in played.tags}
    for i, index in enumerate(walk.segments):
        for tag, mask in walk.embedding.graph.segments[index].tags.items():
            expected[tag][walk.seams[i] : walk.seams[i + 1] + 1] |= mask
    for tag, mask in played.tags.items():
        assert np.array_equal(mask, expected[tag])


def test_an_empty_walk_is_refused(walk):
    with pytest.raises(WalkError, match="no steps"):
        synthesize(Walk(walk.embedding, walk.states[:1], walk.stencils[:0]))
    with pytest.raises(WalkError, match="zero or more seconds"):
        SynthesisSettings(blend_duration=-1.0)
