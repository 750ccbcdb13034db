"""The links of an unrolled motion graph as moves of whole bit-planes.

Nodes are (cell, heading, segment). A set of nodes is a list with one *bundle* for each segment: the planes of all
headings side by side in one integer. What concerns all headings alike - "whoever arrived by a parent may start a
child" - is then one operation for a segment, not one for each heading.

A link's validity depends on the cell it starts from and on the segment that is played, not on the one before. The
*starts* of a segment are therefore the arrivals of all its parents, ORed. Segments with the same parents share their
starts (a *fork*), and parents with the same children are ORed only once (a *merge*): cutting makes many of both,
because segments that end in alike poses can all go on in the same ways.
"""

from collections import deque
from collections.abc import Iterable

import numpy as np

from .unroll import Unrolling

#: A set of nodes: one bundle of planes for each segment.
Nodes = list[int]


class StepNetwork:
    """The one-step links of an unrolling, forwards and backwards.

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
        self.plane_bytes = (self.layout.n_bits + 7) // 8

        follows = np.zeros((n_segments, n_segments), dtype=bool)
        follows[links[:, 0], links[:, 1]] = True
        self.children = [np.flatnonzero(row).tolist() for row in follows]
        self.parents = [np.flatnonzero(column).tolist() for column in follows.T]
        # merge_of[segment], fork_of[segment]: segments with the same children, and with the same parents.
        rows, self.merge_of = _groups(follows)
        columns, self.fork_of = _groups(follows.T)
        between = follows[np.ix_(rows, columns)]
        self.forks_after = [np.flatnonzero(row).tolist() for row in between]
        self.merges_before = [np.flatnonzero(column).tolist() for column in between.T]
        self.members_of_merge = _members(self.merge_of, len(rows))
        self.members_of_fork = _members(self.fork_of, len(columns))

        # moves[segment]: (start heading, destination heading, shift, valid starts)
        self.moves: list[list[tuple[int, int, int, int]]] = [[] for _ in range(n_segments)]
        shifts = self.layout.shift(stencils.dx, stencils.dy)
        rows = zip(
            stencils.segment.tolist(),
            stencils.heading.tolist(),
            stencils.destination_heading.tolist(),
            shifts.tolist(),
            unrolling.valid,
            strict=True,
        )
        for segment, heading, turned, shift, valid in rows:
            if valid:
                self.moves[segment].append((heading, turned, shift, valid))

    def bundle(self, planes: Iterable[int]) -> int:
        """The planes of all headings in one integer."""
        size = self.plane_bytes
        return int.from_bytes(b"".join([plane.to_bytes(size, "little") for plane in planes]), "little")

    def planes(self, bundle: int) -> list[int]:
        """The plane of each heading."""
        size = self.plane_bytes
        raw = bundle.to_bytes(size * self.n_headings, "little")
        return [int.from_bytes(raw[i : i + size], "little") for i in range(0, len(raw), size)]

    def everywhere(self) -> int:
        """The bundle of every cell of the ground in every heading."""
        return self.bundle([self.layout.ground] * self.n_headings)

    def nothing(self) -> Nodes:
        """The empty set."""
        return [0] * self.n_segments

    def arrivals(self, segment: int, starts: int) -> int:
        """Bundle of where ``segment`` can end when it is played from the ``starts``."""
        planes = self.planes(starts)
        landed = [0] * self.n_headings
        for heading, turned, shift, valid in self.moves[segment]:
            moving = planes[heading] & valid
            if moving:
                landed[turned] |= moving << shift if shift >= 0 else moving >> -shift
        if self.layout.tiled:
            landed = [self.layout.fold(plane) for plane in landed]
        return self.bundle(landed)

    def playable(self, segment: int, ends: int) -> int:
        """Bundle of the starts from which ``segment`` can end in one of ``ends``."""
        planes = self.planes(ends)
        if self.layout.tiled:
            planes = [self.layout.extend(plane) for plane in planes]
        able = [0] * self.n_headings
        for heading, turned, shift, valid in self.moves[segment]:
            there = planes[turned]
            if there:
                able[heading] |= valid & (there >> shift if shift >= 0 else there << -shift)
        return self.bundle(able)

    def image(self, nodes: Nodes) -> Nodes:
        """All nodes that one link leads to from ``nodes``."""
        merged = [_union(nodes[s] for s in members) for members in self.members_of_merge]
        starts = [_union(merged[m] for m in before) for before in self.merges_before]
        return [self.arrivals(segment, starts[fork]) for segment, fork in enumerate(self.fork_of)]

    def preimage(self, nodes: Nodes) -> Nodes:
        """All nodes with a link that leads to one of ``nodes``."""
        able = [_union(self.playable(s, nodes[s]) for s in members) for members in self.members_of_fork]
        merged = [_union(able[f] for f in after) for after in self.forks_after]
        return [merged[merge] for merge in self.merge_of]

    def trim(self, nodes: Nodes) -> Nodes:
        """``nodes`` without those that have no link from, or then none to, the rest: once over."""
        nodes = intersection(nodes, self.image(nodes))
        return intersection(nodes, self.preimage(nodes))

    def reached_from(self, seed: Nodes, within: Nodes) -> Nodes:
        """``seed``, a subset of ``within``, and all nodes that links lead to from it inside ``within``."""
        unreached = difference(within, seed)
        everywhere = self.everywhere()
        unplayed = [everywhere] * len(self.members_of_fork)
        pending = [0] * len(self.members_of_fork)
        queue: deque[int] = deque()

        def arrive(merge: int, fresh: int) -> None:
            for fork in self.forks_after[merge]:
                start = fresh & unplayed[fork]
                if start:
                    unplayed[fork] ^= start
                    if not pending[fork]:
                        queue.append(fork)
                    pending[fork] |= start

        for segment, nodes in enumerate(seed):
            if nodes:
                arrive(self.merge_of[segment], nodes)
        while queue:
            fork = queue.popleft()
            starts, pending[fork] = pending[fork], 0
            for segment in self.members_of_fork[fork]:
                fresh = self.arrivals(segment, starts) & unreached[segment]
                if fresh:
                    unreached[segment] ^= fresh
                    arrive(self.merge_of[segment], fresh)
        return difference(within, unreached)

    def reaching(self, seed: Nodes, within: Nodes) -> Nodes:
        """``seed``, a subset of ``within``, and all nodes from which links lead to it inside ``within``."""
        unreached = difference(within, seed)
        everywhere = self.everywhere()
        unable = [everywhere] * len(self.members_of_fork)
        unmerged = [everywhere] * len(self.members_of_merge)
        pending = list(seed)
        queue = deque(segment for segment, nodes in enumerate(seed) if nodes)
        while queue:
            segment = queue.popleft()
            ends, pending[segment] = pending[segment], 0
            fork = self.fork_of[segment]
            able = self.playable(segment, ends) & unable[fork]
            if not able:
                continue
            unable[fork] ^= able
            for merge in self.merges_before[fork]:
                merged = able & unmerged[merge]
                if not merged:
                    continue
                unmerged[merge] ^= merged
                for parent in self.members_of_merge[merge]:
                    fresh = merged & unreached[parent]
                    if fresh:
                        unreached[parent] ^= fresh
                        if not pending[parent]:
                            queue.append(parent)
                        pending[parent] |= fresh
        return difference(within, unreached)


def count(nodes: Nodes) -> int:
    """Number of nodes in a set."""
    return sum(bundle.bit_count() for bundle in nodes)


def intersection(a: Nodes, b: Nodes) -> Nodes:
    return [x & y for x, y in zip(a, b, strict=True)]


def difference(a: Nodes, b: Nodes) -> Nodes:
    """The nodes of ``a`` that are not in ``b``, a subset of ``a``."""
    return [x ^ y for x, y in zip(a, b, strict=True)]


def _union(bundles: Iterable[int]) -> int:
    union = 0
    for bundle in bundles:
        union |= bundle
    return union


def _groups(rows: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Index of the first row of each kind, and the kind of each row."""
    _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, kind.ravel().tolist()


def _members(group_of: list[int], n_groups: int) -> list[list[int]]:
    members: list[list[int]] = [[] for _ in range(n_groups)]
    for member, group in enumerate(group_of):
        members[group].append(member)
    return members
