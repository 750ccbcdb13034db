"""The links of an unrolled motion graph, between sets of nodes that are kept in bundles.

A set of nodes is a list of *bundles*: the planes of one segment and of several neighbouring headings, side by side in
one integer. What concerns all headings alike - "how many segments may follow here?" - is then one operation for many
planes. On small grounds, where an operation costs more than the bits it moves, a bundle holds all headings; on large
ones, where packing would cost more than it saves, just one. Following links concerns every heading by itself: that is
done by a :class:`.PlaneNetwork`.
"""

from collections.abc import Generator, Iterator
from functools import cached_property

import numpy as np

from ..progress import Progress
from .closure import reached_from_steps, reaching_steps
from .plane_network import PlaneNetwork, Planes, Ways
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

    Attributes
    ----------
    by_plane : PlaneNetwork
        The same links, between sets of nodes that are kept in single planes.
    """

    def __init__(self, unrolling: Unrolling, links: np.ndarray, n_segments: int, bundled_bytes: int = BUNDLED_BYTES):
        self.by_plane = PlaneNetwork(unrolling, links, n_segments)
        self.layout = unrolling.layout
        self.n_headings = self.by_plane.n_headings
        self.n_segments = n_segments
        self.plane_bytes = (self.layout.n_bits + 7) // 8
        self.bundled = self.n_headings if self.plane_bytes <= bundled_bytes else 1
        self.n_blocks = self.n_headings // self.bundled
        self.children, self.parents = self.by_plane.children, self.by_plane.parents
        self.merge_of, self.fork_of = self.by_plane.merge_of, self.by_plane.fork_of
        self.forks_after, self.merges_before = self.by_plane.forks_after, self.by_plane.merges_before
        self.members_of_merge, self.members_of_fork = self.by_plane.members_of_merge, self.by_plane.members_of_fork

    @cached_property
    def moves(self) -> list[list[tuple[int, int, int, int]]]:
        """For each segment and block (index segment * n_blocks + block): (place of the start heading in its block,
        destination heading, shift, valid starts) of every stencil."""
        return self._by_block(self.by_plane.leaving)

    @cached_property
    def arriving(self) -> list[list[tuple[int, int, int, int]]]:
        """As ``moves``, for the block of the destination: the two headings are swapped."""
        return self._by_block(self.by_plane.entering)

    def _by_block(self, by_plane: list[list[tuple[int, Ways]]]) -> list[list[tuple[int, int, int, int]]]:
        return [
            [
                (place, heading, shift, valid)
                for place, moves in enumerate(by_plane[first : first + self.bundled])
                for heading, ways in moves
                for shift, valid in ways
            ]
            for first in range(0, len(by_plane), self.bundled)
        ]

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

    def all_planes(self, nodes: Nodes) -> Planes:
        """The planes of a set, indexed segment * n_headings + heading."""
        return [plane for bundle in nodes for plane in self.planes(bundle)]

    def nodes(self, indices: np.ndarray) -> Nodes:
        """The set of the nodes (n, 2): plane (segment * n_headings + heading) and cell (x * ny + y)."""
        return self.bundles(self.by_plane.nodes(indices))

    def node(self, segment: int, heading: int, x: int, y: int) -> Nodes:
        """The set of one node."""
        return self.nodes(np.array([[segment * self.n_headings + heading, x * self.layout.ny + y]]))

    def everything(self) -> Nodes:
        """The set of all cells, headings and segments."""
        return self.bundles([self.layout.ground] * self.bundled) * (self.n_segments * self.n_blocks)

    def arrivals(self, segment: int, block: int, starts: int) -> list[int]:
        """For each block, the bundle of where ``segment`` can end when it is played from the ``starts`` of a block."""
        first = block * self.bundled
        return self.bundles(self.by_plane.arrivals(segment, dict(enumerate(self.planes(starts), first))))

    def playable(self, segment: int, block: int, ends: int) -> list[int]:
        """For each block, the bundle of the starts from which ``segment`` can end in one of the ``ends`` of a block."""
        first = block * self.bundled
        return self.bundles(self.by_plane.playable(segment, dict(enumerate(self.planes(ends), first))))

    def image(self, nodes: Nodes) -> Nodes:
        """All nodes that one link leads to from ``nodes``."""
        return self.bundles(self.by_plane.image(self.all_planes(nodes)))

    def preimage(self, nodes: Nodes) -> Nodes:
        """All nodes with a link that leads to one of ``nodes``."""
        return self.bundles(self.by_plane.preimage(self.all_planes(nodes)))

    def trim(self, nodes: Nodes) -> Nodes:
        """``nodes`` without those that have no link from, or then none to, the rest: once over."""
        planes = self.all_planes(nodes)
        planes = intersection(planes, self.by_plane.image(planes))
        return self.bundles(intersection(planes, self.by_plane.preimage(planes)))

    def moves_within(self, nodes: Nodes) -> Iterator[tuple[int, int, int, int, int]]:
        """For each stencil that leads to one of ``nodes``: segment, start heading, destination heading, shift and the
        plane of cells from which it does."""
        return self.by_plane.moves_within(self.all_planes(nodes))

    def count_links(self, nodes: Nodes, enough: float = np.inf) -> int:
        """Number of links between nodes of a set; counting ends early once there are more than ``enough``."""
        return self.by_plane.count_links(self.all_planes(nodes), enough)

    def links_within(self, nodes: Nodes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The nodes of a set and the links between them, written out: see :meth:`.PlaneNetwork.links_within`."""
        return self.by_plane.links_within(self.all_planes(nodes))

    def reached_from_steps(self, seed: Nodes, within: Nodes) -> Generator[Progress, None, Nodes]:
        """``seed``, a subset of ``within``, and all nodes that links lead to from it inside ``within``.

        Yields progress.
        """
        steps = reached_from_steps(self.by_plane, self.all_planes(seed), self.all_planes(within))
        return self.bundles((yield from steps))

    def reaching_steps(self, seed: Nodes, within: Nodes) -> Generator[Progress, None, Nodes]:
        """``seed``, a subset of ``within``, and all nodes from which links lead to it inside ``within``."""
        steps = reaching_steps(self.by_plane, self.all_planes(seed), self.all_planes(within))
        return self.bundles((yield from steps))


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
