"""The price of local pruning: nodes, links and coverage for every k."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding, restrict_steps
from ..evaluation.floor import floor_cells
from ..progress import Progress, portion
from .local_pruning import ranked_below, ranks_steps


@dataclass(frozen=True)
class PruningCurve:
    """One entry for each k, from 1 to the largest number of nodes at any p; all arrays have that length.

    Attributes
    ----------
    k : int array
        Nodes kept at each p = (x, y, heading), at most. The last entry is the embedding itself.
    n_nodes, n_links : int64 arrays
        Of the largest strongly connected component that is left.
    floor_coverage : float array
        Cells covered in at least one heading, as a share of the free cells.
    coverage : float array
        Elements (x, y, heading) covered, as a share of those over free cells.
    """

    k: np.ndarray
    n_nodes: np.ndarray
    n_links: np.ndarray
    floor_coverage: np.ndarray
    coverage: np.ndarray

    def smallest_k(self, floor_coverage: float) -> int | None:
        """Return the least k from which on no k covers less than this share of the free cells; None if there is none.

        >>> floor, none = np.array([0.2, 0.8, 0.9]), np.zeros(3)
        >>> PruningCurve(np.array([1, 2, 3]), none, none, floor, none).smallest_k(0.75)
        2
        """
        enough = self.floor_coverage >= floor_coverage
        if not len(enough) or not enough[-1]:
            return None
        return int(self.k[len(enough) - np.argmin(enough[::-1])]) if not enough.all() else int(self.k[0])


def pruning_curve_steps(embedding: Embedding) -> Generator[Progress, None, PruningCurve]:
    """Prune locally for every k that makes a difference, and one that makes none; no entries if there are no nodes.

    Each entry is what ``prune_local_steps(embedding, k)`` keeps. Nodes are ranked only once.
    """
    ranks = yield from portion(ranks_steps(embedding), 0.0, 0.1)
    rows: list[tuple[int, int, float, float]] = []
    pruned: Embedding | None = None
    # Of the whole embedding: what pruning takes away stays part of the floor.
    n_free = max(np.count_nonzero(floor_cells(embedding)), 1)
    while embedding.n_nodes and pruned is not embedding:
        k = len(rows) + 1
        start = 0.1 + 0.9 * len(rows) / embedding.shape[3]
        nodes = ranked_below(embedding, ranks, k)
        if nodes == embedding.nodes:
            pruned = embedding
        else:
            # What is kept for fewer nodes at each p is a part of what is kept for more.
            steps = restrict_steps(embedding, nodes, pruned.nodes if pruned else None)
            pruned = yield from portion(steps, start, start + 0.9 / embedding.shape[3])
        covered = pruned.covered()
        floor = np.count_nonzero(covered.any(axis=2)) / n_free
        share = np.count_nonzero(covered) / (n_free * embedding.shape[2])
        rows.append((pruned.n_nodes, pruned.n_links, floor, share))
    n_nodes, n_links, floor_coverage, shares = np.array(rows, dtype=float).reshape(-1, 4).T
    return PruningCurve(
        np.arange(1, len(rows) + 1), n_nodes.astype(np.int64), n_links.astype(np.int64), floor_coverage, shares
    )
