"""Local pruning: at each place keep the segments that offer most ways through (paper, section 4.2).

At each p = (x, y, heading) the nodes are ranked by segment variability, highest first; of equal ones, the segment
with the lower index comes first. All places are ranked at once, on bit-planes.
"""

from collections.abc import Generator

from ..embedding.embedding import Embedding, restrict_steps
from ..embedding.node_set import NodeSet, union_of
from ..errors import TuningError
from ..evaluation.bit_counter import BitCounter, BitCounts, constant, less, masked, minus
from ..evaluation.degrees import Degrees
from ..evaluation.variability import variability_counts
from ..progress import Progress, portion

#: For each segment and block (index segment * n_blocks + block) the counts of its nodes' ranks; the best has rank 0.
Ranks = list[BitCounts]


def prune_local_steps(embedding: Embedding, k: int) -> Generator[Progress, None, Embedding]:
    """Keep at each p = (x, y, heading) the ``k`` nodes of highest segment variability, and take the largest strongly
    connected component of what is left (paper, section 4.2).

    Of nodes of equal variability the one of the segment with the lower index stays. With ``k`` at least the number
    of segments nothing changes; an empty embedding stays empty.

    Raises
    ------
    TuningError
        ``k`` is not a whole number of at least 1.
    """
    if int(k) != k or k < 1:
        raise TuningError(f"Local pruning to {k} segments at each place leaves nothing; keep at least 1.")
    nodes = yield from portion(best_nodes_steps(embedding, int(k)), 0.0, 0.5)
    return (yield from portion(restrict_steps(embedding, nodes), 0.5, 1.0))


def best_nodes_steps(embedding: Embedding, k: int) -> Generator[Progress, None, NodeSet]:
    """Choose at each p the ``k`` nodes of highest segment variability, or all of fewer. Yields progress."""
    packing, degrees = embedding.network.packing, Degrees(embedding)
    nodes = packing.pack(embedding.planes)
    kept = [0] * len(nodes)
    for block in range(packing.n_blocks):
        yield Progress(block / packing.n_blocks, "Choosing the best nodes")
        values = variability_counts(embedding, degrees, block)
        kept[block :: packing.n_blocks] = best_at_each_place(values, nodes[block :: packing.n_blocks], k)
        degrees.forget(block)
    return packing.unpack_all(kept)


def best_at_each_place(values: list[BitCounts], members: list[int], k: int) -> list[int]:
    """Choose in each cell the ``k`` members of highest value, of planes (or blocks) that share their cells.

    Digit by digit from the highest: where enough candidates have the digit set, the others are out; elsewhere those
    are in, and the search goes on among the others for the rest. Of those that stay equal, the first ones are taken.
    """
    everywhere = union_of(members)
    kept, candidates, wanted = [0] * len(members), list(members), constant(k, everywhere)
    for digit in range(max((len(value) for value in values), default=0) - 1, -1, -1):
        high = [c & value[digit] if digit < len(value) else 0 for c, value in zip(candidates, values, strict=True)]
        counter = BitCounter()
        for plane in high:
            counter.add(plane)
        number = counter.total()
        too_few = less(number, wanted)
        wanted = _where(too_few, minus(masked(wanted, too_few), masked(number, too_few)), wanted)
        for i, plane in enumerate(high):
            settled = plane & too_few
            kept[i] |= settled
            # Of the candidates: those without the digit where too few have it, those with it elsewhere.
            candidates[i] = ((candidates[i] & too_few) ^ settled) | (plane ^ settled)
    for i, candidate in enumerate(candidates):
        still = less([], wanted)
        if not still:
            break
        taken = candidate & still
        kept[i] |= taken
        wanted = minus(wanted, [taken])
    return kept


def ranks_steps(embedding: Embedding) -> Generator[Progress, None, Ranks]:
    """Count the rank of every node among those at its p. Yields progress."""
    packing, degrees = embedding.network.packing, Degrees(embedding)
    nodes = packing.pack(embedding.planes)
    ranks: Ranks = [[] for _ in nodes]
    for block in range(packing.n_blocks):
        members = nodes[block :: packing.n_blocks]
        values = variability_counts(embedding, degrees, block)
        degrees.forget(block)
        better = [BitCounter() for _ in members]
        for i, plane in enumerate(members):
            yield Progress((block + i / len(members)) / packing.n_blocks, "Ranking nodes")
            for j in range(i + 1, len(members)):
                both = plane & members[j]
                if both:
                    later_wins = both & less(values[i], values[j])
                    better[i].add(later_wins)
                    better[j].add(both ^ later_wins)
            ranks[i * packing.n_blocks + block] = better[i].total()
    return ranks


def ranked_below(embedding: Embedding, ranks: Ranks, k: int) -> NodeSet:
    """Return the nodes of rank less than ``k``: at each p the ``k`` best."""
    packing = embedding.network.packing
    return packing.unpack_all(
        node & less(rank, constant(k, node)) if rank else node * (k > 0)
        for node, rank in zip(packing.pack(embedding.planes), ranks, strict=True)
    )


def _where(plane: int, a: BitCounts, b: BitCounts) -> BitCounts:
    """``a`` (0 outside the plane) in the cells of a plane, ``b`` elsewhere."""
    n_digits = max(len(a), len(b))
    return [
        (a[digit] if digit < len(a) else 0) | (b[digit] & ~plane if digit < len(b) else 0) for digit in range(n_digits)
    ]
