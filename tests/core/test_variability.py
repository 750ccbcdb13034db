"""Variability and coverage on bit-planes, against the degrees of explicit links."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.network import StepNetwork
from core.environment.environment import Environment, EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.evaluation.bit_counter import BitCounter, constant, less, masked, minus, product, sum_of_products
from core.evaluation.variability import (
    coverage_share,
    floor_variability,
    heading_variability,
    integrated_variability_steps,
    segment_variability_of,
    variability,
    variability_steps,
)
from core.progress import finish

from .geometry import box_triangles
from .motion_graphs import recorded_graph, sample_graph
from .reference import explicit_embedding, random_problem, slow_floor

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def unpacked(embedding):
    """The same embedding, worked on heading by heading as on large grounds."""
    links, n_segments = embedding.graph.links, len(embedding.graph.segments)
    return replace(embedding, known_network=StepNetwork(embedding.unrolling, links, n_segments, packed_bytes=0))


def assert_equals(embedding, ways):
    """Every quantity of an embedding against its (nx, ny, n_headings, n_segments) segment variability."""
    for segment in range(ways.shape[3]):
        assert np.array_equal(segment_variability_of(embedding, segment), ways[..., segment])
    assert np.array_equal(variability(embedding), ways.sum(axis=3))
    for heading in range(ways.shape[2]):
        assert np.array_equal(heading_variability(embedding, heading), ways[:, :, heading].sum(axis=2))
    assert np.array_equal(floor_variability(embedding), ways.sum(axis=(2, 3)))
    assert np.array_equal(finish(integrated_variability_steps(embedding)), ways.sum(axis=(0, 1, 2)))
    assert np.array_equal(embedding.covered(), ways.sum(axis=3) > 0)


@given(st.integers(0, 10**6), st.booleans())
def test_equals_degrees_of_the_explicit_links(seed, tiled):
    graph, environment = random_problem(seed, tiled)
    embedding, slow = embed(graph, environment, SETTINGS), explicit_embedding(graph, environment, SETTINGS)
    ways = slow.in_degree().astype(np.int64) * slow.out_degree()
    assert_equals(embedding, ways)
    assert_equals(unpacked(embedding), ways)
    covered = ways.any(axis=(2, 3))
    free = slow_floor(graph, environment, covered)
    assert coverage_share(embedding) == pytest.approx(covered.sum() / max(free.sum(), 1))


def csr_ways(embedding):
    """Segment variability from the embedding's own explicit links."""
    nodes, links = embedding.to_csr()
    ways = np.zeros(embedding.shape, dtype=np.int64)
    ways[tuple(nodes.T)] = np.bincount(links.indices, minlength=len(nodes)) * np.diff(links.indptr)
    return ways


def test_sample_motion_between_pillars():
    grid = Grid.over_rectangle((0, 0), (4, 4), 0.2, 16)
    pillars = np.concatenate([box_triangles((1, 1, 0), (1.4, 1.3, 2)), box_triangles((2.6, 2.2, 0), (3, 2.9, 2))])
    embedding = embed(sample_graph(), build_environment(grid, pillars, settings=EnvironmentSettings(radius=0.25)))
    assert embedding.n_links > 10_000
    assert_equals(embedding, csr_ways(embedding))


def test_recorded_motion_on_a_corner_of_a_room(data_folder):
    grid = Grid.over_rectangle((0, 0), (4, 3.5), 0.125, 24)
    environment = build_environment(grid, box_triangles((1.5, 1, 0), (2.2, 1.4, 2)))
    embedding = embed(recorded_graph(data_folder), environment)
    assert embedding.n_links > 10_000
    ways = csr_ways(embedding)
    assert np.array_equal(variability(embedding), ways.sum(axis=3))
    assert np.array_equal(finish(integrated_variability_steps(embedding)), ways.sum(axis=(0, 1, 2)))


@pytest.fixture(scope="module")
def nothing():
    """An embedding without nodes: everything is blocked."""
    grid = Grid((6, 5, 4), 0.2)
    return embed(sample_graph(), Environment(grid, np.ones((24, 20), dtype=bool)))


def test_empty_embedding(nothing):
    assert_equals(nothing, np.zeros(nothing.shape, dtype=np.int64))
    assert coverage_share(nothing) == 0.0


def test_unknown_segments_and_headings(nothing):
    for bad in (-1, nothing.shape[3]):
        with pytest.raises(IndexError, match=f"no segment {bad} "):
            segment_variability_of(nothing, bad)
    for bad in (-1, 4):
        with pytest.raises(IndexError, match=f"no heading {bad} "):
            heading_variability(nothing, bad)


def test_progress_runs_up_to_one_and_may_stop_at_any_step():
    embedding = embed(*random_problem(3, False), SETTINGS)
    fractions = []
    finish(variability_steps(embedding), lambda progress: fractions.append(progress.fraction))
    assert fractions == sorted(fractions) and fractions[0] == 0 and 0 < fractions[-1] < 1
    steps = variability_steps(embedding)
    next(steps)
    steps.close()


# Tallies -------------------------------------------------------------------------------------------------------------

N_CELLS = 20
counts = st.lists(st.integers(0, 40), min_size=N_CELLS, max_size=N_CELLS)


def tally_of(numbers):
    digits = [sum((number >> digit & 1) << cell for cell, number in enumerate(numbers)) for digit in range(6)]
    while digits and not digits[-1]:
        digits.pop()
    return digits


@given(counts, counts, st.integers(0, 2**N_CELLS - 1))
def test_tallies_calculate_cell_by_cell(a, b, plane):
    ta, tb = tally_of(a), tally_of(b)
    pairs = list(zip(a, b, strict=True))
    columns = BitCounter()
    columns.add_counts(ta)
    columns.add_counts(tb)
    columns.add(plane)
    total = [x + y + (plane >> cell & 1) for cell, (x, y) in enumerate(pairs)]
    assert numbers_of(columns.total()) == total
    assert columns.total() == []
    assert numbers_of(product(ta, tb)) == [x * y for x, y in pairs]
    assert sum_of_products(ta, tb) == sum(x * y for x, y in pairs)
    assert less(ta, tb) == sum((x < y) << cell for cell, (x, y) in enumerate(pairs))
    assert numbers_of(masked(ta, plane)) == [x * (plane >> cell & 1) for cell, x in enumerate(a)]
    larger, smaller = tally_of([max(pair) for pair in pairs]), tally_of([min(pair) for pair in pairs])
    assert numbers_of(minus(larger, smaller)) == [abs(x - y) for x, y in pairs]
    assert numbers_of(constant(a[0], plane)) == [a[0] * (plane >> cell & 1) for cell in range(N_CELLS)]


def numbers_of(tally):
    assert not tally or tally[-1] or all(not digit for digit in tally)
    return [sum((plane >> cell & 1) << digit for digit, plane in enumerate(tally)) for cell in range(N_CELLS)]
