"""Wandering: every step is a link, the way between two places is a shortest one, and the floor is visited evenly."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.sparse.csgraph import shortest_path

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.playback.walk import WalkSettings, random_node, random_walk_steps
from core.playback.wandering import _rings, wandering_walk_steps
from core.progress import finish

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
    for distance, ring in enumerate(_rings(embedding, np.array([x, y]))):
        planes = [layout.unpack(plane) for plane in ring.planes]
        inside = np.array(planes)[nodes[:, 3] * embedding.shape[2] + nodes[:, 2], nodes[:, 0], nodes[:, 1]]
        assert np.all(found[inside] == -1)
        found[inside] = distance
    assert np.array_equal(found, expected)


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
