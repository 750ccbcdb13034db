"""Benchmarks of exact shortest times, and of what is measured with them."""

from collections.abc import Callable

import numpy as np
from scipy.sparse.csgraph import dijkstra

from core.embedding.embedding import Embedding, embed
from core.embedding.network import Nodes
from core.evaluation.detours import detours
from core.evaluation.goals import goal_in_cells
from core.evaluation.link_utility import link_utility
from core.evaluation.maneuverability import maneuverabilities
from core.evaluation.path_efficiency import path_efficiency
from core.evaluation.reach import ReachField, time_from, time_to_reach
from core.evaluation.turn_balance import turn_balance
from tests.bench import problems
from tests.bench.benchmark import Benchmark


def _goal(embedding: Embedding) -> Nodes:
    """A square of five cells' side around a covered cell a third of the way across."""
    covered = np.argwhere(embedding.covered().any(axis=2))
    x, y = covered[len(covered) // 3]
    mask = np.zeros(embedding.shape[:2], dtype=bool)
    mask[x - 2 : x + 3, y - 2 : y + 3] = True
    return goal_in_cells(embedding, mask)


def _field(search: Callable[[Embedding, Nodes], ReachField], prepared: bool) -> Benchmark:
    """From an embedding to the times of all its nodes; the reference may have its links written out beforehand."""
    embedding = embed(problems.graph(0.1), problems.room())
    goal = _goal(embedding)
    at_goal = np.flatnonzero(search(embedding, goal).frames_at(embedding.to_csr()[0]) == 0)

    def written_out():
        _, links = embedding.to_csr()
        links.data = np.round(links.data * embedding.graph.frame_rate)
        return links if search is time_from else links.T.tocsr()

    kept = written_out() if prepared else None

    def counts(field: ReachField) -> dict:
        frames = field.histogram()
        return {"nodes": int(frames.sum()), "frames": int(frames @ np.arange(len(frames)))}

    def reference_counts(times: np.ndarray) -> dict:
        return {"nodes": int(np.isfinite(times).sum()), "frames": int(times.sum())}

    return Benchmark(
        run=lambda: search(embedding, goal),
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
    return Benchmark(lambda: time_to_reach(embedding, goal), lambda _: {"nodes": embedding.n_nodes}, repeats=2)


def _measured(measure: Callable[[Embedding], object], counts: Callable[[object], dict], repeats: int) -> Benchmark:
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(lambda: measure(embedding), counts, repeats=repeats)


BENCHMARKS = {
    "reach": lambda: _field(time_to_reach, prepared=False),
    "reach-prepared": lambda: _field(time_to_reach, prepared=True),
    "reach-from": lambda: _field(time_from, prepared=False),
    "reach-40m": _fields_on_large_ground,
    "efficiency": lambda: _measured(
        lambda e: path_efficiency(e, np.random.default_rng(1)), lambda found: {"pairs": len(found.seconds)}, 1
    ),
    "detours": lambda: _measured(detours, lambda found: {"goals": len(found.goals)}, 1),
    "maneuverability": lambda: _measured(maneuverabilities, lambda found: {"clips": len(found)}, 1),
    "turn-balance": lambda: _measured(turn_balance, lambda found: {"turns": found.n_left + found.n_right}, 3),
    "link-utility": lambda: _measured(link_utility, lambda found: {"links": found.n_links}, 3),
}
