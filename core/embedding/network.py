"""The one-step links of an unrolled motion graph as moves of bit-planes, and what they lead to.

Nodes are (cell, heading, segment). A link's validity depends on the cell it starts from and on the segment that is
played, not on the one before. The *starts* of a segment are therefore the arrivals of all its predecessors, ORed.
Segments with the same predecessors share their starts (an *entry group*), and segments with the same successors are
ORed only once (an *exit group*; both are classes of twins in the motion graph): cutting makes many of both, because
segments that end in alike poses can all go on in the same ways.

Images and pre-images of sets are computed as in symbolic model checking, for all nodes of a plane at once, and no link
is ever stored.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from .node_set import PACKED_BYTES, HeadingPacking, NodeSet, union_of
from .unroll import Unrolling

#: Planes, indexed segment * n_headings + heading, or group * n_headings + heading.
Planes = list[int]

#: Moves from one plane into another: by how many bits, and from which cells.
Moves = list[tuple[int, int]]


class StepNetwork:
    """The one-step links of an unrolling, forwards and backwards.

    Parameters
    ----------
    unrolling : Unrolling
    links : (L, 2) int array
        Links of the motion graph.
    n_segments : int
    packed_bytes : int
        Planes of up to this many bytes are counted in blocks of all headings, see :class:`.HeadingPacking`.

    Attributes
    ----------
    children, parents : lists of lists of int
        For each segment those that may follow it, and those that it may follow.
    exit_groups, entry_groups : lists of lists of int
        Segments with the same children, and with the same parents.
    exit_group_of, entry_group_of : lists of int
        The groups of each segment.
    entry_groups_after, exit_groups_before : lists of lists of int
        For each exit group the entry groups that may follow it, and the other way round.
    leaving : list of lists of (heading, Moves)
        For each plane the headings that its segment, played from its heading, ends in, and the moves there.
    entering : list of lists of (heading, Moves)
        For each plane the headings from which its segment ends in its heading, and the same moves.
    """

    def __init__(self, unrolling: Unrolling, links: np.ndarray, n_segments: int, packed_bytes: int = PACKED_BYTES):
        stencils = unrolling.stencils
        self.stencils, self.layout = stencils, unrolling.layout
        self.n_headings = stencils.n_headings
        self.n_segments = n_segments
        self.packing = HeadingPacking.for_planes(self.layout, self.n_headings, packed_bytes)

        follows = np.zeros((n_segments, n_segments), dtype=bool)
        follows[links[:, 0], links[:, 1]] = True
        self.children = [np.flatnonzero(row).tolist() for row in follows]
        self.parents = [np.flatnonzero(column).tolist() for column in follows.T]
        rows, self.exit_group_of = _twins(follows)
        columns, self.entry_group_of = _twins(follows.T)
        between = follows[np.ix_(rows, columns)]
        self.entry_groups_after = [np.flatnonzero(row).tolist() for row in between]
        self.exit_groups_before = [np.flatnonzero(column).tolist() for column in between.T]
        self.exit_groups = _members(self.exit_group_of, len(rows))
        self.entry_groups = _members(self.entry_group_of, len(columns))

        leaving: list[dict[int, Moves]] = [{} for _ in range(n_segments * self.n_headings)]
        entering: list[dict[int, Moves]] = [{} for _ in range(n_segments * self.n_headings)]
        for segment, heading, turned, shift, valid in self._with_stencils(unrolling.valid):
            first = segment * self.n_headings
            leaving[first + heading].setdefault(turned, []).append((shift, valid))
            entering[first + turned].setdefault(heading, []).append((shift, valid))
        self.leaving = [list(moves.items()) for moves in leaving]
        self.entering = [list(moves.items()) for moves in entering]

    def _with_stencils(self, starts: Sequence[int]) -> Iterator[tuple[int, int, int, int, int]]:
        """Yield, for each stencil with any ``starts``: segment, heading, destination heading, shift and the starts."""
        rows = zip(
            self.stencils.segment.tolist(),
            self.stencils.heading.tolist(),
            self.stencils.destination_heading.tolist(),
            self.layout.shift(self.stencils.dx, self.stencils.dy).tolist(),
            starts,
            strict=True,
        )
        return (row for row in rows if row[-1])

    def nodes(self, indices: np.ndarray) -> NodeSet:
        """Return the set of the nodes (n, 2): plane (segment * n_headings + heading) and cell (x * ny + y)."""
        nx, ny = self.layout.nx, self.layout.ny
        planes = [0] * (self.n_segments * self.n_headings)
        order = np.argsort(indices[:, 0], kind="stable")
        plane, first = np.unique(indices[order, 0], return_index=True)
        for index, cells in zip(plane.tolist(), np.split(indices[order, 1], first)[1:], strict=True):
            mask = np.zeros(nx * ny, dtype=bool)
            mask[cells] = True
            planes[index] = self.layout.pack(mask.reshape(nx, ny))
        return NodeSet(tuple(planes))

    def node(self, segment: int, heading: int, x: int, y: int) -> NodeSet:
        """Return the set of one node."""
        return self.nodes(np.array([[segment * self.n_headings + heading, x * self.layout.ny + y]]))

    @cached_property
    def everything(self) -> NodeSet:
        """The set of all cells, headings and segments."""
        return NodeSet((self.layout.ground,) * (self.n_segments * self.n_headings))

    @cached_property
    def empty(self) -> NodeSet:
        """The set of no node."""
        return NodeSet((0,) * (self.n_segments * self.n_headings))

    def arrivals(self, segment: int, starts: Sequence[int]) -> Planes:
        """Return, for each heading, where ``segment`` can end when it is played from ``starts``, a plane a heading."""
        landed = [0] * self.n_headings
        for plane, leaving in zip(starts, self._of_segment(self.leaving, segment), strict=True):
            for turned, moves in leaving if plane else ():
                landed[turned] |= image_of(plane, moves)
        return [self.layout.fold(plane) for plane in landed]

    def playable(self, segment: int, ends: Sequence[int]) -> Planes:
        """Return, for each heading, the starts from which ``segment`` can end in ``ends``, a plane a heading."""
        able = [0] * self.n_headings
        for plane, entering in zip(ends, self._of_segment(self.entering, segment), strict=True):
            if plane:
                there = self.layout.extend(plane)
                for heading, moves in entering:
                    able[heading] |= preimage_of(there, moves)
        return able

    def image(self, nodes: NodeSet) -> NodeSet:
        """Return all nodes that one link leads to from ``nodes``."""
        n_headings = self.n_headings
        exits = self.by_exit_group(nodes.planes)
        image = [0] * len(nodes.planes)
        for members, before in zip(self.entry_groups, self.exit_groups_before, strict=True):
            for heading in range(n_headings):
                starts = union_of(exits[group * n_headings + heading] for group in before)
                if starts:
                    for segment in members:
                        for turned, moves in self.leaving[segment * n_headings + heading]:
                            image[segment * n_headings + turned] |= image_of(starts, moves)
        return NodeSet(tuple(map(self.layout.fold, image)))

    def preimage(self, nodes: NodeSet) -> NodeSet:
        """Return all nodes with a link that leads to one of ``nodes``."""
        able = [plane for group in range(len(self.entry_groups)) for plane in self._playable_group(nodes.planes, group)]
        return self._starting(able)

    def trim(self, nodes: NodeSet) -> NodeSet:
        """Return ``nodes`` without those that have no link from, or then none to, the rest: once over."""
        nodes = nodes & self.image(nodes)
        return nodes & self.preimage(nodes)

    def ends_of_links(self, starts: Sequence[int]) -> tuple[NodeSet, NodeSet]:
        """Return where links start, and where they end, that play a stencil from its ``starts``, K planes."""
        n_headings, fold = self.n_headings, self.layout.fold
        able = [0] * (len(self.entry_groups) * n_headings)
        ends = [0] * (self.n_segments * n_headings)
        for segment, heading, turned, shift, cells in self._with_stencils(starts):
            if self.parents[segment]:
                able[self.entry_group_of[segment] * n_headings + heading] |= cells
                ends[segment * n_headings + turned] |= fold(image_of(cells, [(shift, cells)]))
        return self._starting(able), NodeSet(tuple(ends))

    def _starting(self, able: Planes) -> NodeSet:
        """Return all nodes from which entry groups are played, by the cells from which each is, in each heading."""
        n_headings = self.n_headings
        exits = [
            union_of(able[group * n_headings + heading] for group in after)
            for after in self.entry_groups_after
            for heading in range(n_headings)
        ]
        return NodeSet(
            tuple(exits[group * n_headings + heading] for group in self.exit_group_of for heading in range(n_headings))
        )

    def trim_unentered(self, nodes: NodeSet) -> NodeSet:
        """Return ``nodes`` without those that no link leads to from inside the set, and some that only such ones lead
        to.

        Entry group after entry group, in place: later ones start from what earlier ones have left.
        """
        n_headings, fold = self.n_headings, self.layout.fold
        planes = list(nodes.planes)
        exits: list[Planes | None] = [None] * len(self.exit_groups)
        for members, before in zip(self.entry_groups, self.exit_groups_before, strict=True):
            starting = [exits[group] or self._exits(planes, group) for group in before]
            for group, known in zip(before, starting, strict=True):
                exits[group] = known
            starts = [union_of(of_group[heading] for of_group in starting) for heading in range(n_headings)]
            for segment in members:
                landed = [0] * n_headings
                for heading, plane in enumerate(starts):
                    if plane:
                        for turned, moves in self.leaving[segment * n_headings + heading]:
                            landed[turned] |= image_of(plane, moves)
                for heading, plane in enumerate(landed):
                    planes[segment * n_headings + heading] &= fold(plane)
                exits[self.exit_group_of[segment]] = None
        return NodeSet(tuple(planes))

    def trim_unleft(self, nodes: NodeSet) -> NodeSet:
        """Return ``nodes`` without those that no link leaves for inside the set, and some that only lead to such ones.

        Exit group after exit group, in place and backwards, as segments follow their clips in ascending order.
        """
        n_headings = self.n_headings
        planes = list(nodes.planes)
        able: list[Planes | None] = [None] * len(self.entry_groups)
        for members, after in zip(reversed(self.exit_groups), reversed(self.entry_groups_after), strict=True):
            starting = [able[group] or self._playable_group(planes, group) for group in after]
            for group, known in zip(after, starting, strict=True):
                able[group] = known
            starts = [union_of(of_group[heading] for of_group in starting) for heading in range(n_headings)]
            for segment in members:
                for heading, plane in enumerate(starts):
                    planes[segment * n_headings + heading] &= plane
                able[self.entry_group_of[segment]] = None
        return NodeSet(tuple(planes))

    def moves_within(self, nodes: NodeSet) -> Iterator[tuple[int, int, int, int, int]]:
        """Yield, for each stencil that leads to one of ``nodes``: segment, start heading, destination heading, shift
        and the plane of cells from which it does."""
        for index, leaving in enumerate(self.leaving):
            segment, heading = divmod(index, self.n_headings)
            for turned, moves in leaving:
                there = self.layout.extend(nodes.planes[segment * self.n_headings + turned])
                for shift, valid in moves:
                    able = valid & (there >> shift if shift >= 0 else there << -shift)
                    if able:
                        yield segment, heading, turned, shift, able

    def count_links(self, nodes: NodeSet, enough: float = np.inf) -> int:
        """Return the number of links between nodes of a set; counting ends once there are more than ``enough``."""
        n_links, planes = 0, nodes.planes
        for segment, heading, _, _, able in self.moves_within(nodes):
            for parent in self.parents[segment]:
                n_links += (planes[parent * self.n_headings + heading] & able).bit_count()
            if n_links > enough:
                break
        return n_links

    def links_within(self, nodes: NodeSet) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Write out the nodes of a set and the links between them.

        Returns
        -------
        indices : (n, 2) int array, plane (segment * n_headings + heading) and cell (x * ny + y) of each node, ascending
        starts, ends : (L,) int arrays of rows of ``indices``
        """
        layout, planes = self.layout, nodes.planes
        cells = [layout.flat_cells(plane) if plane else np.empty(0, dtype=int) for plane in planes]
        first = np.concatenate([[0], np.cumsum([len(c) for c in cells])])
        starts, ends = [np.empty(0, dtype=int)], [np.empty(0, dtype=int)]
        for segment, heading, turned, shift, able in self.moves_within(nodes):
            arrival = segment * self.n_headings + turned
            for parent in self.parents[segment]:
                start = parent * self.n_headings + heading
                moving = planes[start] & able
                if moving:
                    leaving = layout.flat_cells(moving)
                    arrived = layout.moved(leaving, shift)
                    starts.append(first[start] + np.searchsorted(cells[start], leaving))
                    ends.append(first[arrival] + np.searchsorted(cells[arrival], arrived))
        plane = np.repeat(np.arange(len(planes)), [len(c) for c in cells])
        return np.column_stack([plane, np.concatenate(cells)]), np.concatenate(starts), np.concatenate(ends)

    def by_exit_group(self, planes: Sequence[int]) -> Planes:
        """Return, for each exit group and heading, where there is a node of any of its segments."""
        return [plane for group in range(len(self.exit_groups)) for plane in self._exits(planes, group)]

    def _exits(self, planes: Sequence[int], group: int) -> Planes:
        """Return, for each heading, where there is a node of any segment of an exit group."""
        members, n_headings = self.exit_groups[group], self.n_headings
        return [
            union_of(planes[segment * n_headings + heading] for segment in members) for heading in range(n_headings)
        ]

    def _playable_group(self, planes: Sequence[int], group: int) -> Planes:
        """Return, for each heading, from where a segment of an entry group can end in a node."""
        able = [0] * self.n_headings
        for segment in self.entry_groups[group]:
            for ends, entering in zip(
                self._of_segment(planes, segment), self._of_segment(self.entering, segment), strict=True
            ):
                if ends:
                    ends = self.layout.extend(ends)
                    for heading, moves in entering:
                        able[heading] |= preimage_of(ends, moves)
        return able

    def _of_segment(self, items: Sequence, segment: int) -> Sequence:
        """Return the items of a segment's planes."""
        return items[segment * self.n_headings : (segment + 1) * self.n_headings]


def image_of(starts: int, moves: Moves) -> int:
    """Return where moves lead from ``starts``; on a tiled ground, not folded yet."""
    ends = 0
    for shift, valid in moves:
        moving = starts & valid
        ends |= moving << shift if shift >= 0 else moving >> -shift
    return ends


def preimage_of(ends: int, moves: Moves) -> int:
    """Return from where moves lead to ``ends``, which are extended on a tiled ground."""
    starts = 0
    for shift, valid in moves:
        starts |= valid & (ends >> shift if shift >= 0 else ends << -shift)
    return starts


def _twins(rows: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Return the index of the first row of each kind, ascending, and the kind of each row."""
    _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    return np.sort(first), rank[kind.ravel()].tolist()


def _members(group_of: list[int], n_groups: int) -> list[list[int]]:
    members: list[list[int]] = [[] for _ in range(n_groups)]
    for member, group in enumerate(group_of):
        members[group].append(member)
    return members
