"""In-degrees and out-degrees of the nodes of an embedding, as tallies: heading block by heading block, segment by
segment, without an array over all nodes."""

from ..embedding.embedding import Embedding
from .bit_counter import BitCounter, BitCounts, masked


class Degrees:
    """How many links end and start at each node, as tallies of blocks (see :class:`.HeadingPacking`).

    A link from (p0, c0) to (p, c) counts once for each parent c0 alive at p0. What segments share is added up only
    once: the parents alive at a start (the same for a fork), the links that go on (the same for a merge).
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
        """In-degree of the nodes of a segment and a block of headings."""
        network, packing = self._network, self._packing
        here = self._nodes[segment * packing.n_blocks + block]
        if not here:
            return []
        alive = self._alive(network.entry_group_of[segment])
        fold = network.layout.fold
        tallies = []
        for entering in self._of_block(network.entering, segment, block):
            columns = BitCounter()
            for heading, moves in entering:
                for digit, parents in enumerate(alive[heading]):
                    for shift, valid in moves:
                        leaving = parents & valid
                        if leaving:
                            columns.add(fold(leaving << shift if shift >= 0 else leaving >> -shift), digit)
            tallies.append(columns.total())
        return masked(self._packed(tallies), here)

    def outgoing(self, merge: int, block: int) -> BitCounts:
        """Out-degree of the nodes of every segment of a merge in a block of headings, were there a node everywhere."""
        tally = self._outgoing.get((merge, block))
        if tally is None:
            columns = BitCounter()
            for fork in self._network.entry_groups_after[merge]:
                columns.add_counts(self._landings(fork, block))
            tally = self._outgoing[merge, block] = columns.total()
        return tally

    def forget(self, block: int) -> None:
        """Let go of what :meth:`outgoing` has kept of a block; for large grounds, once it is done with."""
        self._landing = {key: tally for key, tally in self._landing.items() if key[1] != block}
        self._outgoing = {key: tally for key, tally in self._outgoing.items() if key[1] != block}

    def _alive(self, fork: int) -> list[BitCounts]:
        """For each heading, how many of the parents of a fork have a node at each cell."""
        if fork not in self._parents_alive:
            network, packing = self._network, self._packing
            parents = [p for merge in network.exit_groups_before[fork] for p in network.exit_groups[merge]]
            tallies: list[BitCounts] = []
            for block in range(packing.n_blocks):
                columns = BitCounter()
                for parent in parents:
                    columns.add(self._nodes[parent * packing.n_blocks + block])
                digits = [packing.unpack(digit) for digit in columns.total()]
                tallies += [[digit[place] for digit in digits] for place in range(packing.headings)]
            self._parents_alive[fork] = tallies
        return self._parents_alive[fork]

    def _landings(self, fork: int, block: int) -> BitCounts:
        """How many nodes the segments of a fork lead to from each cell and heading of a block."""
        if (fork, block) not in self._landing:
            network, layout = self._network, self._network.layout
            if self._ends is None:
                self._ends = [layout.extend(plane) for plane in self._embedding.planes]
            columns = [BitCounter() for _ in range(self._packing.headings)]
            for segment in network.entry_groups[fork]:
                first = segment * network.n_headings
                for column, leaving in zip(columns, self._of_block(network.leaving, segment, block), strict=True):
                    for turned, moves in leaving:
                        there = self._ends[first + turned]
                        for shift, valid in moves:
                            column.add(valid & (there >> shift if shift >= 0 else there << -shift))
            self._landing[fork, block] = self._packed([column.total() for column in columns])
        return self._landing[fork, block]

    def _of_block(self, by_plane: list, segment: int, block: int) -> list:
        """The items of the planes of a segment and a block of headings."""
        first = segment * self._network.n_headings + block * self._packing.headings
        return by_plane[first : first + self._packing.headings]

    def _packed(self, tallies: list[BitCounts]) -> BitCounts:
        """One tally for each heading of a block, as one tally of the block."""
        if len(tallies) == 1:
            return tallies[0]
        n_digits = max(len(tally) for tally in tallies)
        padded = [tally + [0] * (n_digits - len(tally)) for tally in tallies]
        return [self._packing.pack([tally[digit] for tally in padded])[0] for digit in range(n_digits)]
