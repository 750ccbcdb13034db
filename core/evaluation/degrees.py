"""In-degrees and out-degrees of the nodes of an embedding as bit-sliced counts, block of headings by block of headings
and segment by segment: there is no array over all nodes."""

from collections.abc import Sequence

from ..embedding.embedding import Embedding
from .bit_counter import BitCounter, BitCounts, digit_of, masked


class Degrees:
    """Numbers of links that end and start at each node, as counts over a block (see :class:`.HeadingPacking`).

    A link from (p0, c0) to (p, c) counts once for each parent c0 alive at p0. What segments share is added up only
    once: the parents alive at a start (the same for an entry group), the links that go on (the same for an exit group).
    """

    def __init__(self, embedding: Embedding):
        self._embedding = embedding
        self._network = embedding.network
        self._packing = embedding.network.packing
        self._nodes = self._packing.pack(embedding.planes)
        self._parents_alive: dict[int, list[BitCounts]] = {}
        self._landing: dict[tuple[int, int], BitCounts] = {}
        self._outgoing: dict[tuple[int, int], BitCounts] = {}
        self._ends: list[int] | None = None

    def incoming(self, segment: int, block: int) -> BitCounts:
        """Count the links that end at the nodes of a segment and a block of headings."""
        network, packing = self._network, self._packing
        here = self._nodes[segment * packing.n_blocks + block]
        if not here:
            return []
        alive = self._alive(network.entry_group_of[segment])
        fold = network.layout.fold
        arriving = []
        for entering in self._of_block(network.entering, segment, block):
            counter = BitCounter()
            for heading, moves in entering:
                for digit, parents in enumerate(alive[heading]):
                    for shift, valid in moves:
                        leaving = parents & valid
                        if leaving:
                            counter.add(fold(leaving << shift if shift >= 0 else leaving >> -shift), digit)
            arriving.append(counter.total())
        return masked(self._packed(arriving), here)

    def outgoing(self, group: int, block: int) -> BitCounts:
        """Count the links that start from each place of a block, for a node there of any segment of an exit group."""
        if (group, block) not in self._outgoing:
            counter = BitCounter()
            for entry_group in self._network.entry_groups_after[group]:
                counter.add_counts(self._landings(entry_group, block))
            self._outgoing[group, block] = counter.total()
        return self._outgoing[group, block]

    def forget(self, block: int) -> None:
        """Let go of what :meth:`outgoing` has kept of a block; for large grounds, once it is done with."""
        for kept in (self._landing, self._outgoing):
            for key in [key for key in kept if key[1] == block]:
                del kept[key]

    def _alive(self, group: int) -> list[BitCounts]:
        """Count, for each heading, the parents of an entry group that have a node at each cell."""
        if group not in self._parents_alive:
            network, packing = self._network, self._packing
            alive: list[BitCounts] = []
            for block in range(packing.n_blocks):
                counter = BitCounter()
                for parent in network.parents[network.entry_groups[group][0]]:
                    counter.add(self._nodes[parent * packing.n_blocks + block])
                digits = [packing.unpack(digit) for digit in counter.total()]
                alive += [[digit[place] for digit in digits] for place in range(packing.headings)]
            self._parents_alive[group] = alive
        return self._parents_alive[group]

    def _landings(self, group: int, block: int) -> BitCounts:
        """Count the nodes that the segments of an entry group lead to from each cell and heading of a block."""
        if (group, block) not in self._landing:
            network, layout = self._network, self._network.layout
            if self._ends is None:
                self._ends = [layout.extend(plane) for plane in self._embedding.planes]
            counters = [BitCounter() for _ in range(self._packing.headings)]
            for segment in network.entry_groups[group]:
                first = segment * network.n_headings
                for counter, leaving in zip(counters, self._of_block(network.leaving, segment, block), strict=True):
                    for turned, moves in leaving:
                        there = self._ends[first + turned]
                        for shift, valid in moves:
                            counter.add(valid & (there >> shift if shift >= 0 else there << -shift))
            self._landing[group, block] = self._packed([counter.total() for counter in counters])
        return self._landing[group, block]

    def _of_block(self, by_plane: Sequence, segment: int, block: int) -> Sequence:
        """Return the items of the planes of a segment and a block of headings."""
        first = segment * self._network.n_headings + block * self._packing.headings
        return by_plane[first : first + self._packing.headings]

    def _packed(self, by_heading: list[BitCounts]) -> BitCounts:
        """Pack the counts of each heading of a block into those of the block."""
        if len(by_heading) == 1:
            return by_heading[0]
        n_digits = max(map(len, by_heading))
        return [self._packing.pack([digit_of(n, digit) for n in by_heading])[0] for digit in range(n_digits)]
