"""Weightings: what they say of every link, and that walkers do as they say."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.link_reader import LinkReader
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.playback.walk import WalkSettings, draw, random_node, random_walk_steps
from core.playback.weighted import ByGoodness, Evenly, Memory, PerClip, by_variability, uniform
from core.progress import finish

from .explicit_walks import assert_links
from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


@given(st.integers(0, 10**6), st.booleans())
def test_the_reader_knows_all_links_both_ways(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    reader = LinkReader(embedding)
    nodes = np.argwhere(embedding.node_mask())
    degree_in, degree_out = embedding.in_degree()[tuple(nodes.T)], embedding.out_degree()[tuple(nodes.T)]
    row, stencil = reader.links_from(nodes)
    assert np.array_equal(np.bincount(row, minlength=len(nodes)), degree_out)
    to_row, to_stencil, parent = reader.links_to(nodes)
    assert np.array_equal(np.bincount(to_row, minlength=len(nodes)), degree_in)
    # The same links from both sides.
    ends = reader.wrapped(reader.ends(nodes[row], stencil))
    one_way = {(*nodes[r], *end, k) for r, end, k in zip(row, map(tuple, ends), stencil, strict=True)}
    other_way = set()
    steps = embedding.unrolling.stencils
    for r, k, c in zip(to_row, to_stencil, parent, strict=True):
        x, y = (nodes[r, :2] - [steps.dx[k], steps.dy[k]]) % embedding.shape[:2]
        other_way.add((x, y, steps.heading[k], c, *nodes[r], k))
    assert one_way == other_way
    assert np.array_equal(
        reader.variability(nodes), (embedding.in_degree().astype(np.int64) * embedding.out_degree())[tuple(nodes.T)]
    )
    everywhere = np.argwhere(np.ones(embedding.shape, dtype=bool))
    assert np.array_equal(reader.are_nodes(everywhere), embedding.node_mask().ravel())
    assert reader.are_nodes(everywhere + [embedding.shape[0], 0, 0, 0]).any() == tiled


@pytest.fixture(scope="module")
def room():
    return embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (6, 6), 0.15, 16), []))


@pytest.fixture
def crossing(room):
    memory = Memory(LinkReader(room))
    rng = np.random.default_rng(3)
    while len((crossing := memory.crossing(random_node(room, rng))).stencils) < 20:
        pass
    return crossing


def test_goodness_is_that_of_the_transition(room, crossing):
    weights = ByGoodness(0.05)(crossing)
    costs = {tuple(link): cost for link, cost in zip(room.graph.links.tolist(), room.graph.link_costs, strict=True)}
    for weight, end in zip(weights, crossing.ends, strict=True):
        assert weight == pytest.approx(np.exp(-costs[crossing.node[3], int(end[3])] / 0.05))
    assert np.ptp(weights) > 0


def test_clips_share_their_weight(room, crossing):
    graph = room.graph
    names = np.array([graph.clips[graph.segments[s].clip].name for s in crossing.ends[:, 3]])
    first = names[0]
    weights = PerClip({first: 7.0})(crossing)
    for name in set(names.tolist()):
        assert weights[names == name].sum() == pytest.approx(7.0 if name == first else 1.0)
    with pytest.raises(WalkError, match="no clip 'no such'"):
        PerClip({"no such": 1.0})(crossing)
    with pytest.raises(WalkError, match="zero or more"):
        PerClip({first: -1.0})


def test_links_are_drawn_as_often_as_weighed(crossing):
    rng = np.random.default_rng(0)
    weights = by_variability(crossing)
    drawn = np.array([draw(rng, lambda _: weights, crossing) for _ in range(20000)])
    often = np.array([np.count_nonzero(drawn == k) for k in crossing.stencils])
    expected = 20000 * weights / weights.sum()
    assert ((often - expected) ** 2 / expected).sum() < 2 * len(expected), "chi squared"


def test_nothing_is_played_that_weighs_nothing_unless_it_must(room):
    names = [clip.name for clip in room.graph.clips]
    banned = {name: 0.0 for name in names if "pivot" in name or "stand" in name}
    walk = finish(random_walk_steps(room, np.random.default_rng(1), WalkSettings(60.0, weighting=PerClip(banned))))
    assert_links(walk)
    reader = LinkReader(room)
    for node, segment in zip(walk.states.tolist(), walk.segments.tolist(), strict=False):
        if names[room.graph.segments[segment].clip] in banned:
            ends = reader.ends(np.array(node), reader.stencils_from(tuple(node)))
            assert all(names[room.graph.segments[s].clip] in banned for s in ends[:, 3])


def test_smooth_walkers_walk_more_smoothly(room):
    costs = {tuple(link): cost for link, cost in zip(room.graph.links.tolist(), room.graph.link_costs, strict=True)}

    def mean_cost(weighting):
        walk = finish(random_walk_steps(room, np.random.default_rng(1), WalkSettings(200.0, weighting=weighting)))
        states = walk.states[:, 3].tolist()
        return np.mean([costs[a, b] for a, b in pairwise(states)])

    assert mean_cost(ByGoodness(0.02)) < 0.4 * mean_cost(uniform)


def test_even_walkers_see_more_of_the_floor(room):
    def squares(weighting):
        limits = WalkSettings(90.0, weighting=weighting)
        seen = [finish(random_walk_steps(room, np.random.default_rng(i), limits)).root_path for i in range(4)]
        return np.mean([len(np.unique((path[:, :2] / 0.5).astype(int), axis=0)) for path in seen])

    assert squares(Evenly()) > 1.15 * squares(uniform)


def test_weights_that_are_none_are_refused(room):
    for bad in (lambda c: np.full(len(c.stencils), -1.0), lambda _: np.ones(3), lambda c: c.stencils * np.nan):
        with pytest.raises(WalkError, match="zero or more"):
            finish(random_walk_steps(room, np.random.default_rng(0), WalkSettings(5.0, weighting=bad)))
    with pytest.raises(WalkError, match="positive cost"):
        ByGoodness(0.0)
