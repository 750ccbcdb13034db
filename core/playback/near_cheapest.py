"""Chance among what is nearly the cheapest: links weighed by what they, and the best that can follow them, cost."""

from collections.abc import Sequence
from copy import copy

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node
from .prices import LinkPrices
from .weighted import Crossing, Weighting, uniform

#: Links after the one that is weighed that are looked ahead.
LOOK_AHEAD = 6

#: Links of a wave that are followed; beside them, the cheapest one from each of its nodes is.
BEAM = 40

#: Nodes of which the best is started from, where the start is left to chance.
STARTS = 5

#: Milliseconds more than the cheapest, at which a link is 37 % as likely.
TOLERANCE = 3000.0


class NearCheapest:
    """Links by a weighting, but the less likely, the more they cost.

    The weight of a link is multiplied by exp(-more / ``TOLERANCE``), where ``more`` is what the cheapest way found that
    begins with it, and goes on for ``LOOK_AHEAD`` links, costs beyond that of the best link with a weight. Ways of
    different duration are compared by what they cost more than so many frames cost as a rule (:mod:`.prices`).
    """

    def __init__(self, embedding: Embedding, weighting: Weighting = uniform):
        self._prices, self._weighting, self._look_ahead = LinkPrices(embedding), weighting, LOOK_AHEAD
        frames = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
        #: (K,) milliseconds that the frames of each stencil cost as a rule.
        self._usual = (self._prices.usual * frames)[embedding.unrolling.stencils.segment]

    def __call__(self, crossing: Crossing) -> np.ndarray:
        weights = np.asarray(self._weighting(crossing), dtype=float)
        before = np.full(len(crossing.stencils), crossing.node[3])
        more = self.more(before, crossing.stencils) + self._ways_on(crossing.reader, crossing.ends)
        liked = weights > 0
        more = more - more[liked].min() if liked.any() else more
        # No weight gets lost.
        return weights * np.exp(-np.clip(more / TOLERANCE, -500, 500))

    def hasty(self) -> "NearCheapest":
        """Return the same without looking ahead, which takes most of the time."""
        other = copy(self)
        other._look_ahead = 0
        return other

    def best_of(self, reader: LinkReader, nodes: Sequence[Node]) -> Node:
        """Return the node from which the cheapest way goes on."""
        return nodes[int(np.argmin(self._ways_on(reader, np.array(nodes))))]

    def more(self, before: np.ndarray, stencils: np.ndarray) -> np.ndarray:
        """Return (n,) milliseconds that links by stencils after segments cost more than their frames as a rule."""
        return self._prices.of(before, stencils) - self._usual[stencils]

    def _ways_on(self, reader: LinkReader, starts: np.ndarray) -> np.ndarray:
        """Return (n,) milliseconds that the cheapest ways found from (n, 4) nodes cost more than usual."""
        nodes, start = _distinct(reader, starts)
        so_far = np.zeros(len(nodes))
        waves = []
        for _ in range(self._look_ahead):
            row, stencil = reader.links_from(nodes)
            more = self.more(nodes[row, 3], stencil)
            total = so_far[row] + more
            order = np.lexsort((more, row))
            cheapest_of_each = order[np.flatnonzero(np.diff(row[order], prepend=-1))]
            kept = np.union1d(cheapest_of_each, np.argpartition(total, min(BEAM, len(total)) - 1)[:BEAM])
            nodes, end = _distinct(reader, reader.ends(nodes[row[kept]], stencil[kept]))
            waves.append((row[kept], more[kept], end, len(so_far)))
            so_far = _least(end, total[kept], len(nodes))
        left = np.zeros(len(nodes))
        for row, more, end, n_nodes in reversed(waves):
            left = _least(row, more + left[end], n_nodes)
        return left[start]


def _least(group: np.ndarray, values: np.ndarray, n_groups: int) -> np.ndarray:
    """Return (n_groups,) the least of (n,) values of each group."""
    least = np.full(n_groups, np.inf)
    np.minimum.at(least, group, values)
    return least


def _distinct(reader: LinkReader, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (m, 4) distinct nodes on the ground, and for each of (n, 4) the row of it."""
    nodes = reader.wrapped(nodes)
    keys = np.ravel_multi_index(tuple(nodes.T), reader.embedding.shape)
    _, first, row = np.unique(keys, return_index=True, return_inverse=True)
    return nodes[first], row.ravel()
