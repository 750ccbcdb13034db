"""Large grounds in parcels: what cutting costs, and what a second worker gains."""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from core.embedding.embedding import EmbeddingSettings, embed
from core.expanse.embedding import ExpanseSummary, embed_expanse
from core.expanse.problem import create_problem

from . import problems
from .benchmark import Benchmark

SIDE, PARCEL = 60.0, 20.0
"""Metres."""


def _in_parcels(n_workers: int) -> ExpanseSummary:
    graph, environment = problems.graph(0.12), problems.room(SIDE, SIDE)
    with tempfile.TemporaryDirectory(prefix="wayfarer-bench-") as folder:
        create_problem(Path(folder), graph, environment, EmbeddingSettings(), PARCEL)
        with ProcessPoolExecutor(n_workers) as executor:
            return embed_expanse(Path(folder), executor)


def _counts(summary: ExpanseSummary) -> dict:
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


BENCHMARKS = {"parcels": parcels, "parcels-workers": second_worker}
