"""Benchmarks of what an embedding is asked."""

import numpy as np

from core.embedding.embedding import Embedding, embed
from core.evaluation.variability import floor_variability
from core.evaluation.why_not import why_not
from tests.bench import problems
from tests.bench.benchmark import Benchmark


def _fresh(embedding: Embedding) -> Embedding:
    """The same embedding without what it remembers of earlier questions."""
    return Embedding(**{name: getattr(embedding, name) for name in Embedding.__dataclass_fields__})


def variability_map() -> Benchmark:
    """From an embedding to the floor map of variability."""
    embedding = embed(problems.graph(0.12), problems.room())

    def by_links():
        _, links = embedding.to_csr()
        return np.diff(links.indptr) * np.diff(links.tocsc().indptr)

    return Benchmark(
        run=lambda: floor_variability(_fresh(embedding)),
        counts=lambda floor: {"total": int(floor.sum())},
        reference=by_links,
        reference_name="degrees of explicit links",
    )


def reasons() -> Benchmark:
    """Why not? for every grid element."""
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(run=lambda: why_not(_fresh(embedding)), counts=lambda found: {"elements": found.size})


BENCHMARKS = {"variability": variability_map, "why-not": reasons}
