"""Actions at places: played whole, near the place, as soon as can be."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.link_reader import LinkReader
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.evaluation.segment_groups import segments_of_clip, segments_with_tag
from core.playback.performance import continued, perform_steps
from core.playback.walk import Walk, WalkSettings, random_node, random_walk_steps
from core.progress import finish

from .explicit_walks import assert_links
from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


@given(st.integers(0, 10**6), st.booleans())
def test_one_segment_is_played_as_soon_as_it_can_be(seed, tiled):
    """Beside all links that play the segment near the place, one by one, and Dijkstra."""
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(0 < embedding.n_nodes < 1500)
    rng = np.random.default_rng(seed)
    grid, segment = embedding.environment.grid, int(rng.integers(embedding.shape[3]))
    nodes, links = embedding.to_csr()
    start = int(rng.integers(len(nodes)))
    place = grid.positions(nodes[rng.integers(len(nodes)), :2])
    radius = 1.2 * grid.cell_size
    reader = LinkReader(embedding)
    apart = dijkstra(links, indices=start)
    row, stencil = reader.links_from(nodes)
    soonest = np.inf
    for r, k in zip(row.tolist(), stencil.tolist(), strict=True):
        end = reader.follow(tuple(nodes[r].tolist()), k)
        if end[3] == segment:
            path = Walk(embedding, np.array([nodes[r], end]), np.array([k])).root_path
            away = path[embedding.graph.segments[segment].n_frames // 2, :2] - place
            if tiled:
                away -= grid.size * np.rint(away / grid.size)
            if np.hypot(*away) <= radius:
                soonest = min(soonest, apart[r])
    if not np.isfinite(soonest):
        with pytest.raises(WalkError, match="cannot be played within"):
            finish(perform_steps(embedding, tuple(nodes[start].tolist()), [segment], place, radius))
        return
    found = finish(perform_steps(embedding, tuple(nodes[start].tolist()), [segment], place, radius))
    assert_links(found.walk)
    assert len(found.walk) == found.first + 1
    assert found.walk.segments[-1] == segment
    assert found.walk.node_frames[found.first] / 30 == pytest.approx(soonest)
    away = found.place - place
    if tiled:
        away -= grid.size * np.rint(away / grid.size)
    assert np.hypot(*away) <= radius + 1e-9


@pytest.fixture(scope="module")
def hall():
    return embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (7, 8), 0.15, 16), []))


def test_a_whole_action_at_a_place(hall):
    graph = hall.graph
    start = random_node(hall, np.random.default_rng(0))
    found = finish(perform_steps(hall, start, segments_of_clip(graph, "pivot_left_180"), (4, 5), 0.4))
    assert_links(found.walk)
    played = [graph.segments[s] for s in found.walk.segments[found.first :]]
    assert {graph.clips[s.clip].name for s in played} == {"pivot_left_180"}
    assert all(a.last == b.first for a, b in pairwise(played))
    assert np.hypot(*(found.place - [4, 5])) <= 0.4
    stepping = finish(perform_steps(hall, start, segments_with_tag(graph, "step"), (2, 3), 0.3, tag="step"))
    assert all("step" in graph.segments[s].tags for s in stepping.walk.segments[stepping.first :])
    assert np.hypot(*(stepping.place - [2, 3])) <= 0.3
    # And on.
    rest = finish(
        random_walk_steps(hall, np.random.default_rng(1), WalkSettings(5.0, tuple(found.walk.states[-1].tolist())))
    )
    whole = continued(found.walk, rest)
    assert_links(whole)
    assert whole.duration == pytest.approx(found.walk.duration + rest.duration)
    with pytest.raises(WalkError, match="does not start where"):
        continued(found.walk, Walk(hall, rest.states[1:], rest.stencils[1:]))


def test_impossible_performances_say_why(hall):
    start = random_node(hall, np.random.default_rng(0))
    with pytest.raises(WalkError, match="cannot be played within"):
        finish(perform_steps(hall, start, [0], (40, 40), 0.3))
    with pytest.raises(WalkError, match="no segment"):
        finish(perform_steps(hall, start, [], (4, 4), 0.3))
    with pytest.raises(WalkError, match="not a number"):
        finish(perform_steps(hall, start, [0], (np.nan, 4), 0.3))
    with pytest.raises(WalkError, match=r"within 0\.1 s"):
        finish(perform_steps(hall, start, segments_of_clip(hall.graph, "pivot_left_180"), (4, 5), 0.4, limit=0.1))
