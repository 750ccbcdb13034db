"""Loops end at the very node they start from; their links, and the one that closes them, are links of the embedding."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.playback.loop import loop_steps
from core.playback.walk import Walk, WalkSettings
from core.progress import finish

from .explicit_walks import assert_links
from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


@given(st.integers(0, 10**6), st.booleans())
def test_loops_close_exactly(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    duration = float(np.random.default_rng(seed).uniform(0.05, 2.0))
    walk = finish(loop_steps(embedding, np.random.default_rng(seed), WalkSettings(duration)))
    # Twice over: what closes the loop is its first link.
    shift = walk.states[-1] - walk.states[0]
    assert not shift[2:].any()
    assert not (shift[:2] % embedding.shape[:2] if tiled else shift[:2]).any()
    twice = np.concatenate([walk.states, walk.states[1:] + shift])
    assert_links(Walk(embedding, twice, np.tile(walk.stencils, 2)))
    assert walk.duration >= duration - 1e-6
    # Never longer than going out until the time is over and then home by the quickest way.
    nodes, links = embedding.to_csr()
    start = np.flatnonzero((nodes == walk.states[0]).all(axis=1))[0]
    home = dijkstra(links.T, indices=start)
    assert walk.duration <= duration + max(s.duration for s in embedding.graph.segments) + home.max() + 1e-6
    if duration < min(s.duration for s in embedding.graph.segments):
        # No loop can be shorter than the quickest.
        out = links[[start]]
        assert walk.duration >= (out.data + home[out.indices]).min() - 1e-6


def test_long_loops_last_to_the_frame():
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (6, 6), 0.2, 12), []))
    walks = [finish(loop_steps(embedding, np.random.default_rng(seed), WalkSettings(20.0))) for seed in (1, 1, 2)]
    assert all(walk.duration == pytest.approx(20.0) for walk in walks)
    assert np.array_equal(walks[0].states, walks[1].states)
    path = walks[0].root_path
    assert np.allclose(path[0, :2], path[-1, :2])
    with pytest.raises(WalkError, match="positive duration"):
        finish(loop_steps(embedding, np.random.default_rng(0), WalkSettings(0.0)))
