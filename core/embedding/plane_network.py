"""The one-step links of an unrolled motion graph as moves of bit-planes, and what they lead to.

Nodes are (cell, heading, segment). A set of nodes is a list of planes, one for each segment and heading. A link's
validity depends on the cell it starts from and on the segment that is played, not on the one before. The *starts* of a
segment are therefore the arrivals of all its parents, ORed. Segments with the same parents share their starts (a
*fork*), and parents with the same children are ORed only once (a *merge*): cutting makes many of both, because segments
that end in alike poses can all go on in the same ways.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from .unroll import Unrolling

#: A set of nodes: planes, indexed segment * n_headings + heading.
Planes = list[int]

#: Ways from one plane into another: by how many bits, and from which cells.
Ways = list[tuple[int, int]]


class PlaneNetwork:
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
        self.stencils, self.layout = stencils, unrolling.layout
        self.n_headings = stencils.n_headings
        self.n_segments = n_segments

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

        # leaving[plane]: the destination headings of its segment from its heading, and the ways there; entering[plane]:
        # the start headings from which its segment ends in its heading, and the same ways.
        leaving: list[dict[int, Ways]] = [{} for _ in range(n_segments * self.n_headings)]
        entering: list[dict[int, Ways]] = [{} for _ in range(n_segments * self.n_headings)]
        for segment, heading, turned, shift, valid in self._with_stencils(unrolling.valid):
            first = segment * self.n_headings
            leaving[first + heading].setdefault(turned, []).append((shift, valid))
            entering[first + turned].setdefault(heading, []).append((shift, valid))
        self.leaving = [list(ways.items()) for ways in leaving]
        self.entering = [list(ways.items()) for ways in entering]

    def _with_stencils(self, starts: Sequence[int]) -> Iterator[tuple[int, int, int, int, int]]:
        """For each stencil that has any ``starts``: segment, heading, destination heading, shift, and these starts."""
        rows = zip(
            self.stencils.segment.tolist(),
            self.stencils.heading.tolist(),
            self.stencils.destination_heading.tolist(),
            self.layout.shift(self.stencils.dx, self.stencils.dy).tolist(),
            starts,
            strict=True,
        )
        return (row for row in rows if row[-1])

    def nodes(self, indices: np.ndarray) -> Planes:
        """The set of the nodes (n, 2): plane (segment * n_headings + heading) and cell (x * ny + y)."""
        nx, ny = self.layout.nx, self.layout.ny
        planes = [0] * (self.n_segments * self.n_headings)
        order = np.argsort(indices[:, 0], kind="stable")
        plane, first = np.unique(indices[order, 0], return_index=True)
        for index, cells in zip(plane.tolist(), np.split(indices[order, 1], first)[1:], strict=True):
            mask = np.zeros(nx * ny, dtype=bool)
            mask[cells] = True
            planes[index] = self.layout.pack(mask.reshape(nx, ny))
        return planes

    def everything(self) -> Planes:
        """The set of all cells, headings and segments."""
        return [self.layout.ground] * (self.n_segments * self.n_headings)

    def arrivals(self, segment: int, starts: Mapping[int, int]) -> Planes:
        """For each heading, the plane of where ``segment`` can end when it is played from ``starts``, by heading."""
        landed = [0] * self.n_headings
        for heading, plane in starts.items():
            for turned, ways in self.leaving[segment * self.n_headings + heading]:
                landed[turned] |= played(plane, ways)
        return [self.layout.fold(plane) for plane in landed]

    def playable(self, segment: int, ends: Mapping[int, int]) -> Planes:
        """For each heading, the plane of the starts from which ``segment`` can end in ``ends``, by heading."""
        able = [0] * self.n_headings
        for turned, plane in ends.items():
            there = self.layout.extend(plane)
            for heading, ways in self.entering[segment * self.n_headings + turned]:
                able[heading] |= playable_from(there, ways)
        return able

    def image(self, nodes: Planes) -> Planes:
        """All nodes that one link leads to from ``nodes``."""
        n_headings = self.n_headings
        merged = self.merged(nodes)
        image = [0] * len(nodes)
        for members, merges in zip(self.members_of_fork, self.merges_before, strict=True):
            for heading in range(n_headings):
                starts = _union(merged[merge * n_headings + heading] for merge in merges)
                if starts:
                    for segment in members:
                        for turned, ways in self.leaving[segment * n_headings + heading]:
                            image[segment * n_headings + turned] |= played(starts, ways)
        return [self.layout.fold(plane) for plane in image]

    def preimage(self, nodes: Planes) -> Planes:
        """All nodes with a link that leads to one of ``nodes``."""
        return self._starting([plane for fork in range(len(self.members_of_fork)) for plane in self._able(nodes, fork)])

    def ends_of_links(self, starts: Sequence[int]) -> tuple[Planes, Planes]:
        """The nodes where links start, and those where they end, that play a stencil from its ``starts``, K planes."""
        n_headings, fold = self.n_headings, self.layout.fold
        able = [0] * (len(self.members_of_fork) * n_headings)
        ends = [0] * (self.n_segments * n_headings)
        for segment, heading, turned, shift, cells in self._with_stencils(starts):
            if not self.parents[segment]:
                continue
            able[self.fork_of[segment] * n_headings + heading] |= cells
            ends[segment * n_headings + turned] |= fold(played(cells, [(shift, cells)]))
        return self._starting(able), ends

    def _starting(self, able: Planes) -> Planes:
        """All nodes from which a fork is played, by the cells from which each fork is, in each heading."""
        n_headings = self.n_headings
        merged = [
            _union(able[fork * n_headings + heading] for fork in after)
            for after in self.forks_after
            for heading in range(n_headings)
        ]
        return [merged[merge * n_headings + heading] for merge in self.merge_of for heading in range(n_headings)]

    def led_to(self, nodes: Planes) -> Planes:
        """``nodes`` without those that no link leads to from inside the set, and some that only such ones lead to.

        Fork after fork, in place: later forks start from what earlier ones have left.
        """
        n_headings, fold = self.n_headings, self.layout.fold
        nodes = list(nodes)
        merged: list[Planes | None] = [None] * len(self.members_of_merge)
        for members, merges in zip(self.members_of_fork, self.merges_before, strict=True):
            starting = [merged[merge] or self._merge(nodes, merge) for merge in merges]
            for merge, planes in zip(merges, starting, strict=True):
                merged[merge] = planes
            starts = [_union(planes[heading] for planes in starting) for heading in range(n_headings)]
            for segment in members:
                landed = [0] * n_headings
                for heading, plane in enumerate(starts):
                    if plane:
                        for turned, ways in self.leaving[segment * n_headings + heading]:
                            landed[turned] |= played(plane, ways)
                for heading, plane in enumerate(landed):
                    nodes[segment * n_headings + heading] &= fold(plane)
                merged[self.merge_of[segment]] = None
        return nodes

    def leading_on(self, nodes: Planes) -> Planes:
        """``nodes`` without those that no link leaves for inside the set, and some that only lead to such ones.

        Merge after merge, in place and backwards, as segments follow their clips in ascending order.
        """
        n_headings = self.n_headings
        nodes = list(nodes)
        able: list[Planes | None] = [None] * len(self.members_of_fork)
        for merge in range(len(self.members_of_merge) - 1, -1, -1):
            starting = [able[fork] or self._able(nodes, fork) for fork in self.forks_after[merge]]
            for fork, planes in zip(self.forks_after[merge], starting, strict=True):
                able[fork] = planes
            starts = [_union(planes[heading] for planes in starting) for heading in range(n_headings)]
            for segment in self.members_of_merge[merge]:
                for heading, plane in enumerate(starts):
                    nodes[segment * n_headings + heading] &= plane
                able[self.fork_of[segment]] = None
        return nodes

    def moves_within(self, nodes: Sequence[int]) -> Iterator[tuple[int, int, int, int, int]]:
        """For each stencil that leads to one of ``nodes``: segment, start heading, destination heading, shift and the
        plane of cells from which it does."""
        for index, leaving in enumerate(self.leaving):
            segment, heading = divmod(index, self.n_headings)
            for turned, ways in leaving:
                there = self.layout.extend(nodes[segment * self.n_headings + turned])
                for shift, valid in ways:
                    able = valid & (there >> shift if shift >= 0 else there << -shift)
                    if able:
                        yield segment, heading, turned, shift, able

    def count_links(self, nodes: Sequence[int], enough: float = np.inf) -> int:
        """Number of links between nodes of a set; counting ends early once there are more than ``enough``."""
        n_links = 0
        for segment, heading, _, _, able in self.moves_within(nodes):
            for parent in self.parents[segment]:
                n_links += (nodes[parent * self.n_headings + heading] & able).bit_count()
            if n_links > enough:
                break
        return n_links

    def links_within(self, nodes: Sequence[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The nodes of a set and the links between them, written out.

        Returns
        -------
        indices : (n, 2) int array, plane (segment * n_headings + heading) and cell (x * ny + y) of each node, ascending
        starts, ends : (L,) int arrays of rows of ``indices``
        """
        layout = self.layout
        cells = [layout.flat_cells(plane) if plane else np.empty(0, dtype=int) for plane in nodes]
        first = np.concatenate([[0], np.cumsum([len(c) for c in cells])])
        starts, ends = [np.empty(0, dtype=int)], [np.empty(0, dtype=int)]
        for segment, heading, turned, shift, able in self.moves_within(nodes):
            arrival = segment * self.n_headings + turned
            for parent in self.parents[segment]:
                start = parent * self.n_headings + heading
                moving = nodes[start] & able
                if moving:
                    leaving = layout.flat_cells(moving)
                    arrived = layout.moved(leaving, shift)
                    starts.append(first[start] + np.searchsorted(cells[start], leaving))
                    ends.append(first[arrival] + np.searchsorted(cells[arrival], arrived))
        plane = np.repeat(np.arange(len(nodes)), [len(c) for c in cells])
        return np.column_stack([plane, np.concatenate(cells)]), np.concatenate(starts), np.concatenate(ends)

    def merged(self, nodes: Planes) -> Planes:
        """For each merge and heading: where a set has a node of any of its segments."""
        return [plane for merge in range(len(self.members_of_merge)) for plane in self._merge(nodes, merge)]

    def _merge(self, nodes: Planes, merge: int) -> Planes:
        """For each heading: where a set has a node of any segment of a merge."""
        members, n_headings = self.members_of_merge[merge], self.n_headings
        return [_union(nodes[segment * n_headings + heading] for segment in members) for heading in range(n_headings)]

    def _able(self, nodes: Planes, fork: int) -> Planes:
        """For each heading: from where a segment of a fork can end in a node of a set."""
        able = [0] * self.n_headings
        for segment in self.members_of_fork[fork]:
            first = segment * self.n_headings
            for ends, entering in zip(
                nodes[first : first + self.n_headings], self.entering[first : first + self.n_headings], strict=True
            ):
                if ends:
                    ends = self.layout.extend(ends)
                    for heading, ways in entering:
                        able[heading] |= playable_from(ends, ways)
        return able


def played(starts: int, ways: Ways) -> int:
    """Where ways lead from ``starts``; on a tiled ground, not folded yet."""
    ends = 0
    for shift, valid in ways:
        moving = starts & valid
        ends |= moving << shift if shift >= 0 else moving >> -shift
    return ends


def playable_from(ends: int, ways: Ways) -> int:
    """From where ways lead to ``ends``, which are extended on a tiled ground."""
    starts = 0
    for shift, valid in ways:
        starts |= valid & (ends >> shift if shift >= 0 else ends << -shift)
    return starts


def _union(planes: Iterable[int]) -> int:
    union = 0
    for plane in planes:
        union |= plane
    return union


def _groups(rows: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Index of the first row of each kind, ascending, and the kind of each row."""
    _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    return np.sort(first), rank[kind.ravel()].tolist()


def _members(group_of: list[int], n_groups: int) -> list[list[int]]:
    members: list[list[int]] = [[] for _ in range(n_groups)]
    for member, group in enumerate(group_of):
        members[group].append(member)
    return members
