"""What links lead to, and what leads to it: the closures of sets of nodes.

A round plays, for each heading, only what has come up since the round before; later groups of a round already see what
earlier ones have reached. Most of the time of embedding is spent here.
"""

from collections.abc import Generator

from ..progress import Progress
from .plane_network import PlaneNetwork, Planes, playable_from, played


def reached_from_steps(network: PlaneNetwork, seed: Planes, within: Planes) -> Generator[Progress, None, Planes]:
    """``seed``, a subset of ``within``, and all nodes that links lead to from it inside ``within``.

    Round after round, each fork plays the starts that have come up since its last turn: later forks of a round
    already see what earlier ones reached. Yields progress before every round.
    """
    n_headings, fold, tiled = network.n_headings, network.layout.fold, network.layout.tiled
    leaving, merge_of = network.leaving, network.merge_of
    unreached = [inside ^ start for inside, start in zip(within, seed, strict=True)]
    unplayed = [network.layout.ground] * (len(network.members_of_fork) * n_headings)
    reached = network.merged(seed)
    asks = [sum(1 << merge for merge in merges) for merges in network.merges_before]
    # For each heading the merges, as bits, that have been reached in more cells: in this round, and in the last.
    grown = _present(network, reached)
    n_rounds = 0
    while any(grown):
        n_rounds += 1
        yield _progress(network, n_rounds)
        before, grown = grown, [0] * n_headings
        for fork, (members, merges, ask) in enumerate(
            zip(network.members_of_fork, network.merges_before, asks, strict=True)
        ):
            for heading in range(n_headings):
                if not (before[heading] | grown[heading]) & ask:
                    continue
                starts = 0
                for merge in merges:
                    starts |= reached[merge * n_headings + heading]
                starts &= unplayed[fork * n_headings + heading]
                if not starts:
                    continue
                unplayed[fork * n_headings + heading] ^= starts
                for segment in members:
                    merge = merge_of[segment]
                    for turned, ways in leaving[segment * n_headings + heading]:
                        arrived = played(starts, ways)
                        if tiled:
                            arrived = fold(arrived)
                        fresh = arrived & unreached[segment * n_headings + turned]
                        if fresh:
                            unreached[segment * n_headings + turned] ^= fresh
                            reached[merge * n_headings + turned] |= fresh
                            grown[turned] |= 1 << merge
    return [inside ^ left for inside, left in zip(within, unreached, strict=True)]


def reaching_steps(network: PlaneNetwork, seed: Planes, within: Planes) -> Generator[Progress, None, Planes]:
    """``seed``, a subset of ``within``, and all nodes from which links lead to it inside ``within``."""
    n_headings, layout = network.n_headings, network.layout
    unreached = [inside ^ start for inside, start in zip(within, seed, strict=True)]
    unmerged = [layout.ground] * (len(network.members_of_merge) * n_headings)
    able = [0] * (len(network.members_of_fork) * n_headings)
    asks = [sum(1 << fork for fork in forks) for forks in network.forks_after]
    # For each heading the forks, as bits, that have become able in more cells: in this round, and in the last.
    grown = [0] * n_headings

    def reach(segment: int, heading: int, ends: int, grown: list[int]) -> None:
        fork, ends = network.fork_of[segment], layout.extend(ends)
        for start_heading, ways in network.entering[segment * n_headings + heading]:
            start = fork * n_headings + start_heading
            more = able[start] | playable_from(ends, ways)
            if more != able[start]:
                able[start] = more
                grown[start_heading] |= 1 << fork

    for index, ends in enumerate(seed):
        if ends:
            reach(*divmod(index, n_headings), ends, grown)
    n_rounds = 0
    while any(grown):
        n_rounds += 1
        yield _progress(network, n_rounds)
        before, grown = grown, [0] * n_headings
        # Segments follow their clips in ascending order; backwards, those that follow come first.
        for merge in range(len(asks) - 1, -1, -1):
            for heading in range(n_headings):
                if not (before[heading] | grown[heading]) & asks[merge]:
                    continue
                merged = 0
                for fork in network.forks_after[merge]:
                    merged |= able[fork * n_headings + heading]
                merged &= unmerged[merge * n_headings + heading]
                if not merged:
                    continue
                unmerged[merge * n_headings + heading] ^= merged
                for segment in network.members_of_merge[merge]:
                    fresh = merged & unreached[segment * n_headings + heading]
                    if fresh:
                        unreached[segment * n_headings + heading] ^= fresh
                        reach(segment, heading, fresh, grown)
    return [inside ^ left for inside, left in zip(within, unreached, strict=True)]


def _present(network: PlaneNetwork, planes: Planes) -> list[int]:
    """For each heading the groups, as bits, of those whose planes are not empty."""
    n_groups = len(planes) // network.n_headings
    return [
        sum(1 << group for group in range(n_groups) if planes[group * network.n_headings + heading])
        for heading in range(network.n_headings)
    ]


def _progress(network: PlaneNetwork, n_rounds: int) -> Progress:
    """How far a closure is: the ground is crossed in some rounds, and then corners are left."""
    expected = (network.layout.nx + network.layout.ny) / max(network.layout.reach_x, network.layout.reach_y, 1)
    return Progress(n_rounds / (n_rounds + expected), "Following links")
