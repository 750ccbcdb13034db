"""Geodesics against every straight line walked sample by sample."""

from itertools import pairwise
from math import gcd

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.environment.environment import Environment
from core.environment.grid import Grid
from core.evaluation.geodesic import OPEN_GROUND_ERROR, REACH, Geodesics

from .reference import random_problem, samples_of_piece


def slow_lines(environment):
    """The lines between cells as a networkx graph."""
    grid, blocked = environment.grid, environment.blocked
    nx, ny = grid.shape[:2]
    lines = networkx.Graph()
    lines.add_nodes_from(np.ndindex(nx, ny))
    for x, y in np.ndindex(nx, ny):
        for dx in range(-REACH, REACH + 1):
            for dy in range(-REACH, REACH + 1):
                u, v = x + dx, y + dy
                if gcd(dx, dy) != 1 or not (grid.tiled or (0 <= u < nx and 0 <= v < ny)):
                    continue
                samples = samples_of_piece((4 * x + 2, 4 * y + 2), (4 * u + 2, 4 * v + 2))
                samples |= {(4 * x + 2, 4 * y + 2), (4 * u + 2, 4 * v + 2)}
                if not any(blocked[a % (4 * nx), b % (4 * ny)] for a, b in samples):
                    length = np.hypot(dx, dy) * grid.cell_size
                    known = lines.get_edge_data((x, y), (u % nx, v % ny))
                    if known is None or length < known["weight"]:
                        lines.add_edge((x, y), (u % nx, v % ny), weight=length)
    return lines


@settings(max_examples=15)
@given(st.integers(0, 10**6), st.booleans())
def test_distances_equal_those_over_lines_walked_one_by_one(seed, tiled):
    environment = random_problem(seed, tiled)[1]
    nx, ny = environment.grid.shape[:2]
    cells = np.random.default_rng(seed).integers(0, [nx, ny], (3, 2))
    fast = Geodesics(environment).distances(cells)
    lines = slow_lines(environment)
    for cell, found in zip(cells.tolist(), fast, strict=True):
        slow = np.full((nx, ny), np.inf)
        if environment.free_cells()[tuple(cell)]:
            for place, metres in networkx.single_source_dijkstra_path_length(lines, tuple(cell)).items():
                slow[place] = metres
        assert np.allclose(found, slow, rtol=1e-12)


@pytest.mark.parametrize("tiled", [False, True])
def test_open_ground_is_crossed_almost_straight(tiled):
    grid = Grid((40, 30, 1), 0.2, (1.0, 2.0), tiled)
    geodesics = Geodesics(Environment(grid, np.zeros((160, 120), dtype=bool)))
    found = geodesics.distances(np.array([[3, 27]]))[0]
    offset = np.abs(np.moveaxis(np.indices((40, 30)), 0, -1) - [3, 27])
    if tiled:
        offset = np.minimum(offset, [40, 30] - offset)
    straight = np.hypot(*np.moveaxis(offset, -1, 0)) * 0.2
    assert np.all(found >= straight - 1e-9)
    assert np.all(found <= straight * (1 + OPEN_GROUND_ERROR) + 1e-9)
    assert (found / np.maximum(straight, 1e-9)).max() > 1 + OPEN_GROUND_ERROR / 2  # the bound is not idle
    near = geodesics.distances(np.array([[3, 27]]), limit=1.0)[0]
    assert np.array_equal(near, np.where(found <= 1.0, found, np.inf))


def test_ways_lead_around_walls():
    """A wall with a gap at one end: the way is that around its end, to within a cell."""
    grid = Grid((40, 40, 1), 0.1)
    blocked = np.zeros((160, 160), dtype=bool)
    blocked[80:84, :120] = True
    found = Geodesics(Environment(grid, blocked)).distances(np.array([[10, 5]]))[0]
    start, end, corners = np.array([1.05, 0.55]), np.array([3.05, 0.55]), [np.array([2.0, 3.0]), np.array([2.1, 3.0])]
    way = [start, *corners, end]
    exact = sum(np.linalg.norm(b - a) for a, b in pairwise(way))
    assert exact <= found[30, 5] <= exact * (1 + OPEN_GROUND_ERROR) + 2 * 0.1
