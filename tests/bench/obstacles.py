"""A pillar is moved beside a mesh of a million triangles: ``python3 dev.py bench obstacle_moves``."""

import numpy as np

from core.environment.environment import Environment, build_environment
from core.environment.grid import Grid
from core.environment.obstacle_masks import ObstacleCache
from core.environment.pieces import Piece, Shape, all_triangles
from tests.bench.benchmark import Benchmark

_SIDE = 708


def _hilly() -> Shape:
    """A mesh of a metre, of two triangles for each of its squares."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.linspace(0, 1, _SIDE + 1), np.linspace(0, 1, _SIDE + 1), indexing="ij")
    points = np.stack([x, y, rng.uniform(0.2, 1.5, x.shape)], axis=-1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return Shape(np.concatenate([np.stack(part, axis=2).reshape(-1, 3, 3) for part in ((a, b, c), (a, c, d))]))


def _pillar() -> Shape:
    corners = np.array([[0, 0], [0.4, 0], [0.4, 0.4], [0, 0.4]])
    low, high = np.c_[corners, np.zeros(4)], np.c_[corners, np.full(4, 2.5)]
    sides = [(low[i - 1], low[i], high[i], high[i - 1]) for i in range(4)] + [tuple(low[::-1]), tuple(high)]
    return Shape(np.array([triangle for a, b, c, d in sides for triangle in ((a, b, c), (a, c, d))]))


def _at(shape: Shape, x: float, y: float) -> Piece:
    matrix = np.eye(4)
    matrix[:2, 3] = x, y
    return Piece(shape, matrix)


def _counts(environment: Environment) -> dict:
    return {"blocked": int(environment.blocked.sum())}


def obstacle_moves() -> Benchmark:
    """There and back: two moves."""
    grid, memory = Grid.over_rectangle((0, 0), (7, 8), 0.125, 16), ObstacleCache()
    hill, pillar = _at(_hilly(), 3, 3), _pillar()
    scenes = [[hill, _at(pillar, *place)] for place in ((1.03, 1.21), (5.4, 6.17))]

    def remembered() -> Environment:
        there, back = (build_environment(grid, pieces, memory=memory) for pieces in scenes)
        assert (there.blocked != back.blocked).any()
        return back

    def from_scratch() -> Environment:
        _, back = [build_environment(grid, all_triangles(pieces)) for pieces in scenes]
        return back

    return Benchmark(
        remembered,
        counts=_counts,
        reference=from_scratch,
        reference_counts=_counts,
        reference_name="all triangles anew",
    )


BENCHMARKS = {"obstacle_moves": obstacle_moves}
