"""Variability and coverage (paper, section 4.1, equations 1 to 3).

The numbers of ways are added up and multiplied on bit-planes (see :mod:`.bit_counter`), one block of headings after the
other: a ground of tens of millions of nodes takes about as much memory again as its embedding, not gigabytes.
"""

from collections.abc import Generator

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.network import StepNetwork
from ..progress import Progress, finish
from .bit_counter import BitCounter, BitCounts, masked, product, sum_of_products
from .degrees import Degrees
from .floor import floor_cells

_MESSAGE = "Counting ways"


def segment_variability_of(embedding: Embedding, segment: int) -> np.ndarray:
    """(nx, ny, n_headings) int64: in-degree x out-degree of the nodes of one segment (eq. 1); 0 where there is none.

    Raises
    ------
    IndexError
        There is no segment of this index.
    """
    if not 0 <= segment < embedding.shape[3]:
        raise IndexError(f"There is no segment {segment} in a motion graph of {embedding.shape[3]} segments.")
    network, degrees = embedding.network, Degrees(embedding)
    group = network.exit_group_of[segment]
    blocks = [
        _numbers(network, product(degrees.incoming(segment, block), degrees.outgoing(group, block)))
        for block in range(network.packing.n_blocks)
    ]
    return np.concatenate(blocks, axis=2)


def variability_counts(embedding: Embedding, degrees: Degrees, block: int) -> list[BitCounts]:
    """Count segment variability (eq. 1) over a block of headings, for each segment."""
    exit_group_of = embedding.network.exit_group_of
    return [
        product(degrees.incoming(segment, block), degrees.outgoing(group, block))
        for segment, group in enumerate(exit_group_of)
    ]


def variability(embedding: Embedding) -> np.ndarray:
    """(nx, ny, n_headings) int64: segment variability summed over segments (eq. 2).

    The number of ways to come through p: pairs of a link that arrives there and a link that goes on.
    """
    return finish(variability_steps(embedding))


def variability_steps(embedding: Embedding) -> Generator[Progress, None, np.ndarray]:
    """Return what :func:`variability` does. Yields progress."""
    network, degrees = embedding.network, Degrees(embedding)
    ways = np.empty(embedding.shape[:3], dtype=np.int64)
    for block in range(network.packing.n_blocks):
        total = BitCounter()
        for group, members in enumerate(network.exit_groups):
            yield Progress((block + group / len(network.exit_groups)) / network.packing.n_blocks, _MESSAGE)
            arriving = BitCounter()
            for segment in members:
                arriving.add_counts(degrees.incoming(segment, block))
            total.add_counts(product(arriving.total(), degrees.outgoing(group, block)))
        first = block * network.packing.headings
        ways[:, :, first : first + network.packing.headings] = _numbers(network, total.total())
        degrees.forget(block)
    return ways


def heading_variability(embedding: Embedding, heading: int) -> np.ndarray:
    """(nx, ny) int64: variability of one heading, given as an index (the paper's Fig. 7).

    Raises
    ------
    IndexError
        There is no heading of this index.
    """
    network = embedding.network
    if not 0 <= heading < network.n_headings:
        raise IndexError(f"There is no heading {heading} on a grid of {network.n_headings} headings.")
    packing = network.packing
    block, place = divmod(heading, packing.headings)
    here = packing.pack([network.layout.ground if i == place else 0 for i in range(packing.headings)])[0]
    degrees, total = Degrees(embedding), BitCounter()
    for segment, group in enumerate(network.exit_group_of):
        total.add_product(masked(degrees.incoming(segment, block), here), degrees.outgoing(group, block))
    return _numbers(network, total.total())[:, :, place]


def floor_variability(embedding: Embedding) -> np.ndarray:
    """(nx, ny) int64: variability summed over headings: the floor map of the paper's Fig. 1."""
    return variability(embedding).sum(axis=2)


def integrated_variability_steps(embedding: Embedding) -> Generator[Progress, None, np.ndarray]:
    """(n_segments,) int64: segment variability of each segment, summed over the whole domain (paper, section 4.2)."""
    network, degrees = embedding.network, Degrees(embedding)
    sums = np.zeros(network.n_segments, dtype=np.int64)
    for block in range(network.packing.n_blocks):
        for segment, group in enumerate(network.exit_group_of):
            yield Progress((block + segment / network.n_segments) / network.packing.n_blocks, _MESSAGE)
            sums[segment] += sum_of_products(degrees.incoming(segment, block), degrees.outgoing(group, block))
        degrees.forget(block)
    return sums


def coverage_share(embedding: Embedding, whole: Embedding | None = None) -> float:
    """Return the share of the free floor that the character can pass in at least one heading; 0 if there is none.

    Coverage (eq. 3) is where variability is positive, and that is where there is a node: in a strongly connected
    component, links lead to each of its nodes and from it.

    The floor is that of ``whole``, if that is what ``embedding`` was pruned from: shares of one floor compare.
    """
    covered = embedding.covered().any(axis=2)
    return float(np.count_nonzero(covered) / max(np.count_nonzero(floor_cells(whole or embedding)), 1))


def _numbers(network: StepNetwork, counts: BitCounts) -> np.ndarray:
    """(nx, ny, headings of a block) int64: the counts of a counts of blocks."""
    layout = network.layout
    numbers = np.zeros((network.packing.headings, layout.nx, layout.ny), dtype=np.int64)
    for digit, packed in enumerate(counts):
        for place, plane in enumerate(network.packing.unpack(packed)):
            numbers[place] += layout.unpack(plane).astype(np.int64) << digit
    return numbers.transpose(1, 2, 0)
