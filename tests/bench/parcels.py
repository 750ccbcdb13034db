"""Large grounds: rasterising them in strips, and in parcels what cutting costs, and what a second worker gains."""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from scipy import ndimage

from core.embedding.embedding import EmbeddingSettings, embed
from core.environment.environment import EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.environment.obstacles import clip_to_heights, occupied_samples
from core.parcels.embedding import ParcelSummary, embed_parcels_steps
from core.parcels.problem import create_problem
from core.progress import finish
from tests.core.geometry import box_triangles

from . import problems
from .benchmark import Benchmark

SIDE, PARCEL = 60.0, 20.0
"""Metres."""


def _in_parcels(n_workers: int) -> ParcelSummary:
    graph, environment = problems.graph(0.12), problems.room(SIDE, SIDE)
    with tempfile.TemporaryDirectory(prefix="wayfarer-bench-") as folder:
        create_problem(Path(folder), graph, environment, EmbeddingSettings(), PARCEL)
        with ProcessPoolExecutor(n_workers) as executor:
            return finish(embed_parcels_steps(Path(folder), executor))


def _counts(summary: ParcelSummary) -> dict:
    return {"nodes": summary.n_nodes, "links": summary.n_links}


def parcels() -> Benchmark:
    """60 x 60 m in nine parcels by two workers, maps included, against one process that holds it all."""
    graph, environment = problems.graph(0.12), problems.room(SIDE, SIDE)
    return Benchmark(
        run=lambda: _in_parcels(2),
        counts=_counts,
        reference=lambda: embed(graph, environment),
        reference_counts=lambda embedding: {"nodes": embedding.n_nodes, "links": embedding.n_links},
        reference_name="all in one process, without maps",
        repeats=1,
    )


def second_worker() -> Benchmark:
    """The same by two workers against one."""
    return Benchmark(
        run=lambda: _in_parcels(2),
        counts=_counts,
        reference=lambda: _in_parcels(1),
        reference_counts=_counts,
        reference_name="one worker",
        repeats=1,
    )


def _pillars(width: float, depth: float) -> np.ndarray:
    """Square pillars scattered over a ground."""
    rng = np.random.default_rng(11)
    n = int(width * depth * 0.12)
    low, side = rng.uniform([0.5, 0.5], [width - 1, depth - 1], (n, 2)), rng.uniform(0.2, 0.5, (n, 2))
    return np.concatenate([box_triangles((*a, 0), (*(a + b), 2)) for a, b in zip(low, side, strict=True)])


def _rasterising(width: float, depth: float, repeats: int) -> Benchmark:
    grid, pillars = Grid.over_rectangle((0, 0), (width, depth), 0.125, 24), _pillars(width, depth)
    body = EnvironmentSettings(radius=0.25)

    def distances() -> np.ndarray:
        """The samples near obstacles, by a distance transform of the whole mask."""
        margin = int(np.ceil(body.radius / grid.sample_size)) + 2
        polygons = clip_to_heights(pillars, body.step_height, body.head_height)
        occupied = occupied_samples(grid, polygons, margin)
        apart = np.asarray(ndimage.binary_erosion(~occupied, np.ones((3, 3), dtype=bool), border_value=True))
        near = np.asarray(ndimage.distance_transform_edt(apart)) * grid.sample_size < body.radius * (1 + 1e-9)
        return (near | occupied)[margin:-margin, margin:-margin]

    return Benchmark(
        run=lambda: build_environment(grid, pillars, settings=body).blocked,
        counts=lambda blocked: {"samples": blocked.size, "blocked": int(np.count_nonzero(blocked))},
        reference=distances,
        reference_counts=lambda blocked: {"blocked": int(np.count_nonzero(blocked))},
        reference_name="a distance transform of the whole mask",
        repeats=repeats,
        reference_repeats=min(repeats, 3),
    )


def rasterising() -> Benchmark:
    """The obstacles of a room of 7 x 8 m, as they are rasterised whenever one moves."""
    return _rasterising(7.0, 8.0, 15)


def rasterising_large() -> Benchmark:
    """300 x 300 m."""
    return _rasterising(300.0, 300.0, 1)


BENCHMARKS = {
    "rasterise": rasterising,
    "rasterise-300": rasterising_large,
    "parcels": parcels,
    "parcels-workers": second_worker,
}
