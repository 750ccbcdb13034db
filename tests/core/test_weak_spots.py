"""Weak spots against a flood fill cell by cell."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintSettings
from core.environment.environment import Environment, EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.errors import EmbeddingError
from core.evaluation.variability import floor_variability, variability
from core.evaluation.weak_spots import (
    Domain,
    Weakness,
    WeakSpotSettings,
    connected_areas,
    weak_spots_steps,
)
from core.evaluation.why_not import Reason, why_not_steps
from core.progress import finish

from .geometry import box_triangles
from .motion_graphs import recorded_graph, sample_graph
from .reference import random_problem, slow_floor

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def slow_areas(mask, tiled, diagonal):
    """Brushfire: the sets of cells that are connected, one cell after the other."""
    wraps = [tiled, tiled, True]
    steps = [np.array(step) - 1 for step in np.ndindex((3,) * mask.ndim)]
    steps = [step for step in steps if step.any() and (diagonal or np.abs(step).sum() == 1)]
    left = {tuple(cell) for cell in np.argwhere(mask).tolist()}
    areas = []
    while left:
        edge = [min(left)]
        left.remove(edge[0])
        area = set(edge)
        while edge:
            cell = edge.pop()
            for step in steps:
                near = [int(c + s) for c, s in zip(cell, step, strict=True)]
                near = tuple(c % n if wrap else c for c, n, wrap in zip(near, mask.shape, wraps, strict=False))
                if near in left:
                    left.remove(near)
                    area.add(near)
                    edge.append(near)
        areas.append(frozenset(area))
    return set(areas)


@given(st.integers(0, 10**6), st.integers(2, 3), st.booleans(), st.booleans(), st.sampled_from([0.2, 0.4, 0.6, 0.9]))
def test_connected_areas_equal_a_brushfire(seed, n_axes, tiled, diagonal, density):
    rng = np.random.default_rng(seed)
    mask = rng.random(rng.integers(1, 7, n_axes)) < density
    areas = connected_areas(mask, tiled, diagonal)
    assert {frozenset(map(tuple, area.T.tolist())) for area in areas} == slow_areas(mask, tiled, diagonal)
    assert sum(area.shape[1] for area in areas) == mask.sum()


@given(
    st.integers(0, 10**6),
    st.booleans(),
    st.sampled_from(Domain),
    st.booleans(),
    st.sampled_from([0, 5, 40]),
    st.sampled_from([0.0, 0.2]),
)
def test_equals_the_brushfire_over_the_maps(seed, tiled, domain, diagonal, threshold, min_area):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    grid = embedding.environment.grid
    found = finish(weak_spots_steps(embedding, WeakSpotSettings(domain, threshold, min_area, diagonal)))
    values = floor_variability(embedding) if domain is Domain.FLOOR else variability(embedding)
    free = slow_floor(embedding.graph, embedding.environment, np.zeros(embedding.shape[:2], dtype=bool))
    free = free if domain is Domain.FLOOR else np.broadcast_to(free[:, :, None], values.shape)
    reasons = finish(why_not_steps(embedding))
    element = grid.cell_size**2 / (1 if domain is Domain.FLOOR else grid.n_headings)
    expected = {}
    for weakness, mask in (
        (Weakness.UNREACHED, free & (values == 0)),
        (Weakness.FEW_WAYS, free & (values > 0) & (values < threshold)),
    ):
        for area in slow_areas(mask, tiled, diagonal):
            if len(area) * element >= min_area - 1e-9:
                expected[area] = weakness
    areas = [frozenset(map(tuple, np.argwhere(found.labels == i).tolist())) for i in range(1, len(found.spots) + 1)]
    assert dict(zip(areas, (spot.weakness for spot in found.spots), strict=True)) == expected
    assert [len(area) for area in areas] == sorted((len(area) for area in areas), reverse=True)
    for area, spot in zip(areas, found.spots, strict=True):
        assert spot.n_elements == len(area)
        assert spot.area == pytest.approx(len(area) * element)
        there = [int(values[cell]) for cell in area]
        assert (spot.mean_variability, spot.lowest_variability) == (pytest.approx(np.mean(there)), min(there))
        cell = tuple(grid.cells(np.array(spot.position)).tolist())
        assert cell in {place[:2] for place in area}
        if domain is Domain.HEADINGS:
            assert (*cell, round(spot.heading / grid.heading_step)) in area
        n = np.round((np.array(spot.high) - spot.low) / grid.cell_size).astype(int)
        first = grid.cells(np.array(spot.low) + grid.cell_size / 2)
        box = {
            ((first[0] + i) % grid.shape[0], (first[1] + j) % grid.shape[1]) for i in range(n[0]) for j in range(n[1])
        }
        assert {place[:2] for place in area} <= box
        # Each side of the box touches the area.
        for axis in (0, 1):
            used = {place[axis] for place in area}
            assert first[axis] % grid.shape[axis] in used and (first[axis] + n[axis] - 1) % grid.shape[axis] in used
        codes = np.concatenate([np.ravel(reasons[cell]) for cell in area])
        tally = {reason: np.mean(codes == reason) for reason in Reason}
        outside = {reason: share for reason, share in tally.items() if reason is not Reason.EMBEDDED}
        top = max(outside.values())
        if top > 0:
            assert spot.reason is not Reason.EMBEDDED and tally[spot.reason] == pytest.approx(top)
        else:
            assert spot.reason is Reason.EMBEDDED
        assert spot.reason_share == pytest.approx(tally[spot.reason])


def test_random_problems_have_both_kinds_of_spots():
    """Guards the test above."""
    kinds = set()
    for seed in range(60):
        embedding = embed(*random_problem(seed, seed % 2 == 0), SETTINGS)
        found = finish(weak_spots_steps(embedding, WeakSpotSettings(threshold=40, min_area=0)))
        kinds |= {spot.weakness for spot in found.spots}
    assert kinds == set(Weakness)


def closed_off():
    """A room with a chamber of 1.0 x 0.8 m that no door leads to."""
    grid = Grid.over_rectangle((-2, -2), (2, 2), 0.1, 16)
    walls = [
        ((-1, -1, 0), (0, -0.9, 2)),
        ((-1, -0.1, 0), (0, 0, 2)),
        ((-1, -1, 0), (-0.9, 0, 2)),
        ((-0.1, -1, 0), (0, 0, 2)),
    ]
    obstacles = np.concatenate([box_triangles(*wall) for wall in walls])
    return build_environment(grid, obstacles, settings=EnvironmentSettings(radius=0.0))


def test_a_closed_chamber_is_found_with_size_place_and_words():
    embedding = embed(sample_graph(), closed_off())
    assert embedding.n_nodes
    spots = finish(weak_spots_steps(embedding, WeakSpotSettings(min_area=0.5))).spots
    assert len(spots) == 1
    spot = spots[0]
    assert spot.weakness is Weakness.UNREACHED
    assert 0.5 <= spot.area <= 0.65
    assert spot.position == pytest.approx((-0.5, -0.5), abs=0.11)
    assert spot.low == pytest.approx((-0.9, -0.9), abs=0.11) and spot.high == pytest.approx((-0.1, -0.1), abs=0.11)
    assert (spot.mean_variability, spot.lowest_variability, spot.heading) == (0, 0, None)
    assert "m² around (-0." in spot.describe() and "cannot be reached" in spot.describe()
    assert finish(weak_spots_steps(embedding, WeakSpotSettings(min_area=2))).describe() == "There are no weak spots."


def unreached(grid, blocked):
    """An embedding without nodes."""
    embedding = embed(sample_graph(), Environment(grid, blocked))
    return finish(restrict_steps(embedding, embedding.network.empty))


def test_an_area_across_the_seam_of_a_tile_is_one():
    grid = Grid((10, 8, 4), 0.125, (0.0, 0.0), tiled=True)
    blocked = np.ones((40, 32), dtype=bool)
    blocked[:8, 8:16] = blocked[32:, 8:16] = False
    for domain in Domain:
        (spot,) = finish(weak_spots_steps(unreached(grid, blocked), WeakSpotSettings(domain))).spots
        assert (spot.floor_area, spot.heading_share) == (pytest.approx(0.125), 1.0)
        assert (spot.low, spot.high) == ((1.0, 0.25), (1.5, 0.5))
        assert spot.position[0] in (0.0625, 1.1875)
    apart = unreached(replace(grid, tiled=False), blocked)
    (left, right) = finish(weak_spots_steps(apart, WeakSpotSettings(min_area=0.0625))).spots
    assert (left.low, right.low) == ((0.0, 0.25), (1.0, 0.25))


def test_recorded_motion_in_a_room_with_a_nook(data_folder):
    grid = Grid.over_rectangle((0, 0), (4, 3.5), 0.125, 24)
    nook = np.concatenate([box_triangles((3.0, 1.2, 0), (4.0, 1.3, 2)), box_triangles((3.0, 1.9, 0), (4.0, 2.0, 2))])
    embedding = embed(recorded_graph(data_folder), build_environment(grid, nook))
    found = finish(weak_spots_steps(embedding, WeakSpotSettings(threshold=100, min_area=0)))
    assert embedding.n_nodes and found.spots
    ways, free = floor_variability(embedding), embedding.environment.free_cells()
    assert np.array_equal(found.labels > 0, free & (ways < 100))
    assert found.area == pytest.approx(np.count_nonzero(found.labels) * 0.125**2)


def test_bad_settings():
    with pytest.raises(EmbeddingError, match="threshold of 0 or more"):
        WeakSpotSettings(threshold=-1)
    with pytest.raises(EmbeddingError, match="area of 0 or more"):
        WeakSpotSettings(min_area=float("nan"))
