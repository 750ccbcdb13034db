"""Exact shortest times against Dijkstra's algorithm over the written-out links."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from core.embedding.embedding import EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintSettings
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.errors import EmbeddingError, EvaluationError
from core.evaluation.reach import NEVER, exit_frames_steps, time_from_steps, time_to_reach_steps
from core.evaluation.size import mean_time_to
from core.progress import finish

from .motion_graphs import recorded_graph, sample_graph
from .reference import random_problem
from .slow_motions import slower

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def node_set(embedding, nodes):
    """The set of (n, 4) nodes x, y, heading, segment."""
    x, y, heading, segment = np.asarray(nodes).T
    _, ny, n_headings, _ = embedding.shape
    return embedding.network.nodes(np.column_stack([segment * n_headings + heading, x * ny + y]))


def small_embedding(seed, tiled, slowness=1):
    graph, environment = random_problem(seed, tiled)
    return embed(slower(graph, slowness), environment, SETTINGS)


def field_of(forwards, embedding, nodes):
    """Times from a set of nodes, or to it."""
    return finish((time_from_steps if forwards else time_to_reach_steps)(embedding, nodes))


def slow_frames(embedding, links, chosen, forwards):
    """Frames of every node of ``to_csr`` to or from the chosen rows."""
    links = links.copy()
    links.data = np.round(links.data * embedding.graph.frame_rate)
    times = dijkstra(links if forwards else links.T, indices=chosen, min_only=True)
    return np.where(np.isfinite(times), times, NEVER).astype(int)


def chosen_rows(seed, nodes, n):
    return np.random.default_rng(seed).choice(len(nodes), min(n, len(nodes)), replace=False)


@settings(max_examples=250)
@given(st.integers(0, 10**6), st.booleans(), st.booleans(), st.integers(1, 4), st.sampled_from([1, 5, 12, 100]))
def test_times_equal_those_over_explicit_links(seed, tiled, forwards, n_goals, slowness):
    """In single bytes and in two, with and without windows that outgrow their base."""
    embedding = small_embedding(seed, tiled, slowness)
    nodes, links = embedding.to_csr()
    if len(nodes) == 0:
        return
    chosen = chosen_rows(seed, nodes, n_goals)
    field = finish(
        (time_from_steps if forwards else time_to_reach_steps)(embedding, node_set(embedding, nodes[chosen]))
    )
    assert np.array_equal(field.frames_at(nodes), slow_frames(embedding, links, chosen, forwards))


def test_random_times_are_long_enough_to_test_something():
    """Guards the test above: single bytes must overflow, and both types must occur."""
    longest, kinds = 0, set()
    for seed in range(60):
        embedding = small_embedding(seed, seed % 2 == 0, 12 if seed % 3 else 100)
        nodes = embedding.to_csr()[0]
        if len(nodes):
            field = finish(time_to_reach_steps(embedding, node_set(embedding, nodes[:1])))
            durations = [segment.n_frames - 1 for segment in embedding.graph.segments]
            narrow = min(durations) + 2 * max(durations) < 255
            kinds.add(narrow)
            longest = max(longest, int(field.frames_at(nodes).max()) if narrow else 0)
    assert longest > 255 and kinds == {False, True}


@pytest.mark.parametrize("forwards", [False, True])
@pytest.mark.parametrize("tiled", [False, True])
def test_times_equal_those_of_explicit_links_with_recorded_motions(data_folder, tiled, forwards):
    grid = Grid.over_rectangle((0, 0), (2.4, 2.8), 0.2, 8, tiled)
    blocked = np.zeros((48, 56), dtype=bool)
    blocked[20:26, 30:44] = True
    embedding = embed(recorded_graph(data_folder), Environment(grid, blocked))
    nodes, links = embedding.to_csr()
    assert len(nodes) > 1000
    chosen = chosen_rows(3, nodes, 5)
    field = finish(
        (time_from_steps if forwards else time_to_reach_steps)(embedding, node_set(embedding, nodes[chosen]))
    )
    expected = slow_frames(embedding, links, chosen, forwards)
    assert expected.max() > 100
    assert np.array_equal(field.frames_at(nodes), expected)


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.booleans(), st.booleans(), st.integers(0, 60))
def test_a_limit_leaves_out_what_is_later_and_nothing_else(seed, tiled, forwards, last):
    embedding = small_embedding(seed, tiled, 5)
    nodes = embedding.to_csr()[0]
    if len(nodes) == 0:
        return
    goal = node_set(embedding, nodes[chosen_rows(seed, nodes, 1)])
    search = time_from_steps if forwards else time_to_reach_steps
    whole = finish(search(embedding, goal)).frames_at(nodes)
    limited = finish(search(embedding, goal, limit=last / 30)).frames_at(nodes)
    assert np.array_equal(limited, np.where(whole <= last, whole, NEVER))


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.booleans(), st.integers(1, 5))
def test_delayed_goals_count_from_their_own_times(seed, tiled, n_delayed):
    embedding = small_embedding(seed, tiled, 5)
    nodes, links = embedding.to_csr()
    if len(nodes) == 0:
        return
    rng = np.random.default_rng(seed)
    chosen, delays = chosen_rows(seed, nodes, n_delayed), rng.integers(0, 400, min(n_delayed, len(nodes)))
    nothing = embedding.network.empty
    frames = finish(exit_frames_steps(embedding, nothing, None, (nodes[chosen], delays)))
    x, y, heading, segment = nodes.T
    found = frames[np.array(embedding.network.exit_group_of)[segment], heading, x, y]
    links.data = np.round(links.data * embedding.graph.frame_rate)
    expected = np.full(len(nodes), np.inf)
    for goal, delay in zip(chosen, delays, strict=True):
        # By at least one link: over the successors of each node.
        times = dijkstra(links.T, indices=goal)
        coo = links.tocoo()
        by_link = np.full(len(nodes), np.inf)
        np.minimum.at(by_link, coo.row, coo.data + times[coo.col])
        expected = np.minimum(expected, by_link + delay)
    assert np.array_equal(found, expected)


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.booleans(), st.booleans(), st.sampled_from([1, 12]))
def test_maps_and_sets_agree_with_single_nodes(seed, tiled, forwards, slowness):
    embedding = small_embedding(seed, tiled, slowness)
    nodes = embedding.to_csr()[0]
    if len(nodes) == 0:
        return
    goal = node_set(embedding, nodes[chosen_rows(seed, nodes, 2)])
    field = field_of(forwards, embedding, goal)
    frames = np.full(embedding.shape, np.inf)
    frames[tuple(nodes.T)] = field.frames_at(nodes)
    rate = np.float32(embedding.graph.frame_rate)
    assert np.array_equal(field.quickest(), (frames.min(axis=3) / rate).astype(np.float32))
    assert np.array_equal(field.floor(), (frames.min(axis=(2, 3)) / rate).astype(np.float32))
    finite = frames[np.isfinite(frames)].astype(int)
    if not forwards:
        assert mean_time_to(goal, "it").of(embedding) == pytest.approx(finite.mean() / 30)
        assert mean_time_to(embedding.network.empty, "it").of(embedding) == np.inf
    assert np.array_equal(field.histogram(), np.bincount(finite))
    cell = embedding.environment.grid.cell_size**2
    times = sorted({0.0, *(np.unique(finite) / 30).tolist()})
    for time in times:
        inside = frames <= round(time * 30)
        assert field.area_within(time) == pytest.approx(inside.any(axis=(2, 3)).sum() * cell)
    assert field.areas(times) == [field.area_within(time) for time in times]


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.booleans(), st.booleans())
def test_a_quickest_link_leads_on_from_everywhere(seed, tiled, forwards):
    embedding = small_embedding(seed, tiled)
    nodes, links = embedding.to_csr()
    if len(nodes) == 0:
        return
    field = field_of(forwards, embedding, node_set(embedding, nodes[:1]))
    start, end = links.nonzero()
    quickest = field.on_quickest_way(nodes[start], nodes[end])
    has_one = np.zeros(len(nodes), dtype=bool)
    has_one[(end if forwards else start)[quickest]] = True
    frames = field.frames_at(nodes)
    assert np.array_equal(has_one, frames > 0)
    assert frames[0] == 0
    taken = np.round(np.array([s.duration for s in embedding.graph.segments])[nodes[end, 3]] * 30).astype(int)
    away, near = (end, start) if forwards else (start, end)
    assert np.array_equal(quickest, (frames[away] > 0) & (frames[away] == frames[near].astype(int) + taken))


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.booleans())
def test_forwards_and_backwards_agree_and_obey_the_triangle(seed, tiled):
    embedding = small_embedding(seed, tiled)
    nodes = embedding.to_csr()[0]
    if len(nodes) == 0:
        return
    chosen = nodes[chosen_rows(seed, nodes, 5)]
    there = np.array(
        [finish(time_from_steps(embedding, node_set(embedding, [node]))).frames_at(chosen) for node in chosen],
        dtype=int,
    )
    back = np.array(
        [finish(time_to_reach_steps(embedding, node_set(embedding, [node]))).frames_at(chosen) for node in chosen]
    )
    assert np.array_equal(there, back.T)
    assert np.all(there[:, None, :] <= there[:, :, None] + there[None, :, :])


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.booleans(), st.floats(0.5, 1.0))
def test_more_links_never_make_it_longer(seed, tiled, share):
    embedding = small_embedding(seed, tiled)
    nodes = embedding.to_csr()[0]
    rng = np.random.default_rng(seed)
    if len(nodes) == 0:
        return
    fewer = finish(restrict_steps(embedding, node_set(embedding, nodes[rng.random(len(nodes)) < share])))
    left = fewer.to_csr()[0]
    if len(left) == 0:
        return
    goal = node_set(embedding, left[chosen_rows(seed, left, 1)])
    assert np.all(
        finish(time_to_reach_steps(embedding, goal)).frames_at(left)
        <= finish(time_to_reach_steps(fewer, goal)).frames_at(left)
    )


def test_places_off_the_ground_and_other_tiles():
    for tiled in (False, True):
        embedding = next(e for e in (small_embedding(seed, tiled) for seed in range(50)) if e.n_nodes > 20)
        nodes = embedding.to_csr()[0]
        field = finish(time_to_reach_steps(embedding, node_set(embedding, nodes[:1])))
        elsewhere = nodes + [embedding.shape[0], -2 * embedding.shape[1], 0, 0]
        expected = field.frames_at(nodes) if tiled else np.full(len(nodes), NEVER)
        assert np.array_equal(field.frames_at(elsewhere), expected)
        assert field.frames_at(tuple(nodes[3].tolist())) == field.frames_at(nodes)[3]
        absent = np.argwhere(~embedding.node_mask())
        assert np.all(field.frames_at(absent) == NEVER)


def test_what_cannot_be_answered_is_said():
    embedding = next(e for e in (small_embedding(seed, False) for seed in range(50)) if e.n_nodes > 20)
    goal = node_set(embedding, embedding.to_csr()[0][:1])
    with pytest.raises(EvaluationError, match="No walk of the embedding"):
        finish(time_to_reach_steps(embedding, embedding.network.empty))
    absent = node_set(embedding, np.argwhere(~embedding.node_mask())[:1])
    with pytest.raises(EvaluationError, match="No walk of the embedding"):
        finish(time_from_steps(embedding, absent))
    with pytest.raises(EvaluationError, match="limit"):
        finish(time_to_reach_steps(embedding, goal, limit=-1))
    with pytest.raises(EvaluationError, match="before the start"):
        finish(time_to_reach_steps(embedding, goal)).area_within(-1)
    tight = replace(embedding, settings=replace(embedding.settings, memory_limit=100.0))
    with pytest.raises(EmbeddingError, match="use a larger Cell Size"):
        finish(time_to_reach_steps(tight, goal))
    nothing = finish(restrict_steps(embedding, embedding.network.empty))
    with pytest.raises(EvaluationError, match="empty"):
        finish(time_to_reach_steps(nothing, goal))


def test_times_beyond_sixteen_bits_are_refused_unless_limited():
    embedding = next(e for e in (small_embedding(seed, False, 4000) for seed in range(200)) if long_ways(e))
    nodes = embedding.to_csr()[0]
    goal = node_set(embedding, nodes[:1])
    with pytest.raises(EmbeddingError, match="time limit"):
        finish(time_to_reach_steps(embedding, goal))
    field = finish(time_to_reach_steps(embedding, goal, limit=300))
    expected = slow_frames(embedding, embedding.to_csr()[1], [0], False)
    assert np.array_equal(field.frames_at(nodes), np.where(expected <= 9000, expected, NEVER))


def long_ways(embedding):
    nodes, links = embedding.to_csr()
    return len(nodes) > 0 and np.round(dijkstra(links.T, indices=0).max() * 30) > 65535


@pytest.mark.parametrize("tiled", [False, True])
@pytest.mark.parametrize("forwards", [False, True])
def test_memory_is_estimated_before_it_is_taken(tiled, forwards):
    grid = Grid.over_rectangle((0, 0), (5, 5), 0.25, 12, tiled)
    embedding = embed(sample_graph(), Environment(grid, np.zeros((80, 80), dtype=bool)))
    goal = node_set(embedding, np.argwhere(embedding.node_mask())[:1])
    search = time_from_steps if forwards else time_to_reach_steps
    tracemalloc.start()
    finish(search(embedding, goal))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    with pytest.raises(EmbeddingError, match="would need"):
        finish(search(replace(embedding, settings=replace(embedding.settings, memory_limit=peak - 1.0)), goal))
    finish(search(replace(embedding, settings=replace(embedding.settings, memory_limit=2.0 * peak)), goal))
