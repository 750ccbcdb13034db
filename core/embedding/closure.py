"""Closures of sets of nodes: all that links lead to, and all that leads to them.

A round plays, for each heading, only what has come up since the round before; later groups of a round already see what
earlier ones have reached. Most of the time of embedding is spent here.
"""

from collections.abc import Generator, Sequence

from ..progress import Progress
from .network import StepNetwork, image_of, preimage_of
from .node_set import NodeSet


def reached_from_steps(network: StepNetwork, seed: NodeSet, within: NodeSet) -> Generator[Progress, None, NodeSet]:
    """Return ``seed``, a subset of ``within``, and all nodes that links lead to from it inside ``within``.

    Round after round, each entry group plays the starts that have come up since its last turn: later groups of a round
    already see what earlier ones reached. Yields progress before every round.
    """
    n_headings, fold, tiled = network.n_headings, network.layout.fold, network.layout.tiled
    leaving, exit_group_of = network.leaving, network.exit_group_of
    unreached = [inside ^ start for inside, start in zip(within.planes, seed.planes, strict=True)]
    unplayed = [network.layout.ground] * (len(network.entry_groups) * n_headings)
    reached = network.by_exit_group(seed.planes)
    asks = [sum(1 << group for group in before) for before in network.exit_groups_before]
    # For each heading the exit groups, as bits, that have been reached in more cells: in this round, and in the last.
    grown = _present(network, reached)
    n_rounds = 0
    while any(grown):
        n_rounds += 1
        yield _progress(network, n_rounds)
        before, grown = grown, [0] * n_headings
        for entry, (members, exits, ask) in enumerate(
            zip(network.entry_groups, network.exit_groups_before, asks, strict=True)
        ):
            for heading in range(n_headings):
                if not (before[heading] | grown[heading]) & ask:
                    continue
                starts = 0
                for group in exits:
                    starts |= reached[group * n_headings + heading]
                starts &= unplayed[entry * n_headings + heading]
                if not starts:
                    continue
                unplayed[entry * n_headings + heading] ^= starts
                for segment in members:
                    group = exit_group_of[segment]
                    for turned, moves in leaving[segment * n_headings + heading]:
                        arrived = image_of(starts, moves)
                        if tiled:
                            arrived = fold(arrived)
                        fresh = arrived & unreached[segment * n_headings + turned]
                        if fresh:
                            unreached[segment * n_headings + turned] ^= fresh
                            reached[group * n_headings + turned] |= fresh
                            grown[turned] |= 1 << group
    return NodeSet(tuple(inside ^ left for inside, left in zip(within.planes, unreached, strict=True)))


def reaching_steps(network: StepNetwork, seed: NodeSet, within: NodeSet) -> Generator[Progress, None, NodeSet]:
    """Return ``seed``, a subset of ``within``, and all nodes from which links lead to it inside ``within``."""
    n_headings, layout = network.n_headings, network.layout
    unreached = [inside ^ start for inside, start in zip(within.planes, seed.planes, strict=True)]
    unused = [layout.ground] * (len(network.exit_groups) * n_headings)
    able = [0] * (len(network.entry_groups) * n_headings)
    asks = [sum(1 << group for group in after) for after in network.entry_groups_after]
    # For each heading the entry groups, as bits, that can be played from more cells: in this round, and in the last.
    grown = [0] * n_headings

    def reach(segment: int, heading: int, ends: int, grown: list[int]) -> None:
        group, ends = network.entry_group_of[segment], layout.extend(ends)
        for start_heading, moves in network.entering[segment * n_headings + heading]:
            start = group * n_headings + start_heading
            more = able[start] | preimage_of(ends, moves)
            if more != able[start]:
                able[start] = more
                grown[start_heading] |= 1 << group

    for index, ends in enumerate(seed.planes):
        if ends:
            reach(*divmod(index, n_headings), ends, grown)
    n_rounds = 0
    while any(grown):
        n_rounds += 1
        yield _progress(network, n_rounds)
        before, grown = grown, [0] * n_headings
        # Segments follow their clips in ascending order; backwards, those that follow come first.
        for group in range(len(asks) - 1, -1, -1):
            for heading in range(n_headings):
                if not (before[heading] | grown[heading]) & asks[group]:
                    continue
                starts = 0
                for entry in network.entry_groups_after[group]:
                    starts |= able[entry * n_headings + heading]
                starts &= unused[group * n_headings + heading]
                if not starts:
                    continue
                unused[group * n_headings + heading] ^= starts
                for segment in network.exit_groups[group]:
                    fresh = starts & unreached[segment * n_headings + heading]
                    if fresh:
                        unreached[segment * n_headings + heading] ^= fresh
                        reach(segment, heading, fresh, grown)
    return NodeSet(tuple(inside ^ left for inside, left in zip(within.planes, unreached, strict=True)))


def _present(network: StepNetwork, planes: Sequence[int]) -> list[int]:
    """Return, for each heading, the groups, as bits, of those whose planes are not empty."""
    n_groups = len(planes) // network.n_headings
    return [
        sum(1 << group for group in range(n_groups) if planes[group * network.n_headings + heading])
        for heading in range(network.n_headings)
    ]


def _progress(network: StepNetwork, n_rounds: int) -> Progress:
    """Return how far a closure is: the ground is crossed in some rounds, and then corners are left."""
    return Progress(n_rounds / (n_rounds + network.layout.expected_rounds), "Following links")
