"""The links of an unrolled motion graph as moves of whole bit-planes.

Nodes are (cell, heading, segment). A set of nodes is a list of *bundles*: the planes of one segment and of several
neighbouring headings, side by side in one integer. What concerns all headings alike - "whoever arrived by a parent may
start a child" - is then one operation for many planes. On small grounds, where an operation costs more than the bits
it moves, a bundle holds all headings; on large ones, where packing would cost more than it saves, just one.

A link's validity depends on the cell it starts from and on the segment that is played, not on the one before. The
*starts* of a segment are therefore the arrivals of all its parents, ORed. Segments with the same parents share their
starts (a *fork*), and parents with the same children are ORed only once (a *merge*): cutting makes many of both,
because segments that end in alike poses can all go on in the same ways.
"""

from collections.abc import Generator, Iterable, Iterator

import numpy as np

from ..progress import Progress
from .unroll import Unrolling

#: A set of nodes: bundles of planes, indexed segment * n_blocks + block of headings.
Nodes = list[int]

#: Beyond this size packing planes into bundles costs more than it saves (measured).
BUNDLED_BYTES = 4096


class StepNetwork:
    """The one-step links of an unrolling, forwards and backwards.

    Parameters
    ----------
    unrolling : Unrolling
    links : (L, 2) int array
        Links of the motion graph.
    n_segments : int
    bundled_bytes : int
        Planes of up to this many bytes travel in bundles of all headings, larger ones alone.
    """

    def __init__(self, unrolling: Unrolling, links: np.ndarray, n_segments: int, bundled_bytes: int = BUNDLED_BYTES):
        stencils = unrolling.stencils
        self.layout = unrolling.layout
        self.n_headings = stencils.n_headings
        self.n_segments = n_segments
        self.plane_bytes = (self.layout.n_bits + 7) // 8
        self.bundled = self.n_headings if self.plane_bytes <= bundled_bytes else 1
        self.n_blocks = self.n_headings // self.bundled

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

        # moves[segment * n_blocks + block]: (place of the start heading in its block, destination heading, shift,
        # valid starts); arriving[...]: the same for the block of the destination, with the two headings swapped.
        self.moves: list[list[tuple[int, int, int, int]]] = [[] for _ in range(n_segments * self.n_blocks)]
        self.arriving: list[list[tuple[int, int, int, int]]] = [[] for _ in range(n_segments * self.n_blocks)]
        rows = zip(
            stencils.segment.tolist(),
            stencils.heading.tolist(),
            stencils.destination_heading.tolist(),
            self.layout.shift(stencils.dx, stencils.dy).tolist(),
            unrolling.valid,
            strict=True,
        )
        for segment, heading, turned, shift, valid in rows:
            if valid:
                block, place = divmod(heading, self.bundled)
                self.moves[segment * self.n_blocks + block].append((place, turned, shift, valid))
                block, place = divmod(turned, self.bundled)
                self.arriving[segment * self.n_blocks + block].append((place, heading, shift, valid))

    def bundles(self, planes: list[int]) -> list[int]:
        """The planes of any number of whole blocks as bundles."""
        if self.bundled == 1:
            return planes
        size = self.plane_bytes
        return [
            int.from_bytes(
                b"".join([plane.to_bytes(size, "little") for plane in planes[i : i + self.bundled]]), "little"
            )
            for i in range(0, len(planes), self.bundled)
        ]

    def planes(self, bundle: int) -> list[int]:
        """The plane of each heading of a bundle."""
        if self.bundled == 1:
            return [bundle]
        size = self.plane_bytes
        raw = bundle.to_bytes(size * self.bundled, "little")
        return [int.from_bytes(raw[i : i + size], "little") for i in range(0, len(raw), size)]

    def nodes(self, indices: np.ndarray) -> Nodes:
        """The set of the nodes (n, 2): plane (segment * n_headings + heading) and cell (x * ny + y)."""
        nx, ny = self.layout.nx, self.layout.ny
        planes = [0] * (self.n_segments * self.n_headings)
        order = np.argsort(indices[:, 0], kind="stable")
        plane, first = np.unique(indices[order, 0], return_index=True)
        for index, cells in zip(plane.tolist(), np.split(indices[order, 1], first)[1:], strict=True):
            mask = np.zeros(nx * ny, dtype=bool)
            mask[cells] = True
            planes[index] = self.layout.pack(mask.reshape(nx, ny))
        return self.bundles(planes)

    def node(self, segment: int, heading: int, x: int, y: int) -> Nodes:
        """The set of one node."""
        return self.nodes(np.array([[segment * self.n_headings + heading, x * self.layout.ny + y]]))

    def everything(self) -> Nodes:
        """The set of all cells, headings and segments."""
        return self._everywhere(self.n_segments)

    def _everywhere(self, n: int) -> list[int]:
        """For each of n segments, forks or merges: the bundles of every cell in every heading."""
        return self.bundles([self.layout.ground] * self.bundled) * (n * self.n_blocks)

    def arrivals(self, segment: int, block: int, starts: int) -> list[int]:
        """For each block, the bundle of where ``segment`` can end when it is played from the ``starts`` of a block."""
        planes = self.planes(starts)
        landed = [0] * self.n_headings
        for place, turned, shift, valid in self.moves[segment * self.n_blocks + block]:
            moving = planes[place] & valid
            if moving:
                landed[turned] |= moving << shift if shift >= 0 else moving >> -shift
        if self.layout.tiled:
            landed = [self.layout.fold(plane) for plane in landed]
        return self.bundles(landed)

    def playable(self, segment: int, block: int, ends: int) -> list[int]:
        """For each block, the bundle of the starts from which ``segment`` can end in one of the ``ends`` of a block."""
        planes = self.planes(ends)
        if self.layout.tiled:
            planes = [self.layout.extend(plane) for plane in planes]
        able = [0] * self.n_headings
        for place, heading, shift, valid in self.arriving[segment * self.n_blocks + block]:
            there = planes[place]
            if there:
                able[heading] |= valid & (there >> shift if shift >= 0 else there << -shift)
        return self.bundles(able)

    def image(self, nodes: Nodes) -> Nodes:
        """All nodes that one link leads to from ``nodes``."""
        n_blocks = self.n_blocks
        image = [0] * len(nodes)
        for fork, members in enumerate(self.members_of_fork):
            parents = [p for merge in self.merges_before[fork] for p in self.members_of_merge[merge]]
            for block in range(n_blocks):
                starts = _union(nodes[parent * n_blocks + block] for parent in parents)
                for segment in members:
                    for there, arrived in enumerate(self.arrivals(segment, block, starts)):
                        image[segment * n_blocks + there] |= arrived
        return image

    def preimage(self, nodes: Nodes) -> Nodes:
        """All nodes with a link that leads to one of ``nodes``."""
        n_blocks = self.n_blocks
        able = [0] * (len(self.members_of_fork) * n_blocks)
        for index, ends in enumerate(nodes):
            segment, block = divmod(index, n_blocks)
            first = self.fork_of[segment] * n_blocks
            for there, starts in enumerate(self.playable(segment, block, ends)):
                able[first + there] |= starts
        merged = [
            _union(able[fork * n_blocks + block] for fork in after)
            for after in self.forks_after
            for block in range(n_blocks)
        ]
        return [merged[merge * n_blocks + block] for merge in self.merge_of for block in range(n_blocks)]

    def trim(self, nodes: Nodes) -> Nodes:
        """``nodes`` without those that have no link from, or then none to, the rest: once over."""
        nodes = intersection(nodes, self.image(nodes))
        return intersection(nodes, self.preimage(nodes))

    def _moves_within(self, nodes: Nodes) -> Iterator[tuple[int, int, int, int, int]]:
        """For each stencil that leads to one of ``nodes``: segment, start heading, destination heading, shift and the
        plane of cells from which it does."""
        planes = [plane for bundle in nodes for plane in self.planes(bundle)]
        for index, moves in enumerate(self.moves):
            segment, block = divmod(index, self.n_blocks)
            for place, turned, shift, valid in moves:
                there = self.layout.extend(planes[segment * self.n_headings + turned])
                able = valid & (there >> shift if shift >= 0 else there << -shift)
                if able:
                    yield segment, block * self.bundled + place, turned, shift, able

    def count_links(self, nodes: Nodes, enough: float = np.inf) -> int:
        """Number of links between nodes of a set; counting ends early once there are more than ``enough``."""
        planes = [plane for bundle in nodes for plane in self.planes(bundle)]
        n_links = 0
        for segment, heading, _, _, able in self._moves_within(nodes):
            for parent in self.parents[segment]:
                n_links += (planes[parent * self.n_headings + heading] & able).bit_count()
            if n_links > enough:
                break
        return n_links

    def links_within(self, nodes: Nodes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The nodes of a set and the links between them, written out.

        Returns
        -------
        indices : (n, 2) int array, plane (segment * n_headings + heading) and cell (x * ny + y) of each node, ascending
        starts, ends : (L,) int arrays of rows of ``indices``
        """
        layout = self.layout
        planes = [plane for bundle in nodes for plane in self.planes(bundle)]
        cells = [layout.flat_cells(plane) if plane else np.empty(0, dtype=int) for plane in planes]
        first = np.concatenate([[0], np.cumsum([len(c) for c in cells])])
        starts, ends = [np.empty(0, dtype=int)], [np.empty(0, dtype=int)]
        for segment, heading, turned, shift, able in self._moves_within(nodes):
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

    def reached_from_steps(self, seed: Nodes, within: Nodes) -> Generator[Progress, None, Nodes]:
        """``seed``, a subset of ``within``, and all nodes that links lead to from it inside ``within``.

        Round after round, each fork plays the starts that it has gathered since its last turn: later forks of a round
        already see what earlier ones reached. Yields progress after every round.
        """
        n_blocks = self.n_blocks
        unreached = difference(within, seed)
        unplayed = self._everywhere(len(self.members_of_fork))
        pending = [0] * len(unplayed)

        def arrive(segment: int, block: int, fresh: int) -> None:
            for fork in self.forks_after[self.merge_of[segment]]:
                start = fork * n_blocks + block
                starts = fresh & unplayed[start]
                if starts:
                    unplayed[start] ^= starts
                    pending[start] |= starts

        for index, nodes in enumerate(seed):
            if nodes:
                arrive(*divmod(index, n_blocks), nodes)
        n_rounds = 0
        while any(pending):
            n_rounds += 1
            yield self._progress(n_rounds)
            for start, starts in enumerate(pending):
                if not starts:
                    continue
                pending[start] = 0
                fork, block = divmod(start, n_blocks)
                for segment in self.members_of_fork[fork]:
                    for there, arrived in enumerate(self.arrivals(segment, block, starts), segment * n_blocks):
                        fresh = arrived & unreached[there]
                        if fresh:
                            unreached[there] ^= fresh
                            arrive(segment, there - segment * n_blocks, fresh)
        return difference(within, unreached)

    def reaching_steps(self, seed: Nodes, within: Nodes) -> Generator[Progress, None, Nodes]:
        """``seed``, a subset of ``within``, and all nodes from which links lead to it inside ``within``."""
        n_blocks = self.n_blocks
        unreached = difference(within, seed)
        unable = self._everywhere(len(self.members_of_fork))
        unmerged = self._everywhere(len(self.members_of_merge))
        pending = list(seed)

        def allow(fork: int, block: int, able: int) -> None:
            for merge in self.merges_before[fork]:
                merged = able & unmerged[merge * n_blocks + block]
                if not merged:
                    continue
                unmerged[merge * n_blocks + block] ^= merged
                for parent in self.members_of_merge[merge]:
                    node = parent * n_blocks + block
                    fresh = merged & unreached[node]
                    if fresh:
                        unreached[node] ^= fresh
                        pending[node] |= fresh

        n_rounds = 0
        while any(pending):
            n_rounds += 1
            yield self._progress(n_rounds)
            # Segments follow their clips in ascending order; backwards, those that follow come first.
            for index in range(len(pending) - 1, -1, -1):
                ends, pending[index] = pending[index], 0
                if not ends:
                    continue
                segment, block = divmod(index, n_blocks)
                first = self.fork_of[segment] * n_blocks
                for there, playable in enumerate(self.playable(segment, block, ends)):
                    able = playable & unable[first + there]
                    if able:
                        unable[first + there] ^= able
                        allow(self.fork_of[segment], there, able)
        return difference(within, unreached)

    def _progress(self, n_rounds: int) -> Progress:
        """How far a closure is: the ground is crossed in some rounds, and then corners are left."""
        expected = (self.layout.nx + self.layout.ny) / max(self.layout.reach_x, self.layout.reach_y, 1)
        return Progress(n_rounds / (n_rounds + expected), "Following links")


def count(nodes: Nodes) -> int:
    """Number of nodes in a set."""
    return sum(bundle.bit_count() for bundle in nodes)


def intersection(a: Nodes, b: Nodes) -> Nodes:
    return [x & y for x, y in zip(a, b, strict=True)]


def difference(a: Nodes, b: Nodes) -> Nodes:
    """The nodes of ``a`` that are not in ``b``, a subset of ``a``."""
    return [x ^ y for x, y in zip(a, b, strict=True)]


def union(a: Nodes, b: Nodes) -> Nodes:
    return [x | y for x, y in zip(a, b, strict=True)]


def _union(bundles: Iterable[int]) -> int:
    union = 0
    for bundle in bundles:
        union |= bundle
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
