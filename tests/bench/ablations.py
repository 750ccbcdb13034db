"""Benchmarks of what matters, what is missing and where walkers spend their time."""

import numpy as np
from scipy import sparse

from core.embedding.embedding import embed, restrict_steps
from core.evaluation.ablation import ablate_steps
from core.evaluation.capture.candidate import augmented, candidates
from core.evaluation.capture.director import direct_capture_steps
from core.evaluation.deletion import deletable_together_steps
from core.evaluation.occupancy import occupancy_steps
from core.evaluation.segment_groups import Grouping, segment_groups
from core.evaluation.size import embedding_size
from core.progress import finish
from tests.bench import problems
from tests.bench.benchmark import Benchmark
from tests.bench.simulated_walkers import simulated_occupancy

N_CANDIDATES = 60
WALKERS, SECONDS = 2000, 30.0


def ablation() -> Benchmark:
    """What is lost without each segment, in turn."""
    return _ablation([Grouping.SEGMENT])


def ablation_of_all() -> Benchmark:
    """What is lost without each segment, each clip and each tag."""
    return _ablation(list(Grouping))


def _ablation(kinds: list[Grouping]) -> Benchmark:
    embedding = embed(problems.graph(0.12), problems.room())

    def from_scratch():
        left = []
        for part in (part for kind in kinds for part in segment_groups(embedding.graph, kind)):
            gone = set(part.segments)
            nodes = embedding.nodes.where(lambda index, gone=gone: index // embedding.shape[2] not in gone)
            left.append(embedding_size(finish(restrict_steps(embedding, nodes))))
        return left

    return Benchmark(
        run=lambda: finish(ablate_steps(embedding, kinds)),
        counts=lambda found: _sums([loss.left for loss in found.losses]),
        reference=from_scratch,
        reference_counts=_sums,
        reference_name="one search for each part",
        repeats=3,
        reference_repeats=1,
    )


def _sums(left: list) -> dict:
    return {"parts": len(left), "nodes": sum(e.nodes for e in left), "links": sum(e.links for e in left)}


def joint_deletion() -> Benchmark:
    """The clips that can be deleted together for 2 % of the floor."""
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(
        run=lambda: finish(deletable_together_steps(embedding, 0.02)),
        counts=lambda found: {"clips": len(found.groups), "nodes": found.left.nodes},
        repeats=3,
    )


def capture() -> Benchmark:
    """What each of 60 motions would open."""
    embedding = embed(problems.graph(0.12), problems.room())
    family = candidates(embedding, retimed=True)[:N_CANDIDATES]

    def from_scratch():
        return [
            embedding_size(embed(augmented(embedding.graph, candidate), embedding.environment, embedding.settings))
            for candidate in family
        ]

    return Benchmark(
        run=lambda: finish(direct_capture_steps(embedding, family)),
        counts=lambda found: _sums([gain.after for gain in found.gains]),
        reference=from_scratch,
        reference_counts=_sums,
        reference_name="embedding each larger graph",
        repeats=3,
        reference_repeats=1,
    )


def stationary(max_cost: float) -> Benchmark:
    """Where random walkers spend their time in the long run."""
    embedding = embed(problems.graph(max_cost), problems.room())

    def by_links():
        nodes, starts, ends = embedding.network.links_within(embedding.nodes)
        n = len(nodes)
        degree = np.bincount(starts, minlength=n)
        chances = sparse.csr_array((1 / degree[starts], (ends, starts)), shape=(n, n))
        shares = np.full(n, 1 / n)
        while True:
            after = chances @ shares
            residual = np.abs(after - shares).sum()
            shares = 0.9 * after + 0.1 * shares
            if residual <= 1e-5:
                return n

    small = embedding.n_links < 10_000_000
    return Benchmark(
        run=lambda: (finish(occupancy_steps(embedding)), embedding.n_nodes),
        counts=lambda found: {"nodes": found[1], "steps": found[0].n_steps},
        reference=by_links if small else None,
        reference_counts=lambda n: {"nodes": n},
        reference_name="powers of a matrix of explicit links" if small else None,
        repeats=1,
        reference_repeats=1,
    )


def simulation() -> Benchmark:
    """Two thousand walkers, half a minute each after half a minute."""
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(
        run=lambda: simulated_occupancy(embedding, np.random.default_rng(0), WALKERS, SECONDS, SECONDS),
        counts=lambda found: {"links": found.n_links},
        repeats=3,
    )


BENCHMARKS = {
    "ablation": ablation,
    "ablation-all": ablation_of_all,
    "joint-deletion": joint_deletion,
    "capture": capture,
    "occupancy": lambda: stationary(0.12),
    "occupancy-dense": lambda: stationary(0.3),
    "walkers": simulation,
}
