"""Occupancy against the eigenvector of explicit links, closed forms and simulated walks."""

from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import sparse

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings, edited_path
from core.environment.environment import Environment
from core.environment.grid import SUBDIVISION, Grid
from core.errors import EmbeddingError
from core.evaluation import markov_chain
from core.evaluation.occupancy import free_ground, occupancy_steps
from core.motion.graph import MotionGraph, MotionSegment
from core.playback.walk import WalkSettings, random_walk_steps
from core.progress import finish
from tests.bench import problems
from tests.bench.simulated_walkers import simulated_occupancy, visits

from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))

#: Random problems with more than a hundred nodes: seed and tiled.
PROBLEMS = [(7, True), (13, False), (4, True), (15, False)]


def slow_visits(embedding):
    """The stationary distribution from the transition matrix of explicit links, by a dense least-squares solution."""
    nodes, starts, ends = embedding.network.links_within(embedding.nodes)
    n = len(nodes)
    degree = np.bincount(starts, minlength=n)
    chances = sparse.csr_array((1 / degree[starts], (ends, starts)), shape=(n, n)).toarray()
    equations = np.vstack([chances - np.eye(n), np.ones((1, n))])
    solution = np.linalg.lstsq(equations, np.append(np.zeros(n), 1.0), rcond=None)[0]
    _, ny, n_headings, _ = embedding.shape
    shares = np.zeros(embedding.shape)
    segment, heading = np.divmod(nodes[:, 0], n_headings)
    x, y = np.divmod(nodes[:, 1], ny)
    shares[x, y, heading, segment] = solution
    return shares


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.booleans())
def test_visits_solve_the_equations_of_the_explicit_links(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(0 < embedding.n_nodes < 700)
    found = visits(embedding, 1e-9, 50_000)
    slow = slow_visits(embedding)
    assert np.abs(found - slow).sum() < 1e-5
    assert np.all(found[~embedding.node_mask()] == 0)
    result = finish(occupancy_steps(embedding, 1e-9, 50_000))
    frames = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
    time = slow.sum(axis=(0, 1, 2)) * frames
    assert result.segments == pytest.approx(time / time.sum(), abs=1e-5)
    assert result.floor.sum() == pytest.approx(1.0)


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.booleans())
def test_time_on_the_floor_is_that_of_every_link(seed, tiled):
    """Each stencil's frames laid out from each of its start cells, weighted by the explicit solution."""
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(0 < embedding.n_nodes < 200)
    grid, shares, out = embedding.environment.grid, slow_visits(embedding), embedding.out_degree()
    stencils, nx, ny = embedding.unrolling.stencils, *embedding.shape[:2]
    time = np.zeros((nx, ny))
    for k, able in enumerate(embedding.able_starts()):
        segment, heading = int(stencils.segment[k]), int(stencils.heading[k])
        path = edited_path(
            embedding.graph.segments[segment], heading, grid, stencils.position_error[k], stencils.heading_error[k]
        )
        half = np.floor((path[1:, :2] + path[:-1, :2]) / 2 / grid.cell_size + 0.5).astype(int)
        for x, y in embedding.unrolling.layout.cells(able):
            for parent in embedding.network.parents[segment]:
                if shares[x, y, heading, parent] > 0:
                    chance = shares[x, y, heading, parent] / out[x, y, heading, parent]
                    for dx, dy in half:
                        time[(x + dx) % nx, (y + dy) % ny] += chance
    found = finish(occupancy_steps(embedding, 1e-9, 50_000))
    assert np.abs(found.floor - free_ground(embedding.environment, time) / time.sum()).sum() < 1e-5
    free = embedding.environment.free_cells()
    assert not found.floor[~free].any() and found.visited_area <= free.sum() * grid.cell_size**2 + 1e-9


@given(st.integers(0, 10**6), st.booleans())
def test_time_beside_the_free_ground_counts_in_the_nearest_free_cell(seed, tiled):
    environment = random_problem(seed, tiled)[1]
    free, (nx, ny, _) = environment.free_cells(), environment.grid.shape
    assume(free.any())
    single = np.eye(nx * ny).reshape(-1, nx, ny)
    for place, moved in zip(np.ndindex(nx, ny), free_ground(environment, single), strict=True):
        (there,) = np.argwhere(moved)
        away = [np.abs(np.subtract(cell, place)) for cell in [there, *np.argwhere(free)]]
        away = [np.hypot(*(np.minimum(a, (nx, ny) - a) if tiled else a)) for a in away]
        assert moved[tuple(there)] == 1 and free[tuple(there)] and away[0] == pytest.approx(min(away[1:]))


def ring(n_cells, n_frames=2):
    """A walk of one cell around a torus of one row: a chain of period ``n_cells``."""
    path = np.column_stack([np.linspace(0, 0.2, n_frames), np.zeros((n_frames, 2))])
    step = MotionSegment("step", 0, 0, n_frames - 1, path, (n_frames - 1) / 30, {})
    graph = MotionGraph((), 30.0, (step,), np.array([[0, 0]]), np.zeros(1))
    grid = Grid((n_cells, 1, 1), 0.2, tiled=True)
    return embed(graph, Environment(grid, np.zeros((n_cells * SUBDIVISION, SUBDIVISION), dtype=bool)))


@pytest.mark.parametrize("n_cells", [2, 3, 7])
def test_chains_that_go_in_circles_settle(n_cells):
    found = finish(occupancy_steps(ring(n_cells), 1e-6))
    assert found.floor.ravel() == pytest.approx(np.full(n_cells, 1 / n_cells), abs=1e-5)
    assert found.residual <= 1e-6
    assert found.effective_area == pytest.approx(n_cells * 0.04)
    assert found.half_time_share == pytest.approx(0.5)
    assert found.density.sum() * 0.04 == pytest.approx(1.0)


def test_walkers_that_march_in_step_settle():
    """One of two alike, then b, then c, and again: at first half of the walkers are in the first third of the round."""
    names = ("a", "a again", "b", "c")
    stands = tuple(MotionSegment(name, 0, 0, 2, np.zeros((3, 3)), 2 / 30, {}) for name in names)
    links = np.array([[0, 2], [1, 2], [2, 3], [3, 0], [3, 1]])
    graph = MotionGraph((), 30.0, stands, links, np.zeros(5))
    embedding = embed(graph, Environment(Grid((1, 1, 1), 0.2), np.zeros((SUBDIVISION,) * 2, dtype=bool)))
    found = finish(occupancy_steps(embedding, 1e-9))
    assert found.residual <= 1e-9
    assert found.segments == pytest.approx([1 / 6, 1 / 6, 1 / 3, 1 / 3])


def lopsided():
    """On the spot at two cells, of which the left one lets go less often: shares 2/3 and 1/3 by detailed balance."""
    stand = MotionSegment("stand", 0, 0, 1, np.zeros((2, 3)), 1 / 30, {})
    there = MotionSegment("there", 0, 0, 3, np.column_stack([np.linspace(0, 0.2, 4), np.zeros((4, 2))]), 3 / 30, {})
    back = MotionSegment("back", 0, 0, 3, np.column_stack([np.linspace(0, -0.2, 4), np.zeros((4, 2))]), 3 / 30, {})
    links = np.argwhere(np.ones((3, 3), dtype=bool))
    graph = MotionGraph((), 30.0, (stand, there, back), links, np.zeros(9))
    return embed(graph, Environment(Grid((3, 1, 1), 0.2), np.zeros((12, 4), dtype=bool)))


def test_time_counts_by_duration():
    """Three cells in a row: all that fits is taken with the same chance; a move lasts three frames."""
    found = finish(occupancy_steps(lopsided(), 1e-8))
    # Visits of cells (left, middle, right) solve l = l/2 + m/3 and so on: 2/7, 3/7, 2/7.
    shares = visits(lopsided(), 1e-8).sum(axis=(2, 3)).ravel()
    assert shares == pytest.approx([2 / 7, 3 / 7, 2 / 7], abs=1e-5)
    stand, there, back = 3 / 7, 2 / 7 * 3, 2 / 7 * 3
    assert found.segments == pytest.approx(np.array([stand, there, back]) / (stand + there + back), abs=1e-5)
    assert found.hot_spot == pytest.approx((0.3, 0.1))


def test_statistics_of_uneven_time():
    found = finish(occupancy_steps(lopsided(), 1e-8))
    shares = np.sort(found.floor.ravel())[::-1]
    assert found.effective_area == pytest.approx(np.exp(-(shares * np.log(shares)).sum()) * 0.04)
    assert found.visited_area == pytest.approx(0.12)
    first = min(0.5 / shares[0], 1.0) if shares[0] >= 0.5 else 1 + (0.5 - shares[0]) / shares[1]
    assert found.half_time_share == pytest.approx(first / 3)
    assert "0.12 m²" not in found.describe()[0] and "evenly" in found.describe()[1]


def squared_deviations(exact, simulated):
    """Mean of ((simulated - exact) / standard error)^2 over the cells that are often visited: about 1."""
    often = exact.floor > 0.2 / np.count_nonzero(exact.floor)
    deviation = simulated.deviation[often]
    return float(np.mean(np.square((simulated.floor - exact.floor)[often] / deviation)))


@pytest.mark.parametrize(("seed", "tiled"), PROBLEMS)
def test_simulated_walkers_agree_on_random_problems(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assert embedding.n_nodes > 100
    exact = finish(occupancy_steps(embedding, 1e-9))
    deviations = []
    for run in range(8):
        simulated = simulated_occupancy(embedding, np.random.default_rng(run), 400, 10.0, 5.0, 40)
        assert simulated.floor.sum() == pytest.approx(1.0)
        assert np.abs(simulated.segments - exact.segments).max() < 0.02
        deviations.append(squared_deviations(exact, simulated))
    assert 0.6 < np.mean(deviations) < 1.5


@cache
def recorded():
    embedding = embed(problems.graph(0.12), problems.room(3.5, 3.5))
    return embedding, finish(occupancy_steps(embedding, 1e-4))


def test_simulated_walkers_agree_on_recorded_clips(data_folder):
    embedding, exact = recorded()
    simulated = simulated_occupancy(embedding, np.random.default_rng(1), 2000, 20.0, 60.0, 40)
    assert 0.5 < squared_deviations(exact, simulated) < 1.6
    # The comparison is sharp: the walkers are not spread as evenly as the nodes.
    busy = exact.floor > 0.001
    even = np.where(exact.floor > 0, 1 / np.count_nonzero(exact.floor), 0.0)
    wrong = np.square((even - simulated.floor)[busy] / simulated.deviation[busy])
    assert wrong.mean() > 20


def test_one_long_random_walk_agrees(data_folder):
    """The walk that playback takes follows the same rule."""
    embedding, exact = recorded()
    walk = finish(random_walk_steps(embedding, np.random.default_rng(4), WalkSettings(3000.0)))
    frames = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
    played = np.bincount(walk.segments, minlength=len(frames)) * frames
    assert np.abs(played / played.sum() - exact.segments).sum() < 0.1


def test_large_grounds_lay_out_places_anew(monkeypatch):
    embedding = embed(*random_problem(*PROBLEMS[0]), SETTINGS)
    kept = finish(occupancy_steps(embedding, 1e-7))
    monkeypatch.setattr(markov_chain, "KEPT_BYTES", 0)
    assert np.array_equal(finish(occupancy_steps(embedding, 1e-7)).floor, kept.floor)


def test_what_is_refused_and_what_is_reported():
    embedding = ring(3)
    with pytest.raises(EmbeddingError, match="tolerance"):
        finish(occupancy_steps(embedding, 0.0))
    blocked = Environment(embedding.environment.grid, np.ones_like(embedding.environment.blocked))
    with pytest.raises(EmbeddingError, match="empty"):
        finish(occupancy_steps(embed(embedding.graph, blocked)))
    hasty = finish(occupancy_steps(embed(*random_problem(*PROBLEMS[0]), SETTINGS), 1e-9, 5))
    assert hasty.n_steps == 5 and hasty.residual > 1e-9 and hasty.error >= hasty.residual
    fractions = [progress.fraction for progress in occupancy_steps(embedding)]
    assert all(0 <= f <= 1 for f in fractions)
