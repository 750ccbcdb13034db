"""Reasons for what is outside the embedding, against the explicit links."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.embedding.archive import embedding_from_bytes, embedding_to_bytes
from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.environment.environment import Environment
from core.environment.regions import RegionRule
from core.evaluation.why_not import Reason, lost_links_steps, why_not_steps
from core.progress import finish

from .reference import explicit_embedding, point_free, random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def followed(links, start):
    """All nodes that links (a, b) lead to from the set ``start``, which is part of the answer."""
    found, edge = set(start), set(start)
    while edge:
        edge = {b for a, b in links if a in edge} - found
        found |= edge
    return found


def rule_only(embedding, x, y):
    """Whether a region requires a tag at the middle of a cell in which no walk stands, in any heading."""
    required = [
        r for r in embedding.environment.regions if r.rule is RegionRule.REQUIRE and r.mask[4 * x + 2, 4 * y + 2]
    ]
    return bool(required) and not embedding.node_mask()[x, y].any()


def slow_reasons(embedding, slow):
    nodes, links = set(slow.nodes.tolist()), set(map(tuple, slow.all_links.tolist()))
    reached = followed(links, nodes)
    leading = followed({(b, a) for a, b in links}, nodes)
    apart = {b for _, b in links} - reached - leading
    while True:
        inside = {(a, b) for a, b in links if a in apart and b in apart}
        kept = {a for a, _ in inside} & {b for _, b in inside}
        if kept == apart:
            break
        apart = kept
    grid, environment = embedding.environment.grid, embedding.environment
    classes = {
        frozenset(t for t in environment.tags if t in segment.tags and segment.tags[t][frame])
        for segment in embedding.graph.segments
        for frame in range(segment.n_frames)
    }
    bare = Environment(grid, environment.blocked)
    reasons = np.empty(grid.shape, dtype=int)
    for x, y, heading in np.ndindex(grid.shape):
        first = np.ravel_multi_index((x, y, heading, 0), slow.shape)
        here = set(range(first, first + slow.shape[3]))
        centre = (4 * x + 2, 4 * y + 2)
        if here & nodes:
            reason = Reason.EMBEDDED
        elif not point_free(bare, frozenset(), centre):
            reason = Reason.BLOCKED
        elif rule_only(embedding, x, y):
            reason = Reason.RULE
        elif not any(point_free(environment, tags, centre) for tags in classes):
            reason = Reason.FORBIDDEN
        elif here & reached:
            reason = Reason.NO_MATCH if here & leading else Reason.NO_WAY_OUT
        elif here & leading:
            reason = Reason.NO_WAY_IN
        else:
            reason = Reason.OTHER_COMPONENT if here & apart else Reason.UNREACHABLE
        reasons[x, y, heading] = reason
    return reasons


@given(st.integers(0, 10**6), st.booleans())
def test_reasons_equal_those_of_the_explicit_links(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    slow = explicit_embedding(embedding.graph, embedding.environment, SETTINGS)
    assert np.array_equal(finish(why_not_steps(embedding)), slow_reasons(embedding, slow))


def test_every_reason_occurs_in_the_random_problems():
    """Guards the test above: no reason goes untested."""
    found = set()
    for seed in range(400):
        found |= set(np.unique(finish(why_not_steps(embed(*random_problem(seed, seed % 2 == 0), SETTINGS)))).tolist())
        if found == set(Reason) - {Reason.NO_GROUND}:
            return
    pytest.fail(f"never seen: {set(Reason) - found}")


@given(st.integers(0, 10**6), st.booleans())
def test_where_there_is_no_ground_it_is_no_obstacle_that_is_too_near(seed, tiled):
    graph, environment = random_problem(seed, tiled)
    off_ground = environment.blocked & (np.random.default_rng(seed).random(environment.blocked.shape) < 0.5)
    outlined = embed(graph, replace(environment, off_ground=off_ground), SETTINGS)
    expected = finish(why_not_steps(embed(graph, environment, SETTINGS)))
    expected[off_ground[2::4, 2::4]] = Reason.NO_GROUND
    assert np.array_equal(finish(why_not_steps(outlined)), expected)
    lost = finish(lost_links_steps(outlined))
    assert lost.possible == lost.obstacles + lost.regions + lost.free and lost.embedded <= lost.free
    again = embedding_from_bytes(embedding_to_bytes(outlined))
    assert np.array_equal(again.environment.off_ground, off_ground)


@given(st.integers(0, 10**6), st.booleans())
def test_lost_links_add_up(seed, tiled):
    graph, environment = random_problem(seed, tiled)
    embedding = embed(graph, environment, SETTINGS)
    lost = finish(lost_links_steps(embedding))
    bare = Environment(environment.grid, np.zeros_like(environment.blocked))
    unruled = Environment(environment.grid, environment.blocked)
    possible, unblocked, free = (
        len(explicit_embedding(graph, e, SETTINGS).all_links) for e in (bare, unruled, environment)
    )
    assert (lost.possible, lost.obstacles, lost.regions, lost.free) == (
        possible,
        possible - unblocked,
        unblocked - free,
        free,
    )
    assert lost.embedded == embedding.n_links
    # As progress it goes from 0 to 1, never back.
    fractions = []
    assert finish(lost_links_steps(embedding), lambda progress: fractions.append(progress.fraction)) == lost
    assert fractions == sorted(fractions) and fractions[0] >= 0 and fractions[-1] <= 1
