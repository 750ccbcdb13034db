"""The largest strongly connected component of an unrolled motion graph, without storing a link.

Nodes are (cell, heading, segment). All nodes of one segment and heading share a plane, indexed
``segment * n_headings + heading``. A link's validity depends on the cell it starts from and on the segment that is
played, not on the one before: the *starts* of a segment are the arrivals of all its parents, ORed, and a step moves
the starts of one segment and heading along each of its stencils.

The search is forward-backward: everything that a pivot reaches, and what of that reaches the pivot, is the pivot's
component; every other component lies wholly in one of the two rests, which are searched only while they hold at
least as many nodes as the best component found.
"""

from collections import deque
from collections.abc import Generator

import numpy as np

from ..progress import Progress
from .unroll import Unrolling

Planes = list[int]


class StepNetwork:
    """The links of an unrolling as moves of whole planes, forwards and backwards.

    Parameters
    ----------
    unrolling : Unrolling
    links : (L, 2) int array
        Links of the motion graph.
    n_segments : int
    """

    def __init__(self, unrolling: Unrolling, links: np.ndarray, n_segments: int):
        stencils = unrolling.stencils
        self.layout = unrolling.layout
        self.n_headings = stencils.n_headings
        self.n_segments = n_segments
        self.n_planes = n_segments * self.n_headings
        self.children: list[list[int]] = [[] for _ in range(n_segments)]
        self.parents: list[list[int]] = [[] for _ in range(n_segments)]
        for before, after in np.asarray(links).tolist():
            self.children[before].append(after)
            self.parents[after].append(before)
        # moves_from[start plane]: (shift, arrival plane, valid starts); moves_to[arrival]: (shift, start plane, valid)
        self.moves_from: list[list[tuple[int, int, int]]] = [[] for _ in range(self.n_planes)]
        self.moves_to: list[list[tuple[int, int, int]]] = [[] for _ in range(self.n_planes)]
        shifts = self.layout.shift(stencils.dx, stencils.dy).tolist()
        starts = (stencils.segment * self.n_headings + stencils.heading).tolist()
        arrivals = (stencils.segment * self.n_headings + stencils.destination_heading).tolist()
        for shift, start, arrival, valid in zip(shifts, starts, arrivals, unrolling.valid, strict=True):
            if valid:
                self.moves_from[start].append((shift, arrival, valid))
                self.moves_to[arrival].append((shift, start, valid))

    def count(self, planes: Planes) -> int:
        """Number of nodes in a set."""
        return sum(plane.bit_count() for plane in planes)

    def starts(self, nodes: Planes) -> Planes:
        """For each segment and heading, the cells where a node of ``nodes`` stands that may play it."""
        return [
            _union(nodes[parent * self.n_headings + heading] for parent in self.parents[segment])
            for segment in range(self.n_segments)
            for heading in range(self.n_headings)
        ]

    def image(self, nodes: Planes) -> Planes:
        """All nodes that one link leads to from ``nodes``."""
        landed = [0] * self.n_planes
        for start, plane in enumerate(self.starts(nodes)):
            if plane:
                for shift, arrival, valid in self.moves_from[start]:
                    moving = plane & valid
                    landed[arrival] |= moving << shift if shift >= 0 else moving >> -shift
        return [self.layout.fold(plane) for plane in landed]

    def playable(self, nodes: Planes) -> Planes:
        """For each segment and heading, the cells from which playing it can lead to one of ``nodes``."""
        able = [0] * self.n_planes
        for arrival, plane in enumerate(nodes):
            if plane:
                extended = self.layout.extend(plane)
                for shift, start, valid in self.moves_to[arrival]:
                    able[start] |= valid & (extended >> shift if shift >= 0 else extended << -shift)
        return able

    def preimage(self, nodes: Planes) -> Planes:
        """All nodes with a link that leads to one of ``nodes``."""
        able = self.playable(nodes)
        return [
            _union(able[child * self.n_headings + heading] for child in self.children[segment])
            for segment in range(self.n_segments)
            for heading in range(self.n_headings)
        ]

    def trim(self, nodes: Planes, rounds: int) -> Planes:
        """``nodes`` without those that have no link from, or none to, the rest; at most ``rounds`` times over."""
        for _ in range(rounds):
            before = self.count(nodes)
            nodes = [a & b for a, b in zip(nodes, self.image(nodes), strict=True)]
            nodes = [a & b for a, b in zip(nodes, self.preimage(nodes), strict=True)]
            if self.count(nodes) == before:
                break
        return nodes

    def reached_from(self, seed: Planes, within: Planes) -> Planes:
        """``seed`` and all nodes of ``within`` to which links lead from it through nodes of ``within``."""
        n_headings, fold = self.n_headings, self.layout.fold
        unreached = [a & ~b for a, b in zip(within, seed, strict=True)]
        unplayed = [self.layout.ground] * self.n_planes
        pending, queue = [0] * self.n_planes, deque()

        def arrive(node: int, plane: int) -> None:
            segment, heading = divmod(node, n_headings)
            for child in self.children[segment]:
                start = child * n_headings + heading
                fresh = plane & unplayed[start]
                if fresh:
                    unplayed[start] ^= fresh
                    if not pending[start]:
                        queue.append(start)
                    pending[start] |= fresh

        for node, plane in enumerate(seed):
            if plane:
                arrive(node, plane)
        while queue:
            start = queue.popleft()
            plane, pending[start] = pending[start], 0
            for shift, arrival, valid in self.moves_from[start]:
                moving = plane & valid
                if moving:
                    fresh = fold(moving << shift if shift >= 0 else moving >> -shift) & unreached[arrival]
                    if fresh:
                        unreached[arrival] ^= fresh
                        arrive(arrival, fresh)
        return [(a | b) & ~c for a, b, c in zip(within, seed, unreached, strict=True)]

    def reaching(self, seed: Planes, within: Planes) -> Planes:
        """``seed`` and all nodes of ``within`` from which links lead to it through nodes of ``within``."""
        n_headings, extend = self.n_headings, self.layout.extend
        unreached = [a & ~b for a, b in zip(within, seed, strict=True)]
        unplayed = [self.layout.ground] * self.n_planes
        pending, queue = list(seed), deque(node for node, plane in enumerate(seed) if plane)
        while queue:
            arrival = queue.popleft()
            plane, pending[arrival] = extend(pending[arrival]), 0
            for shift, start, valid in self.moves_to[arrival]:
                able = valid & unplayed[start] & (plane >> shift if shift >= 0 else plane << -shift)
                if able:
                    unplayed[start] ^= able
                    segment, heading = divmod(start, n_headings)
                    for parent in self.parents[segment]:
                        node = parent * n_headings + heading
                        fresh = able & unreached[node]
                        if fresh:
                            unreached[node] ^= fresh
                            if not pending[node]:
                                queue.append(node)
                            pending[node] |= fresh
        return [(a | b) & ~c for a, b, c in zip(within, seed, unreached, strict=True)]

    def pivot(self, nodes: Planes) -> Planes:
        """A single node of ``nodes`` that is likely to lie in its largest component: on a cell with many of them."""
        degree = [len(self.parents[s]) * len(self.children[s]) for s in range(self.n_segments)]
        order = sorted(
            (node for node, plane in enumerate(nodes) if plane),
            key=lambda node: (-degree[node // self.n_headings] * nodes[node].bit_count(), node),
        )
        shared = nodes[order[0]]
        for node in order[1:]:
            shared = (shared & nodes[node]) or shared
        chosen = [0] * self.n_planes
        chosen[order[0]] = shared & -shared
        return chosen

    def has_cycle(self, component: Planes) -> bool:
        """Whether a strongly connected set is more than one node that no link joins to itself."""
        return self.count(component) > 1 or any(a & b for a, b in zip(component, self.image(component), strict=True))

    def first_node(self, planes: Planes) -> tuple[int, int, int]:
        """(bit, heading, segment) of the lowest node of a set, in order of x, y, heading, segment."""
        lowest = min((plane & -plane).bit_length() for plane in planes if plane)
        bit = 1 << (lowest - 1)
        heading, segment = min(
            (node % self.n_headings, node // self.n_headings) for node, plane in enumerate(planes) if plane & bit
        )
        return lowest, heading, segment


def _union(planes) -> int:
    union = 0
    for plane in planes:
        union |= plane
    return union


def largest_component_steps(network: StepNetwork) -> Generator[Progress, None, Planes]:
    """The nodes of the largest strongly connected component; yields progress, returns planes (all 0 if no cycle).

    Of components of equal size, the one that holds the lowest node in order of x, y, heading, segment.
    """
    everything = network.image([network.layout.ground] * network.n_planes)
    best, best_size = [0] * network.n_planes, 0
    rests = [everything]
    total = max(network.count(everything), 1)
    while rests:
        rests.sort(key=network.count)
        left = network.count(rests[-1])
        yield Progress(1 - left / total, "Finding the largest strongly connected component")
        nodes = rests.pop()
        if left < max(best_size, 1):
            break
        nodes = network.trim(nodes, rounds=3)
        if network.count(nodes) < max(best_size, 1):
            continue
        pivot = network.pivot(nodes)
        reached = network.reached_from(pivot, nodes)
        yield Progress(1 - left / total, "Finding the largest strongly connected component")
        component = network.reaching(pivot, reached)
        size = network.count(component)
        if network.has_cycle(component) and (
            size > best_size or (size == best_size and network.first_node(component) < network.first_node(best))
        ):
            best, best_size = component, size
        rests.append([a & ~b for a, b in zip(reached, component, strict=True)])
        rests.append([a & ~b for a, b in zip(nodes, reached, strict=True)])
    return best
