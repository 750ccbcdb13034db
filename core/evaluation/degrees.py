"""In-degrees and out-degrees of the nodes of an embedding, as tallies: heading block by heading block, segment by
segment, without an array over all nodes."""

from ..embedding.embedding import Embedding
from .bit_counter import BitCounter, BitCounts, masked


class Degrees:
    """How many links end and start at each node, as tallies of bundles (see ``StepNetwork``).

    A link from (p0, c0) to (p, c) counts once for each parent c0 alive at p0. What segments share is added up only
    once: the parents alive at a start (the same for a fork), the links that go on (the same for a merge).
    """

    def __init__(self, embedding: Embedding):
        self._embedding = embedding
        self._network = embedding.network
        self._nodes = embedding.nodes
        self._parents_alive: dict[int, list[BitCounts]] = {}
        self._landing: dict[tuple[int, int], BitCounts] = {}
        self._outgoing: dict[tuple[int, int], BitCounts] = {}
        self._ends: list[int] | None = None

    def incoming(self, segment: int, block: int) -> BitCounts:
        """In-degree of the nodes of a segment and a block of headings."""
        network = self._network
        here = self._nodes[segment * network.n_blocks + block]
        if not here:
            return []
        alive = self._alive(network.fork_of[segment])
        fold = network.layout.fold
        columns = [BitCounter() for _ in range(network.bundled)]
        for place, heading, shift, valid in network.arriving[segment * network.n_blocks + block]:
            for digit, parents in enumerate(alive[heading]):
                leaving = parents & valid
                if leaving:
                    columns[place].add(fold(leaving << shift if shift >= 0 else leaving >> -shift), digit)
        return masked(self._bundled([column.total() for column in columns]), here)

    def outgoing(self, merge: int, block: int) -> BitCounts:
        """Out-degree of the nodes of every segment of a merge in a block of headings, were there a node everywhere."""
        tally = self._outgoing.get((merge, block))
        if tally is None:
            columns = BitCounter()
            for fork in self._network.forks_after[merge]:
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
            network = self._network
            parents = [p for merge in network.merges_before[fork] for p in network.members_of_merge[merge]]
            tallies: list[BitCounts] = []
            for block in range(network.n_blocks):
                columns = BitCounter()
                for parent in parents:
                    columns.add(self._nodes[parent * network.n_blocks + block])
                digits = [network.planes(digit) for digit in columns.total()]
                tallies += [[digit[place] for digit in digits] for place in range(network.bundled)]
            self._parents_alive[fork] = tallies
        return self._parents_alive[fork]

    def _landings(self, fork: int, block: int) -> BitCounts:
        """How many nodes the segments of a fork lead to from each cell and heading of a block."""
        if (fork, block) not in self._landing:
            network, layout = self._network, self._network.layout
            if self._ends is None:
                self._ends = [layout.extend(plane) for plane in self._embedding.planes]
            columns = [BitCounter() for _ in range(network.bundled)]
            for segment in network.members_of_fork[fork]:
                first = segment * network.n_headings
                for place, turned, shift, valid in network.moves[segment * network.n_blocks + block]:
                    there = self._ends[first + turned]
                    columns[place].add(valid & (there >> shift if shift >= 0 else there << -shift))
            self._landing[fork, block] = self._bundled([column.total() for column in columns])
        return self._landing[fork, block]

    def _bundled(self, tallies: list[BitCounts]) -> BitCounts:
        """One tally for each heading of a block, as one tally of bundles."""
        if len(tallies) == 1:
            return tallies[0]
        n_digits = max(len(tally) for tally in tallies)
        padded = [tally + [0] * (n_digits - len(tally)) for tally in tallies]
        return [self._network.bundles([tally[digit] for tally in padded])[0] for digit in range(n_digits)]
