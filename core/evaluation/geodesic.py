"""Geodesics: the shortest ways over the free ground, as straight lines would take them, whatever the motion allows.

Cells are joined by straight lines to all cells up to REACH cells away in x and in y, in every direction that differs:
176 directions. A line is free where every sample that it passes through is free of obstacles (regions do not count).
Shortest paths over these lines are exact on this network. On open ground they are never shorter than the straight
line, and longer by 0.2 % at most: neighbouring directions are at most atan(1 / 8) apart, and the way that mixes the
two is longest half way between them. Around an obstacle's corner the way must turn at a cell's centre, which adds less
than the width of a cell at each turn; a gap that no line between cell centres fits through counts as closed.
"""

from math import gcd

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION

#: Cells that a straight line reaches in x or in y.
REACH = 8

#: By what factor a way over open ground may be longer than the straight line: 1 / cos of half the widest gap.
OPEN_GROUND_ERROR = 1 / float(np.cos(np.arctan2(1, REACH) / 2)) - 1


class Geodesics:
    """Shortest ways between the cells of an environment.

    Attributes
    ----------
    shape : (nx, ny)
    free : (nx, ny) bool array
        Cells at whose centre the root may stand.
    lines : (nx * ny, nx * ny) sparse array
        Metres of each free line between two cells (x * ny + y), noted in both directions.
    """

    def __init__(self, environment: Environment):
        grid = environment.grid
        self.shape = grid.shape[:2]
        self.free = environment.free_cells()
        starts, ends, lengths = [], [], []
        number = np.arange(self.free.size).reshape(self.shape)
        for dx, dy in _directions():
            x, y = np.nonzero(_free_lines(environment, dx, dy))
            starts.append(number[x, y])
            ends.append(number[(x + dx) % self.shape[0], (y + dy) % self.shape[1]])
            lengths.append(np.full(len(x), np.hypot(dx, dy) * grid.cell_size))
        start, end, length = (np.concatenate(parts) for parts in (starts, ends, lengths))
        # Around a small tile several lines may join the same cells: the shortest one counts, whichever way it goes.
        pair = np.minimum(start, end) * self.free.size + np.maximum(start, end)
        order = np.argsort(length, kind="stable")
        pair, kept = np.unique(pair[order], return_index=True)
        a, b = np.divmod(pair, self.free.size)
        apart = a != b
        a, b, length = a[apart], b[apart], length[order][kept][apart]
        both = (np.concatenate([length, length]), (np.concatenate([a, b]), np.concatenate([b, a])))
        self.lines = sparse.csr_array(both, shape=(self.free.size, self.free.size))

    def distances(self, cells: np.ndarray, limit: float = np.inf) -> np.ndarray:
        """(n, nx, ny) metres from each of (n, 2) cells to all cells; infinite where there is no way within ``limit``.

        Infinite everywhere from a cell that is not free.
        """
        x, y = np.asarray(cells, dtype=int).reshape(-1, 2).T
        metres = dijkstra(self.lines, indices=x * self.shape[1] + y, limit=limit)
        metres = np.asarray(metres).reshape(-1, *self.shape)
        metres[~self.free[x, y]] = np.inf
        return metres


def _directions() -> list[tuple[int, int]]:
    """One of each two opposite directions (dx, dy) up to REACH, without those that repeat a shorter one."""
    steps = range(-REACH, REACH + 1)
    return [(dx, dy) for dx in steps for dy in steps if gcd(dx, dy) == 1 and (dx, dy) > (0, 0)]


def _free_lines(environment: Environment, dx: int, dy: int) -> np.ndarray:
    """(nx, ny) bool: from which cells the straight line to the cell (dx, dy) further is free."""
    grid = environment.grid
    margin = (REACH + 1) * SUBDIVISION
    blocked = (
        np.pad(environment.blocked, margin, mode="wrap")
        if grid.tiled
        else np.pad(environment.blocked, margin, constant_values=True)
    )
    nx, ny = grid.shape[:2]
    free = np.ones((nx, ny), dtype=bool)
    for u, v in _samples_on_line(dx, dy):
        u, v = u + margin, v + margin
        free &= ~blocked[u : u + nx * SUBDIVISION : SUBDIVISION, v : v + ny * SUBDIVISION : SUBDIVISION]
    return free


def _samples_on_line(dx: int, dy: int) -> list[tuple[int, int]]:
    """Samples that the line from the centre of cell (0, 0) to that of (dx, dy) passes through, both ends included.

    A centre is a corner of samples; like everywhere, a point on a corner or a side belongs to the higher sample.
    """
    middle = SUBDIVISION // 2
    span = np.array([dx, dy]) * SUBDIVISION
    cuts = np.unique(np.concatenate([np.linspace(0, 1, abs(n) + 1) for n in span.tolist()]))
    # A little is added because what lies on a side must not fall below it by rounding.
    between = np.floor((cuts[:-1] + cuts[1:])[:, None] / 2 * span + middle + 1e-9).astype(int)
    ends = [(middle, middle), (middle + int(span[0]), middle + int(span[1]))]
    return sorted({*ends, *map(tuple, between.tolist())})
