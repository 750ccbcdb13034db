"""Global pruning: drop whole segments, those with the least variability over the whole ground (paper, section 4.2)."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..errors import TuningError
from ..evaluation.ablation import without_steps
from ..evaluation.variability import coverage_share, integrated_variability_steps
from ..progress import Progress, portion


@dataclass(frozen=True)
class DroppedSegment:
    """A segment that global pruning has dropped, and what was left after it.

    Attributes
    ----------
    segment : int
        Index into ``graph.segments``.
    name : str
    variability : int
        Its integrated variability when it was dropped: the least of all segments still there.
    n_nodes, n_links : int
        Of the embedding without it.
    coverage : float
        Share of the free cells that the embedding without it covers.
    """

    segment: int
    name: str
    variability: int
    n_nodes: int
    n_links: int
    coverage: float


@dataclass(frozen=True)
class GlobalPruning:
    """The embedding that global pruning kept, and the segments that it dropped, in that order.

    Attributes
    ----------
    embedding : Embedding
        Its motion graph still lists all segments; those dropped have no nodes.
    dropped : tuple of DroppedSegment
    """

    embedding: Embedding
    dropped: tuple[DroppedSegment, ...]


def prune_global_steps(embedding: Embedding, n_segments: int) -> Generator[Progress, None, GlobalPruning]:
    """Drop the segment of least integrated variability and take the largest strongly connected component of the rest,
    again and again, until ``n_segments`` segments are left (paper, section 4.2).

    Variability is counted anew after each drop. Of equal segments the one with the lowest index is dropped first:
    also of those that have no nodes left, and so no variability. The paper shows what this loses: rare segments
    that only few places need, but cannot do without.

    Raises
    ------
    TuningError
        ``n_segments`` is not a whole number from 1 to the number of segments.
    """
    segments = embedding.graph.segments
    if int(n_segments) != n_segments or not 1 <= n_segments <= len(segments):
        raise TuningError(
            f"The motion graph cannot be pruned to {n_segments} segments; it has {len(segments)}: keep 1 to that many."
        )
    whole, n_drops = embedding, len(segments) - int(n_segments)
    dropped: list[DroppedSegment] = []
    left = list(range(len(segments)))
    for drop in range(n_drops):
        start, middle, end = drop / n_drops, (drop + 0.4) / n_drops, (drop + 1) / n_drops
        sums = yield from portion(integrated_variability_steps(embedding), start, middle)
        worst = left.pop(int(np.argmin(sums[left])))
        if sums[worst]:
            embedding = yield from portion(without_steps(embedding, [worst]), middle, end)
        dropped.append(
            DroppedSegment(
                worst,
                segments[worst].name,
                int(sums[worst]),
                embedding.n_nodes,
                embedding.n_links,
                coverage_share(embedding, whole),
            )
        )
    return GlobalPruning(embedding, tuple(dropped))
