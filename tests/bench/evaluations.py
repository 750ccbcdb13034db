"""Benchmarks of what an embedding is asked."""

from dataclasses import replace

import numpy as np

from core.embedding.embedding import Embedding, embed
from core.evaluation.variability import floor_variability
from core.evaluation.weak_spots import WeakSpotSettings, weak_spots_steps
from core.evaluation.why_not import why_not_steps
from core.progress import finish
from tests.bench import problems
from tests.bench.benchmark import Benchmark


def _fresh(embedding: Embedding) -> Embedding:
    """The same embedding without what it remembers of earlier questions."""
    return replace(embedding, known_network=None)


def variability_map() -> Benchmark:
    """From an embedding to the floor map of variability."""
    embedding = embed(problems.graph(0.12), problems.room())

    def by_links():
        _, links = embedding.to_csr()
        return int(np.diff(links.indptr).astype(np.int64) @ np.diff(links.tocsc().indptr))

    return Benchmark(
        run=lambda: floor_variability(_fresh(embedding)),
        counts=lambda floor: {"total": int(floor.sum())},
        reference=by_links,
        reference_counts=lambda total: {"total": total},
        reference_name="degrees of explicit links",
    )


def variability_ground() -> Benchmark:
    """The floor map of a ground of 40 x 40 m, with tens of millions of nodes."""
    embedding = embed(problems.graph(0.12), problems.room(40.0, 40.0))
    return Benchmark(
        run=lambda: floor_variability(_fresh(embedding)),
        counts=lambda floor: {"nodes": embedding.n_nodes, "total": int(floor.sum())},
        repeats=3,
    )


def spots() -> Benchmark:
    """Weak spots of the floor, with reasons."""
    embedding = embed(problems.graph(0.12), problems.room())
    settings = WeakSpotSettings(threshold=50)
    return Benchmark(
        run=lambda: finish(weak_spots_steps(_fresh(embedding), settings)),
        counts=lambda found: {"spots": len(found.spots)},
    )


def reasons() -> Benchmark:
    """Why not? for every grid element."""
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(
        run=lambda: finish(why_not_steps(_fresh(embedding))), counts=lambda found: {"elements": found.size}
    )


BENCHMARKS = {
    "variability": variability_map,
    "variability-40m": variability_ground,
    "weak-spots": spots,
    "why-not": reasons,
}
