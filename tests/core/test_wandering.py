"""Wandering: every step is a link, the way between two places is a cheapest one, and the floor is visited evenly."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import shortest_path

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.link_reader import LinkReader
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.playback.cheapest import cheapest_way_steps
from core.playback.prices import LinkPrices, PriceSettings
from core.playback.spikes import graph_roughness
from core.playback.walk import Trail, WalkSettings, random_node, random_walk_steps
from core.playback.wandering import _holds, _RingGuide, _rings, wandering_walk_steps
from core.progress import finish

from .explicit_walks import assert_links, explicit_least_price, explicit_links, explicit_price
from .motion_graphs import sample_graph
from .reference import explicit_embedding, random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


@given(st.integers(0, 10**6), st.booleans())
def test_every_step_is_a_link(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    links = set(map(tuple, explicit_embedding(embedding.graph, embedding.environment, SETTINGS).links.tolist()))
    walk = finish(wandering_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(5.0)))
    states = walk.states.copy()
    states[:, :2] %= embedding.shape[:2]
    index = np.ravel_multi_index(states.T, embedding.shape).tolist()
    assert all(pair in links for pair in pairwise(index))
    assert walk.duration >= 5.0 - 1e-6


@given(st.integers(0, 10**6), st.booleans())
def test_rings_are_the_distances_of_the_explicit_graph(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    nodes, links = embedding.to_csr()
    x, y, _, _ = random_node(embedding, np.random.default_rng(seed))
    goals = np.flatnonzero((nodes[:, :2] == [x, y]).all(axis=1))
    expected = shortest_path(links.T, unweighted=True, indices=goals).min(axis=0)
    layout = embedding.unrolling.layout
    found = np.full(len(nodes), -1)
    for distance, (ring, _) in enumerate(_rings(embedding, np.array([[x, y]]))):
        planes = [layout.unpack(plane) for plane in ring.planes]
        inside = np.array(planes)[nodes[:, 3] * embedding.shape[2] + nodes[:, 2], nodes[:, 0], nodes[:, 1]]
        assert np.all(found[inside] == -1)
        found[inside] = distance
    assert np.array_equal(found, expected)


@given(st.integers(0, 10**6), st.booleans())
def test_prices_are_those_of_the_links_one_by_one(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    rng, weights = np.random.default_rng(seed), PriceSettings(cost=7.0, idle=2.0, back=11.0, free_turn=0.3, again=3.0)
    prices, reader = LinkPrices(embedding, weights), LinkReader(embedding)
    for _ in range(4):
        node = random_node(embedding, rng)
        stencils = reader.stencils_from(node)
        assert stencils.tolist() == [k for k, _ in explicit_links(embedding, node)]
        expected = [explicit_price(embedding, node[3], k, weights) for k in stencils.tolist()]
        # What lies exactly between two numbers is rounded this way or that.
        assert np.abs(prices.of(np.full(len(stencils), node[3]), stencils) - expected).max() <= 1


def test_spikes_of_the_clips_themselves_have_a_price():
    """Counted one frame after the other: spikes that lie within two frames of each other are one."""
    graph = sample_graph()
    embedding = embed(graph, build_environment(Grid.over_rectangle((0, 0), (4, 5), 0.25, 12), []))
    with_them, without = (LinkPrices(embedding, PriceSettings(rough=rough)).of_segment for rough in (3.0, 0.0))
    rough, expected = graph_roughness(graph), []
    for segment in graph.segments:
        count = 0
        for of_clips in (rough.knees, rough.joints):
            last = -99
            for frame, values in enumerate(of_clips[segment.clip][segment.first : segment.last - 1]):
                if values.max() > 1:
                    count += frame - last > 2
                    last = frame
        expected.append(3000 * count)
    assert np.abs(with_them - without - expected).max() <= 1 and max(expected) > 0


@given(st.integers(0, 10**6), st.booleans(), st.integers(0, 2), st.integers(0, 2))
@settings(max_examples=25, deadline=None)
def test_the_cheapest_way_is_that_of_the_explicit_links(seed, tiled, more, look_ahead):
    """All ways of the fewest segments and some more, and what follows, by dynamic programming over single links."""
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    rng, reader, prices = np.random.default_rng(seed), LinkReader(embedding), LinkPrices(embedding)
    start, goal = reader.wrapped(np.array([random_node(embedding, rng), random_node(embedding, rng)]))
    rings = []
    for ring, before in _rings(embedding, goal[None, :2]):
        rings.append(ring)
        if _holds(embedding, before, tuple(start.tolist())):
            break
    assume(len(rings) + more <= 6)
    guide, most = _RingGuide(embedding, rings, prices), len(rings) + more
    row, way, price = finish(
        cheapest_way_steps(reader, prices, guide, start[None], most, look_ahead=look_ahead, beam=10**9)
    )
    links = cache(lambda node: explicit_links(embedding, node))

    def of_link(node, stencil):
        return int(prices.of(np.array([node[3]]), np.array([stencil]))[0])

    first = tuple(start.tolist())
    expected = explicit_least_price(of_link, links, first, lambda end: end[:2] == tuple(goal[:2]), most, look_ahead)
    assert row == 0 and price == expected
    trail, total = Trail(reader, first), 0
    for number, stencil in enumerate(way):
        total += of_link(trail.node, stencil)
        trail.take(stencil)
        there = np.array_equal(reader.wrapped(np.array([trail.node]))[0, :2], goal[:2])
        assert there or number != len(way) - look_ahead - 1
    assert total == price
    assert_links(trail.walk())


def test_a_beam_of_few_is_no_dead_end_and_hardly_dearer():
    """However few ways are followed, one arrives within as many segments; 200 are as good as all, or nearly."""
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (4, 5), 0.25, 12), []))
    rng, reader, prices = np.random.default_rng(1), LinkReader(embedding), LinkPrices(embedding)
    dearer = []
    for _ in range(8):
        start, goal = random_node(embedding, rng), random_node(embedding, rng)
        rings = []
        for ring, before in _rings(embedding, np.array([goal[:2]])):
            rings.append(ring)
            if _holds(embedding, before, start):
                break
        guide = _RingGuide(embedding, rings, prices)
        found = [
            finish(cheapest_way_steps(reader, prices, guide, np.array([start]), len(rings) + 2, beam=beam))
            for beam in (1, 200, 10**9)
        ]
        assert all(len(way) <= len(rings) + 2 for _, way, _ in found)
        few, many, exact = (price for _, _, price in found)
        assert exact <= many and exact <= few
        dearer.append((many / exact, few / exact))
    assert np.mean(dearer, axis=0)[0] < 1.02 < np.mean(dearer, axis=0)[1]


def test_a_wanderer_sees_more_of_the_floor_than_chance():
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (7, 8), 0.125, 24), []))

    def square_metres(walk_steps) -> float:
        """Of squares of half a metre that a minute's walk touches, on average."""
        walks = [finish(walk_steps(embedding, np.random.default_rng(i), WalkSettings(60.0))) for i in range(6)]
        paths = [walk.root_path[:, :2] for walk in walks]
        return float(np.mean([0.25 * len(np.unique((path / 0.5).astype(int), axis=0)) for path in paths]))

    assert square_metres(wandering_walk_steps) > 1.8 * square_metres(random_walk_steps)


def test_impossible_walks_say_why():
    embedding = embed(*random_problem(1, True), SETTINGS)
    rng = np.random.default_rng(0)
    with pytest.raises(WalkError, match="positive duration"):
        finish(wandering_walk_steps(embedding, rng, WalkSettings(-1.0)))
    outside = tuple(np.argwhere(~embedding.node_mask())[0].tolist())
    with pytest.raises(WalkError, match="no node of the embedding"):
        finish(wandering_walk_steps(embedding, rng, WalkSettings(5.0, start=outside)))
