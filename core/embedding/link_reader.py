"""Single links read out of an embedding's bit-planes, many at a time."""

from collections.abc import Sequence

import numpy as np

from .embedding import Embedding

#: x, y, heading, segment; x and y go on beyond a tiled ground.
Node = tuple[int, int, int, int]


class LinkReader:
    """A reader of the links that lead from some nodes of an embedding, or to them.

    It keeps a copy of every plane that it has looked at, up to the size of the whole embedding: make one for a walk or
    a crowd, and let it go with them.

    Nodes are rows x, y, heading, segment; on a tiled ground x and y may lie beyond it, and ends of links go on there.
    """

    def __init__(self, embedding: Embedding):
        self.embedding = embedding
        unrolling, network = embedding.unrolling, embedding.network
        stencils = unrolling.stencils
        self._size = np.array(embedding.shape[:2])
        self._layout = unrolling.layout
        self._n_headings = stencils.n_headings
        self._valid = PlaneBits(unrolling.valid, unrolling.layout.n_bytes)
        self._nodes = PlaneBits(embedding.planes, unrolling.layout.n_bytes)
        #: (K, 4) what a stencil adds to x and y; its destination heading and segment.
        self._step = np.column_stack([stencils.dx, stencils.dy, stencils.destination_heading, stencils.segment])
        self._arrival = stencils.segment * self._n_headings + stencils.destination_heading
        self._departure = stencils.segment * self._n_headings + stencils.heading
        n_planes, headings = len(embedding.planes), np.arange(self._n_headings)
        departing = _Lists(self._departure, np.arange(len(stencils)), n_planes)
        # Segments with the same children share their lists: index group * n_headings + heading.
        self._exit_group_of = np.array(network.exit_group_of, dtype=int)
        children = [network.children[members[0]] for members in network.exit_groups]
        group = np.repeat(np.arange(len(children)), [len(following) for following in children])
        child = np.array([c for following in children for c in following], dtype=int)
        start = (group[:, None] * self._n_headings + headings).ravel()
        row, stencil = departing.of((child[:, None] * self._n_headings + headings).ravel())
        self._leaving = _Lists(start[row], stencil, len(children) * self._n_headings)
        self._arriving = _Lists(self._arrival, np.arange(len(stencils)), n_planes)
        parents = [(segment, parent) for segment, before in enumerate(network.parents) for parent in before]
        owner, parent = np.array(parents, dtype=int).reshape(-1, 2).T
        self._parents = _Lists(owner, parent, len(network.parents))

    def are_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Test which rows of (n, 4) are nodes of the embedding: (n,) bool."""
        nodes = np.asarray(nodes)
        inside = np.all((nodes[:, 2:] >= 0) & (nodes[:, 2:] < self.embedding.shape[2:]), axis=1)
        if not self.embedding.environment.grid.tiled:
            inside &= np.all((nodes[:, :2] >= 0) & (nodes[:, :2] < self._size), axis=1)
        found = inside.copy()
        kept = nodes[inside]
        found[inside] = self._nodes.at(kept[:, 3] * self._n_headings + kept[:, 2], self._bit(kept[:, :2]))
        return found

    def is_node(self, node: Node) -> bool:
        """Test whether (x, y, heading, segment) is a node of the embedding."""
        return bool(self.are_nodes(np.array([node]))[0])

    def links_from(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return all links from the (n, 4) nodes: (L,) row of ``nodes`` and (L,) stencil, ascending in this order."""
        row, stencil = self._leaving.of(self._exit_group_of[nodes[:, 3]] * self._n_headings + nodes[:, 2])
        cells = nodes[row, :2]
        able = self._valid.at(stencil, self._bit(cells))
        row, stencil = row[able], stencil[able]
        lands = self._nodes.at(self._arrival[stencil], self._bit(cells[able] + self._step[stencil, :2]))
        return row[lands], stencil[lands]

    def stencils_from(self, node: Node) -> np.ndarray:
        """Return (L,) stencils of all links from a node, ascending."""
        return self.links_from(np.array([node]))[1]

    def links_to(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All links to the (n, 4) nodes: (L,) row of ``nodes``, stencil, and segment of the node they start from."""
        row, stencil = self._arriving.of(nodes[:, 3] * self._n_headings + nodes[:, 2])
        cells = nodes[row, :2] - self._step[stencil, :2]
        inside = np.ones(len(row), dtype=bool)
        if not self.embedding.environment.grid.tiled:
            inside = np.all((cells >= 0) & (cells < self._size), axis=1)
        row, stencil, cells = row[inside], stencil[inside], cells[inside]
        able = self._valid.at(stencil, self._bit(cells))
        row, stencil, cells = row[able], stencil[able], cells[able]
        link, parent = self._parents.of(self._step[stencil, 3])
        heading = self._departure[stencil[link]] % self._n_headings
        alive = self._nodes.at(parent * self._n_headings + heading, self._bit(cells[link]))
        return row[link[alive]], stencil[link[alive]], parent[alive]

    def variability(self, nodes: np.ndarray) -> np.ndarray:
        """Return (n,) int: in-degree x out-degree of each node (paper, eq. 1)."""
        arriving = np.bincount(self.links_to(nodes)[0], minlength=len(nodes))
        return arriving * np.bincount(self.links_from(nodes)[0], minlength=len(nodes))

    def ends(self, nodes: np.ndarray, stencils: np.ndarray) -> np.ndarray:
        """Return (L, 4) nodes at the other ends of links: from (L, 4) nodes, or from one, by (L,) stencils."""
        ends = self._step[stencils]
        ends[:, :2] += np.asarray(nodes)[..., :2]
        return ends

    def follow(self, node: Node, stencil: int) -> Node:
        """Return the node at the other end of a link."""
        dx, dy, heading, segment = self._step[stencil].tolist()
        return node[0] + dx, node[1] + dy, heading, segment

    def wrapped(self, nodes: np.ndarray) -> np.ndarray:
        """Return (n, 4) the nodes with their places on the ground, whichever tile they lie in."""
        wrapped = np.array(nodes)
        wrapped[:, :2] %= self._size
        return wrapped

    def _bit(self, cells: np.ndarray) -> np.ndarray:
        x, y = (cells % self._size).T
        return self._layout.bit(x, y)


class PlaneBits:
    """Planes as rows of bytes, copied when first looked at: a bit of a long integer costs a shift of all of it."""

    def __init__(self, planes: Sequence[int], n_bytes: int):
        self._planes = planes
        self._rows = np.empty((len(planes), n_bytes), dtype=np.uint8)
        self._known = np.zeros(len(planes), dtype=bool)

    def at(self, plane: np.ndarray, bit: np.ndarray) -> np.ndarray:
        """Return (n,) bool: bit ``bit[i]`` of plane ``plane[i]``."""
        for new in set(plane[~self._known[plane]].tolist()):
            raw = self._planes[new].to_bytes(self._rows.shape[1], "little")
            self._rows[new] = np.frombuffer(raw, dtype=np.uint8)
            self._known[new] = True
        return (self._rows[plane, bit >> 3] >> (bit & 7).astype(np.uint8) & 1).astype(bool)


class _Lists:
    """Lists of different lengths, looked up for many owners at once."""

    def __init__(self, owner: np.ndarray, member: np.ndarray, n_owners: int):
        order = np.argsort(owner, kind="stable")
        self._members = member[order]
        self._length = np.bincount(owner, minlength=n_owners)
        self._first = np.cumsum(self._length) - self._length

    def of(self, owner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the lists of the (n,) owners, one after the other: (L,) row of ``owner`` and (L,) member."""
        length = self._length[owner]
        row = np.repeat(np.arange(len(owner)), length)
        offset = np.repeat(self._first[owner] - (np.cumsum(length) - length), length)
        return row, self._members[offset + np.arange(len(row))]
