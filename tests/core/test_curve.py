"""Walks along curves: the cheapest of all, by Dijkstra over explicit links and points; near, forward, to the end."""

import heapq

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.link_reader import LinkReader
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.playback.curve import MEASURED_FRAMES, CurveSettings, curve_points, walk_along_steps
from core.playback.prices import LinkPrices
from core.playback.reservation import StencilPaths
from core.playback.walk import Walk, WalkSettings, random_walk_steps
from core.progress import finish

from .explicit_walks import assert_links
from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def links_along(embedding, points, limits, node, point):
    """Every link from a node that has come to a point: (cost, node, point, stencil), from the walk's own path."""
    reader = LinkReader(embedding)
    # A link gets ahead by as much as the farthest of them reaches, and the width on both sides of a bend.
    way = StencilPaths(embedding).reach + 2 * limits.width
    ahead = points[point : point + int(np.ceil(way / np.linalg.norm(points[1] - points[0]))) + 1]
    for stencil in reader.stencils_from(node).tolist():
        walk = Walk(embedding, np.array([node, reader.follow(node, stencil)]), np.array([stencil]))
        n = walk.node_frames[-1]
        frames = [int(np.ceil(n * i / MEASURED_FRAMES)) for i in range(1, MEASURED_FRAMES + 1)]
        distance = np.linalg.norm(walk.root_path[frames, None, :2] - ahead, axis=2)
        if distance.min(axis=1).max() <= limits.width:
            price = LinkPrices(embedding).of(np.array([node[3]]), np.array([stencil]))[0] / 1000
            cost = (distance.min(axis=1) ** 2).mean() * walk.duration + limits.time_weight * price
            yield cost, reader.follow(node, stencil), point + int(np.argmin(distance[-1])), stencil


def least_cost(embedding, points, limits, start):
    least, queue, end = {(start, 0): 0.0}, [(0.0, start, 0)], np.inf
    while queue:
        cost, node, point = heapq.heappop(queue)
        if cost > least[node, point]:
            continue
        if point == len(points) - 1:
            return cost
        for more, there, ahead, _ in links_along(embedding, points, limits, node, point):
            if cost + more < least.get((there, ahead), np.inf) - 1e-12:
                least[there, ahead] = cost + more
                heapq.heappush(queue, (cost + more, there, ahead))
    return end


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.booleans())
def test_no_walk_along_a_curve_is_cheaper(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(0 < embedding.n_nodes < 400)
    rng = np.random.default_rng(seed)
    cell = embedding.environment.grid.cell_size
    # A curve that can be followed: through the places of a walk.
    path = finish(random_walk_steps(embedding, rng, WalkSettings(0.6))).root_path
    start = finish(random_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(0.1))).states[0]
    curve = path[:: max(len(path) // 4, 1), :2]
    assume(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum() > cell)
    limits = CurveSettings(width=1.5 * cell, beam=10**6)
    points = curve_points(curve, cell / 2)
    assume(len(points) < 60)
    start = tuple(start.tolist())
    expected = least_cost(embedding, points, limits, start)
    if not np.isfinite(expected):
        with pytest.raises(WalkError, match="No walk follows"):
            finish(walk_along_steps(embedding, curve, limits, start))
        return
    walk = finish(walk_along_steps(embedding, curve, limits, start))
    assert_links(walk)
    states, cost, point = walk.states.tolist(), 0.0, 0
    for node, stencil in zip(states, walk.stencils.tolist(), strict=False):
        found = [f for f in links_along(embedding, points, limits, tuple(node), point) if f[3] == stencil]
        more, _, point, _ = found[0]
        cost += more
    assert point == len(points) - 1
    assert cost == pytest.approx(expected)


@pytest.fixture(scope="module")
def hall():
    return embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (7, 8), 0.15, 16), []))


def test_an_s_through_a_hall(hall):
    x = np.linspace(1, 6, 30)
    curve = np.column_stack([x, 4 + 1.5 * np.sin(x)])
    walk = finish(walk_along_steps(hall, curve, CurveSettings(width=0.4, beam=100)))
    assert_links(walk)
    path = walk.root_path[:, :2]
    fine = curve_points(curve, 0.02)
    distance = np.linalg.norm(path[:, None] - fine, axis=2)
    assert distance.min(axis=1).max() < 0.45
    assert distance.min(axis=1).mean() < 0.12
    assert distance.min(axis=0).max() < 0.45, "a part of the curve was left out"
    at_seams = distance.argmin(axis=1)[walk.node_frames]
    assert np.all(np.diff(at_seams) > -10), "it went back"
    # Facing as asked at the end.
    facing = finish(walk_along_steps(hall, curve, CurveSettings(width=0.4, beam=100, heading=np.pi / 2)))
    assert facing.states[-1, 2] * hall.environment.grid.heading_step == pytest.approx(np.pi / 2)


def test_around_the_edge_of_a_tile():
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (4, 4), 0.2, 12, True), []))
    curve = [(1.0, 2.0), (9.0, 2.5)]
    walk = finish(walk_along_steps(embedding, curve, CurveSettings(beam=60)))
    assert_links(walk)
    assert np.linalg.norm(walk.root_path[-1, :2] - curve[1]) < 0.6
    assert np.all(np.abs(walk.root_path[:, 1] - 2.25) < 0.8)


def test_points_lie_evenly_along_the_line():
    points = curve_points([(0, 0), (1, 0), (1, 2)], 0.25)
    assert len(points) == 13
    assert np.allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.25)
    assert points[-1].tolist() == [1, 2]


def test_impossible_curves_say_why(hall):
    with pytest.raises(WalkError, match="at least two points"):
        finish(walk_along_steps(hall, [(1, 1)]))
    with pytest.raises(WalkError, match=r"only 0 m long"):
        finish(walk_along_steps(hall, [(1, 1), (1, 1)]))
    with pytest.raises(WalkError, match="Nobody can start"):
        finish(walk_along_steps(hall, [(-3, 1), (1, 1)]))
    with pytest.raises(WalkError, match="the farthest ends at"):
        finish(walk_along_steps(hall, [(5, 4), (12, 4)], CurveSettings(beam=30)))
    with pytest.raises(WalkError, match="positive width"):
        CurveSettings(width=0.0)
