"""Benchmarks of walking."""

import numpy as np

from core.embedding.embedding import embed
from core.playback.synthesis import synthesize
from core.playback.walk import random_walk
from tests.bench import problems
from tests.bench.benchmark import Benchmark


def minute_of_walking() -> Benchmark:
    """A random walk of 60 s and its poses."""
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(
        run=lambda: synthesize(random_walk(embedding, np.random.default_rng(0), 60.0)),
        counts=lambda clip: {"frames": clip.n_frames},
    )


BENCHMARKS = {"walk": minute_of_walking}
