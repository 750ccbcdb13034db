"""Orders in which nodes are added to a spanning subgraph while the budget lasts."""

from collections.abc import Generator
from dataclasses import dataclass
from enum import Enum

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..evaluation.bit_counter import BitCounts, constant, less
from ..evaluation.degrees import Degrees
from ..evaluation.variability import variability_counts
from ..progress import Progress
from .local_pruning import ranks_steps


class FillOrder(Enum):
    """The nodes that come first."""

    PLACES = "Best at Each Place"
    """The best node of every place, then the second best, and so on: every place gets its share, like local pruning."""
    VARIABILITY = "Highest Variability"
    """The nodes of highest segment variability, wherever they are: open ground before narrow passages."""


@dataclass(frozen=True)
class Filling:
    """All nodes of an embedding in an order, of which any number of steps may be taken.

    A step adds at most one node for each heading. Nodes are in order of their level; of one level, in order of
    segment, heading and cell.

    Attributes
    ----------
    embedding : Embedding
    levels : list of BitCounts
        For each block of headings of the embedding's nodes, their levels; the nodes of level 0 come first.
    n_levels : int
    """

    embedding: Embedding
    levels: list[BitCounts]
    n_levels: int

    @property
    def _block_bits(self) -> int:
        packing = self.embedding.network.packing
        return packing.plane_bytes * 8 * packing.headings

    @property
    def n_steps(self) -> int:
        """Steps after which all nodes are taken."""
        return self.n_levels * len(self.levels) * self._block_bits

    def nodes(self, n_steps: int) -> NodeSet:
        """The nodes of the first steps."""
        level, rest = divmod(n_steps, len(self.levels) * self._block_bits)
        block, bit = divmod(rest, self._block_bits)
        taken, packing = [], self.embedding.network.packing
        for index, (everyone, counts) in enumerate(zip(packing.pack(self.embedding.planes), self.levels, strict=True)):
            nodes = everyone & less(counts, constant(level, everyone))
            if index <= block:
                last = everyone & less(counts, constant(level + 1, everyone))
                nodes |= last if index < block else last & ((1 << bit) - 1)
            taken.append(nodes)
        return packing.unpack_all(taken)


def filling_steps(embedding: Embedding, order: FillOrder) -> Generator[Progress, None, Filling]:
    """Put the nodes of an embedding in an order. Yields progress."""
    if order is FillOrder.PLACES:
        levels = yield from ranks_steps(embedding)
    else:
        levels = yield from _variability_levels_steps(embedding)
    return Filling(embedding, levels, 1 << max((len(counts) for counts in levels), default=0))


def _variability_levels_steps(embedding: Embedding) -> Generator[Progress, None, list[BitCounts]]:
    """Subtract each node's segment variability from the highest number with as many binary digits."""
    packing, degrees = embedding.network.packing, Degrees(embedding)
    nodes = packing.pack(embedding.planes)
    values: list[BitCounts] = [[] for _ in nodes]
    for block in range(packing.n_blocks):
        yield Progress(block / packing.n_blocks, "Ranking nodes")
        values[block :: packing.n_blocks] = variability_counts(embedding, degrees, block)
        degrees.forget(block)
    n_digits = max((len(value) for value in values), default=0)
    return [
        [node ^ (value[digit] if digit < len(value) else 0) for digit in range(n_digits)]
        for node, value in zip(nodes, values, strict=True)
    ]
