"""The capture director against embedding the larger motion graph from scratch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintRule, FootprintSettings, path_length
from core.embedding.node_set import NodeSet
from core.embedding.sweep import sweep_steps
from core.environment.environment import Environment
from core.environment.grid import SUBDIVISION, Grid
from core.environment.regions import RegionMask, RegionRule
from core.errors import EmbeddingError
from core.evaluation.capture.candidate import (
    Candidate,
    CandidateFamily,
    augmented,
    candidates,
    mean_speeds,
    move_words,
    template_segment,
)
from core.evaluation.capture.director import direct_capture_steps
from core.evaluation.capture.trial import chosen_segments, trials_steps
from core.evaluation.size import Objective, embedding_size
from core.motion.graph import MotionGraph, MotionSegment
from core.progress import finish
from tests.bench import problems

from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def random_candidates(graph, cell, rng, n):
    """Motions as random as those of the problem, between random segments."""
    tried = []
    for i in range(n):
        n_frames = int(rng.integers(2, 7))
        path = np.zeros((n_frames, 3))
        path[1:, :2] = np.cumsum(rng.normal(0, 0.8 * cell, (n_frames - 1, 2)), axis=0)
        path[:, 2] = np.linspace(0, rng.uniform(-np.pi, np.pi), n_frames)
        tags = {t: rng.random(n_frames) < 0.6 for t in ("step", "jump") if rng.random() < 0.5}
        segment = MotionSegment(f"new{i}", 0, 0, n_frames - 1, path, (n_frames - 1) / 30, tags)
        ends = [tuple(np.flatnonzero(rng.random(len(graph.segments)) < 0.5).tolist()) for _ in range(2)]
        tried.append(Candidate(f"new {i}", segment, ends[0], ends[1], bool(rng.random() < 0.3)))
    return tried


def assert_trials_equal_embedding(embedding, tried):
    """Every trial is the embedding of the larger graph, node for node; returns how often the old one did not grow."""
    trials = finish(trials_steps(embedding, tried))
    gains = {gain.candidate.words: gain for gain in finish(direct_capture_steps(embedding, tried)).gains}
    replaced = 0
    for index, candidate in enumerate(tried):
        whole = embed(augmented(embedding.graph, candidate), embedding.environment, embedding.settings)
        grown = finish(trials.try_steps(candidate, index))
        assert np.array_equal(grown.node_mask(), whole.node_mask()), candidate
        assert grown.n_links == whole.n_links
        gain = gains[candidate.words]
        old, new = embedding.covered(), whole.covered()
        assert gain.after == embedding_size(whole)
        assert np.array_equal(gain.opened, new.any(axis=2) & ~old.any(axis=2))
        assert gain.floor == np.count_nonzero(gain.opened) * embedding.environment.grid.cell_size**2
        assert gain.places == np.count_nonzero(new & ~old)
        assert not np.any(gain.opened & ~embedding.environment.free_cells())
        assert gain.grows == (not np.any(embedding.node_mask() & ~whole.node_mask()[..., :-1]))
        replaced += not gain.grows
    return replaced


@given(st.integers(0, 10**6), st.booleans())
def test_a_trial_is_the_embedding_of_the_larger_graph(seed, tiled):
    graph, environment = random_problem(seed, tiled)
    rng = np.random.default_rng(seed)
    embedding = embed(graph, environment, SETTINGS)
    assert_trials_equal_embedding(embedding, random_candidates(graph, environment.grid.cell_size, rng, 3))


def test_another_component_may_become_the_largest():
    """Guards the test above: there are cases where the old embedding does not grow, but is replaced."""
    replaced = 0
    for seed in range(200):
        graph, environment = random_problem(seed, False)
        rng = np.random.default_rng(seed)
        tried = random_candidates(graph, environment.grid.cell_size, rng, 4)
        replaced += assert_trials_equal_embedding(embed(graph, environment, SETTINGS), tried)
        if replaced > 5:
            return
    pytest.fail(f"only {replaced} embeddings were replaced")


def test_large_grounds_and_footprints_without_any_element():
    """Planes that travel alone, and a candidate that has no stencils at all."""
    grid = Grid((190, 190, 4), 0.2)
    rng = np.random.default_rng(0)
    coarse = rng.random((190, 190)) < 0.05
    environment = Environment(grid, np.kron(coarse, np.ones((SUBDIVISION, SUBDIVISION))).astype(bool))
    graph = hall().graph
    embedding = embed(graph, environment)
    assert embedding.network.packing.n_blocks > 1 and embedding.n_nodes > 500
    tried = random_candidates(graph, 0.2, rng, 3)
    assert_trials_equal_embedding(embedding, tried)
    none = EmbeddingSettings(FootprintSettings(0.0, 0.0, 0.0, 0.0, FootprintRule.CONSERVATIVE))
    nothing = embed(graph, Environment(Grid((4, 4, 4), 0.2), np.zeros((16, 16), dtype=bool)), none)
    assert_trials_equal_embedding(nothing, tried)


def test_the_director_is_exact_on_recorded_clips(data_folder):
    embedding = embed(problems.graph(0.12), problems.room(4.0, 4.0))
    tried = candidates(embedding, retimed=True)
    assert_trials_equal_embedding(embedding, tried[::12])


@given(st.integers(0, 10**6))
def test_the_sweep_of_some_segments_is_that_of_those_alone(seed):
    embedding = embed(*random_problem(seed, False), SETTINGS)
    sweep, segments, environment = embedding.unrolling.sweep, embedding.graph.segments, embedding.environment
    chosen = np.random.default_rng(seed).permutation(len(segments))[:2].tolist()
    some = chosen_segments(sweep, chosen)
    same = chosen_segments(sweep, range(len(segments)))
    assert (same.path, same.bounds, same.part, same.shift) == (sweep.path, sweep.bounds, sweep.part, sweep.shift)
    alone = finish(sweep_steps([segments[i] for i in chosen], some.stencils, environment.grid, environment.tags))
    assert (some.path, some.bounds, some.part) == (alone.path, alone.bounds, alone.part)
    assert np.array_equal(some.stencils.segment, alone.stencils.segment)


def hall():
    """A corridor that a straight walk can only leave by turning: what is missing is a turn."""
    path = np.array([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]], dtype=float)
    walk = MotionSegment("walk", 0, 0, 2, path, 2 / 30, {})
    half = np.array([[0, 0, 0], [0, 0, np.pi / 2], [0, 0, np.pi]], dtype=float)
    about = MotionSegment("about", 1, 0, 2, half, 2 / 30, {})
    graph = MotionGraph((), 30.0, (walk, about), np.array([[0, 0], [0, 1], [1, 0]]), np.zeros(3))
    blocked = np.ones((10, 10), dtype=bool)
    blocked[:, 1] = blocked[8, :] = False
    grid = Grid((10, 10, 4), 0.2)
    return embed(graph, Environment(grid, np.kron(blocked, np.ones((SUBDIVISION,) * 2)).astype(bool)))


def test_what_is_missing_is_found_and_said():
    embedding = hall()
    # Up and down one of the two arms; the other begins at their crossing.
    assert embedding_size(embedding).floor == pytest.approx(10 * 0.04)
    found = finish(direct_capture_steps(embedding))
    best = found.gains[0]
    assert best.floor == pytest.approx(9 * 0.04)
    assert "turn on the spot" in best.candidate.words
    assert found.describe()[0] == f"{best.candidate.words.capitalize()} would open 0.36 m²."
    straight = next(gain for gain in found.gains if gain.candidate.words == "a straight walk of 1.6 m")
    assert straight.floor == 0 and straight.describe() == "A straight walk of 1.6 m would open nothing."
    columns, rows = found.table()
    assert len(rows) == len(found.gains) and all(len(row) == len(columns) for row in rows)
    assert [gain.floor for gain in found.gains] == sorted((gain.floor for gain in found.gains), reverse=True)


def test_a_measure_ranks_what_opens_as_much():
    embedding = hall()
    nodes = Objective("number of nodes below a million", "", lambda e: 1e6 - e.n_nodes)
    tried = candidates(embedding, retimed=True)
    found = finish(direct_capture_steps(embedding, tried, nodes))
    assert all(gain.objective == gain.after.nodes - gain.before.nodes for gain in found.gains)
    keys = [(-gain.floor, -gain.places, -gain.objective) for gain in found.gains]
    assert keys == sorted(keys)
    assert "shorten the number of nodes below a million from" in found.describe()[0]


def test_required_tags_are_tried_and_open_what_requires_them():
    graph, grid = hall().graph, Grid((10, 3, 4), 0.2)
    corridor = np.ones((10, 3), dtype=bool)
    corridor[:, 1] = False
    mask = np.zeros((40, 12), dtype=bool)
    # Across the corridor, where only a step may pass.
    mask[3 * SUBDIVISION : 4 * SUBDIVISION] = True
    fence = RegionMask("fence", RegionRule.REQUIRE, "step", mask)
    blocked = np.kron(corridor, np.ones((SUBDIVISION,) * 2)).astype(bool)
    fenced = embed(graph, Environment(grid, blocked, (fence,)))
    assert embedding_size(fenced).floor == pytest.approx(6 * 0.04)
    found = finish(direct_capture_steps(fenced))
    assert found.gains[0].floor > 0
    tagged = {gain.candidate.words: gain for gain in found.gains if "with the tag 'step'" in gain.candidate.words}
    assert set(tagged) == {f"a straight walk of {length:g} m with the tag 'step'" for length in (0.4, 0.8, 1.2, 1.6)}
    opened = tagged["a straight walk of 0.8 m with the tag 'step'"]
    plain = next(gain for gain in found.gains if gain.candidate.words == "a straight walk of 0.8 m")
    assert opened.floor == pytest.approx(3 * 0.04) and plain.floor == 0


def test_the_family_of_candidates():
    embedding = hall()
    tried = candidates(embedding)
    assert len({candidate.words for candidate in tried}) == len(tried)
    # The walk: two links lead to it and two away, to and from the half turn only one.
    assert template_segment(embedding) == 0
    assert all((c.parents, c.children, c.repeats) == ((0, 1), (0, 1), True) for c in tried)
    # A half turn to the right leads where the half turn to the left does.
    assert not any("mirror" in candidate.words for candidate in tried)
    by_words = {candidate.words: candidate for candidate in tried}
    left = by_words["a 90 degree left turn over 0.8 m"].segment
    assert path_length(left) == pytest.approx(0.8, abs=0.01)
    radius = 0.8 / (np.pi / 2)
    assert left.path[-1] == pytest.approx([radius, radius, np.pi / 2])
    aside = by_words["a step of 0.4 m to the right"].segment
    assert aside.path[-1] == pytest.approx([0.0, -0.4, 0.0], abs=1e-12)
    assert by_words["a step of 0.8 m backwards"].segment.path[-1] == pytest.approx([-0.8, 0.0, 0.0], abs=1e-12)
    for candidate in tried:
        segment = candidate.segment
        assert len(segment.path) == segment.n_frames
        assert segment.duration == pytest.approx((segment.n_frames - 1) / embedding.graph.frame_rate)
    few = candidates(embedding, CandidateFamily((0.5,), (0.0,), (), False))
    assert [candidate.words for candidate in few] == ["a straight walk of 0.5 m"]
    assert move_words(0.9, np.radians(60)) == "a 60 degree left turn over 0.9 m"
    assert move_words(0.0, np.radians(-80)) == "an 80 degree right turn on the spot"


def test_mirror_images_and_retimed_segments_of_recorded_clips(data_folder):
    embedding = embed(problems.graph(0.12), problems.room(3.0, 3.0))
    graph = embedding.graph
    speed, turn_rate = mean_speeds(graph.segments)
    assert 0.5 < speed < 2.0 and 0.3 < turn_rate < 3.0
    by_name = {segment.name: i for i, segment in enumerate(graph.segments)}
    tried = candidates(embedding, retimed=True)
    mirrored = [candidate for candidate in tried if candidate.words.startswith("the mirror image")]
    assert mirrored
    for candidate in mirrored:
        original = graph.segments[by_name[candidate.words.split("'")[1]]]
        assert np.allclose(candidate.segment.path, original.path * [1, -1, -1])
        assert candidate.segment.duration == pytest.approx(original.duration)
    retimed = [candidate for candidate in tried if "times its speed" in candidate.words]
    assert len(retimed) == 10
    for candidate in retimed:
        i = by_name[candidate.words.split("'")[1]]
        assert np.allclose(candidate.segment.path[-1], graph.segments[i].path[-1])
        factor = candidate.segment.duration / graph.segments[i].duration
        assert min(abs(factor - 0.8), abs(factor - 1.25)) < 0.05
        assert candidate.children == tuple(graph.links[graph.links[:, 0] == i, 1].tolist())


def test_progress_rises():
    fractions = [progress.fraction for progress in direct_capture_steps(hall())]
    assert fractions == sorted(fractions) and all(0 <= f <= 1 for f in fractions)


def test_pruned_embeddings_are_refused():
    embedding = hall()
    first = min(plane & -plane for plane in embedding.planes if plane)
    pruned = finish(restrict_steps(embedding, NodeSet(tuple(plane & ~first for plane in embedding.planes))))
    assert 0 < pruned.n_nodes < embedding.n_nodes
    with pytest.raises(EmbeddingError, match="pruned"):
        finish(direct_capture_steps(pruned, candidates(embedding)[:1]))
