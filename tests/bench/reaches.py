"""Benchmarks of exact shortest times, and of what is measured with them."""

from collections.abc import Callable, Generator

import numpy as np
from scipy.sparse.csgraph import dijkstra

from core.embedding.embedding import Embedding, embed
from core.embedding.node_set import NodeSet
from core.evaluation.detours import detours_steps
from core.evaluation.goals import goal_in_cells
from core.evaluation.link_utility import link_utility
from core.evaluation.maneuverability import maneuverabilities_steps
from core.evaluation.path_efficiency import path_efficiency_steps
from core.evaluation.reach import ReachField, time_from_steps, time_to_reach_steps
from core.evaluation.turn_balance import turn_balance
from core.progress import Progress, finish
from tests.bench import problems
from tests.bench.benchmark import Benchmark


def _goal(embedding: Embedding) -> NodeSet:
    """A square of five cells' side around a covered cell a third of the way across."""
    covered = np.argwhere(embedding.covered().any(axis=2))
    x, y = covered[len(covered) // 3]
    mask = np.zeros(embedding.shape[:2], dtype=bool)
    mask[x - 2 : x + 3, y - 2 : y + 3] = True
    return goal_in_cells(embedding, mask)


def _field(search: Callable[[Embedding, NodeSet], Generator[Progress, None, ReachField]], prepared: bool) -> Benchmark:
    """From an embedding to the times of all its nodes; the reference may have its links written out beforehand."""
    embedding = embed(problems.graph(0.1), problems.room())
    goal = _goal(embedding)
    at_goal = np.flatnonzero(finish(search(embedding, goal)).frames_at(embedding.to_csr()[0]) == 0)

    def written_out():
        _, links = embedding.to_csr()
        links.data = np.round(links.data * embedding.graph.frame_rate)
        return links if search is time_from_steps else links.T.tocsr()

    kept = written_out() if prepared else None

    def counts(field: ReachField) -> dict:
        frames = field.histogram()
        return {"nodes": int(frames.sum()), "frames": int(frames @ np.arange(len(frames)))}

    def reference_counts(times: np.ndarray) -> dict:
        return {"nodes": int(np.isfinite(times).sum()), "frames": int(times.sum())}

    return Benchmark(
        run=lambda: finish(search(embedding, goal)),
        counts=counts,
        reference=lambda: dijkstra(kept if prepared else written_out(), indices=at_goal, min_only=True),
        reference_counts=reference_counts,
        reference_name="SciPy's Dijkstra on links " + ("written out before" if prepared else "that it writes out"),
        repeats=9,
        reference_repeats=2,
    )


def _fields_on_large_ground() -> Benchmark:
    """The times over a ground of 40 x 40 m."""
    embedding = embed(problems.graph(0.12), problems.room(40.0, 40.0))
    goal = _goal(embedding)
    return Benchmark(
        lambda: finish(time_to_reach_steps(embedding, goal)), lambda _: {"nodes": embedding.n_nodes}, repeats=2
    )


def _measured(measure: Callable[[Embedding], object], counts: Callable[[object], dict], repeats: int) -> Benchmark:
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(lambda: measure(embedding), counts, repeats=repeats)


BENCHMARKS = {
    "reach": lambda: _field(time_to_reach_steps, prepared=False),
    "reach-prepared": lambda: _field(time_to_reach_steps, prepared=True),
    "reach-from": lambda: _field(time_from_steps, prepared=False),
    "reach-40m": _fields_on_large_ground,
    "efficiency": lambda: _measured(
        lambda e: finish(path_efficiency_steps(e, np.random.default_rng(1))),
        lambda found: {"pairs": len(found.seconds)},
        1,
    ),
    "detours": lambda: _measured(lambda e: finish(detours_steps(e)), lambda found: {"goals": len(found.goals)}, 1),
    "maneuverability": lambda: _measured(
        lambda e: finish(maneuverabilities_steps(e)), lambda found: {"clips": len(found)}, 1
    ),
    "turn-balance": lambda: _measured(turn_balance, lambda found: {"turns": found.n_left + found.n_right}, 3),
    "link-utility": lambda: _measured(link_utility, lambda found: {"links": found.n_links}, 3),
}
