"""Chance among what is nearly the cheapest: exact weights where nothing is left out, walks that do not stand."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.link_reader import LinkReader
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.playback import near_cheapest
from core.playback.near_cheapest import NearCheapest
from core.playback.pace import idle_frames
from core.playback.prices import LinkPrices
from core.playback.styles import WalkRequest, walk_steps
from core.playback.walk import WalkSettings, random_node, random_walk_steps
from core.playback.weighted import Memory, PerClip, probabilities
from core.progress import finish

from .explicit_walks import assert_links
from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.booleans())
def test_links_are_weighed_by_the_cheapest_way_that_begins_with_them(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(0 < embedding.n_nodes < 200)
    reader, prices = LinkReader(embedding), LinkPrices(embedding)
    # So few nodes that none is left out: many more links are followed than those of the beam.
    assume(embedding.n_links < near_cheapest.BEAM)
    durations = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
    known = {}

    def links(node):
        stencils = reader.stencils_from(node)
        ends = reader.wrapped(reader.ends(np.array(node), stencils))
        price = prices.of(np.full(len(stencils), node[3]), stencils) - prices.usual * durations[ends[:, 3]]
        return price, [tuple(end) for end in ends.tolist()]

    def least(node, n):
        if n and (node, n) not in known:
            price, ends = links(node)
            known[node, n] = min(p + least(end, n - 1) for p, end in zip(price, ends, strict=True))
        return known.get((node, n), 0.0)

    node = random_node(embedding, np.random.default_rng(seed))
    price, ends = links(node)
    ways = np.array([p + least(end, near_cheapest.LOOK_AHEAD) for p, end in zip(price, ends, strict=True)])
    expected = np.exp(-np.minimum((ways - ways.min()) / near_cheapest.TOLERANCE, 500))
    assert NearCheapest(embedding)(Memory(reader).crossing(node)) == pytest.approx(expected)
    expected = np.exp(-np.minimum((price - price.min()) / near_cheapest.TOLERANCE, 500))
    assert NearCheapest(embedding).hasty()(Memory(reader).crossing(node)) == pytest.approx(expected)


@pytest.fixture(scope="module")
def room():
    return embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (6, 6), 0.15, 16), []))


def test_what_a_person_bans_stays_banned_however_cheap(room):
    names = [clip.name for clip in room.graph.clips]
    banned = {name: 0.0 for name in names if "walk" in name}
    reader, rng, seen = LinkReader(room), np.random.default_rng(4), 0
    for _ in range(40):
        crossing = Memory(reader).crossing(random_node(room, rng))
        walks = np.array([names[room.graph.segments[s].clip] in banned for s in crossing.ends[:, 3]])
        likely = probabilities(NearCheapest(room, PerClip(banned)), crossing)
        if 0 < walks.sum() < len(walks):
            seen += 1
            assert not likely[walks].any()
            assert likely[~walks].sum() == pytest.approx(1.0)
    assert seen > 5


def idle(walk):
    return idle_frames(walk.root_path, walk.embedding.graph.frame_rate).mean()


@pytest.mark.parametrize("style", ["RANDOM", "LOOP"])
def test_who_walks_by_chance_does_not_stand_about(room, style):
    walks = [finish(walk_steps(room, WalkRequest(style, seed, 30.0))) for seed in range(4)]
    for walk in walks:
        assert_links(walk)
    assert np.mean([idle(walk) for walk in walks]) < 0.2
    every = [finish(random_walk_steps(room, np.random.default_rng(seed), WalkSettings(30.0))) for seed in range(4)]
    assert np.mean([idle(walk) for walk in every]) > 0.4
    assert not np.array_equal(walks[0].states, walks[1].states)
    again = finish(walk_steps(room, WalkRequest(style, 0, 30.0)))
    assert np.array_equal(walks[0].states, again.states)
