"""Crowds: every step is a link, nobody ever comes too close to anybody, and who gets no walk is named."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings, edited_path
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.playback.crowd import CrowdSettings, crowd_steps, scattered_starts
from core.playback.reservation import StencilPaths
from core.playback.walk import random_node
from core.progress import finish

from .explicit_walks import assert_links
from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def closest(crowd) -> float:
    """The least distance of any two, frame by frame and pair by pair, over all tiles around; to the walks' ends."""
    grid = crowd.embedding.environment.grid
    around = (-1, 0, 1) if grid.tiled else (0,)
    tiles = np.array([(a * grid.size[0], b * grid.size[1]) for a in around for b in around])
    least = np.inf
    for first, second in combinations(crowd.walks, 2):
        for p, q in zip(first.root_path[:, :2], second.root_path[:, :2], strict=False):
            apart = q - p
            if grid.tiled:
                apart = apart % grid.size
            least = min(least, np.hypot(*(apart + tiles).T).min())
    return least


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.booleans())
def test_nobody_meets_and_everybody_is_accounted_for(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    rng = np.random.default_rng(seed)
    starts = [random_node(embedding, rng) for _ in range(5)]
    radius = 0.6 * embedding.environment.grid.cell_size
    found = finish(crowd_steps(embedding, starts, 1.0, rng, CrowdSettings(radius, patience=300)))
    assert sorted([*found.walkers, *(u.walker for u in found.unserved)]) == list(range(5))
    assert all(f"Walker {u.walker + 1} " in u.reason for u in found.unserved)
    for walker, walk in zip(found.walkers, found.walks, strict=True):
        assert_links(walk)
        assert tuple(walk.states[0]) == starts[walker]
        assert walk.duration >= 1.0 - 1e-6
        assert found.n_frames == 31
    if len(found.walks) > 1:
        assert closest(found) >= 2 * radius
        assert found.closest >= closest(found) - 1e-9
        again = [w.root_path[:31, :2] for w in found.walks]
        assert np.array_equal(found.places, again)


def walked_alone(embedding, start, others, frames, radius) -> bool:
    """Whether any walk of so many frames from a start keeps clear of other walks: every way tried, nothing skipped."""
    grid, segments = embedding.environment.grid, embedding.graph.segments
    stencils, mask = embedding.unrolling.stencils, embedding.node_mask()
    valid = [embedding.unrolling.layout.unpack(plane) for plane in embedding.unrolling.valid]
    linked = set(map(tuple, embedding.graph.links.tolist()))

    def meets(frame, place) -> bool:
        return any(frame < len(path) and np.hypot(*(path[frame, :2] - place)) < 2 * radius + 1e-9 for path in others)

    seen = set()
    waiting = [] if meets(0, grid.positions(np.array(start[:2]))) else [(0, start)]
    while waiting:
        frame, (x, y, heading, segment) = waiting.pop()
        if frame >= frames:
            return True
        for k in np.flatnonzero(stencils.heading == heading).tolist():
            child = int(stencils.segment[k])
            if (segment, child) not in linked or not valid[k][x, y]:
                continue
            node = (x + int(stencils.dx[k]), y + int(stencils.dy[k]), int(stencils.destination_heading[k]), child)
            path = (
                grid.positions(np.array([x, y]))
                + edited_path(segments[child], heading, grid, stencils.position_error[k], stencils.heading_error[k])[
                    :, :2
                ]
            )
            later = frame + len(path) - 1
            if (later, node) in seen or not mask[node]:
                continue
            if not any(meets(frame + i, place) for i, place in enumerate(path)):
                seen.add((later, node))
                waiting.append((later, node))
    return False


@settings(max_examples=25)
@given(st.integers(0, 10**6))
def test_who_is_shut_in_really_is(seed):
    """With all the patience there is, the second walker is served exactly if any way is free of the first."""
    embedding = embed(*random_problem(seed, False), SETTINGS)
    assume(0 < embedding.n_nodes < 3000)
    rng = np.random.default_rng(seed)
    starts = [random_node(embedding, rng) for _ in range(2)]
    radius = rng.uniform(0.5, 1.5) * embedding.environment.grid.cell_size
    found = finish(crowd_steps(embedding, starts, 0.6, rng, CrowdSettings(radius, patience=10**6, repairs=0)))
    assert found.walkers[0] == 0
    possible = walked_alone(embedding, starts[1], [found.walks[0].root_path], 18, radius)
    assert (found.walkers == (0, 1)) == possible


@pytest.mark.parametrize("tiled", [False, True])
def test_twenty_in_a_room(tiled):
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (7, 7), 0.14, 16, tiled), []))
    starts = scattered_starts(embedding, 20, np.random.default_rng(1), 0.8)
    settings = CrowdSettings(radius=0.3)
    found = finish(crowd_steps(embedding, starts, 6.0, np.random.default_rng(1), settings))
    assert len(found.walks) >= 18, [u.reason for u in found.unserved]
    for walk in found.walks:
        assert_links(walk)
    assert closest(found) >= 0.6
    again = finish(crowd_steps(embedding, starts, 6.0, np.random.default_rng(1), settings))
    assert all(np.array_equal(a.states, b.states) for a, b in zip(found.walks, again.walks, strict=True))


def test_two_in_the_same_place_cannot_be_served():
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (5, 5), 0.2, 8), []))
    node = random_node(embedding, np.random.default_rng(0))
    found = finish(crowd_steps(embedding, [node, node], 3.0, np.random.default_rng(0)))
    assert found.walkers == (0,)
    assert "Walker 2 would start in the same place as walker 1" in found.unserved[0].reason


def test_starts_are_apart_and_on_the_floor():
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (5, 5), 0.2, 8, True), []))
    starts = np.array(scattered_starts(embedding, 12, np.random.default_rng(2), 0.7))
    assert embedding.node_mask()[tuple(starts.T)].all()
    places = embedding.environment.grid.positions(starts[:, :2])
    for a, b in combinations(places, 2):
        apart = np.abs(a - b)
        assert np.hypot(*np.minimum(apart, 5 - apart)) >= 0.7 - 1e-9
    with pytest.raises(WalkError, match=r"Only \d+ walkers found room"):
        scattered_starts(embedding, 500, np.random.default_rng(2), 0.7)


def test_paths_of_stencils_are_those_of_walks():
    embedding = embed(*random_problem(1, True), SETTINGS)
    paths, stencils = StencilPaths(embedding), embedding.unrolling.stencils
    for k in range(len(stencils)):
        path = edited_path(
            embedding.graph.segments[stencils.segment[k]],
            int(stencils.heading[k]),
            embedding.environment.grid,
            stencils.position_error[k],
            stencils.heading_error[k],
        )
        assert np.allclose(paths.positions[k, : paths.n_frames[k]], path[1:, :2], atol=1e-12)
        assert np.isnan(paths.positions[k, paths.n_frames[k] :]).all()


def test_impossible_crowds_say_why():
    embedding = embed(*random_problem(1, True), SETTINGS)
    rng = np.random.default_rng(0)
    with pytest.raises(WalkError, match="positive duration"):
        finish(crowd_steps(embedding, [], 0.0, rng))
    astray = tuple(np.argwhere(~embedding.node_mask())[0].tolist())
    with pytest.raises(WalkError, match="start of walker 1"):
        finish(crowd_steps(embedding, [astray], 1.0, rng))
    with pytest.raises(WalkError, match="radius of -1"):
        CrowdSettings(radius=-1.0)
    with pytest.raises(WalkError, match="patience"):
        CrowdSettings(patience=0)
