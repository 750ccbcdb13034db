"""Wandering: walks that go from place to place, so that every part of the floor is visited alike.

A random walk takes each link with the same probability and stays where many links are: near a wall, where all that a
character can do is to stand and turn, it may shuffle for a minute. A wanderer draws a place on the covered floor, goes
there by the cheapest of all short ways, draws the next, and so on.
"""

from collections.abc import Generator, Iterator

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node, PlaneBits
from ..embedding.node_set import NodeSet
from ..progress import Progress
from .cheapest import cheapest_way_steps
from .near_cheapest import STARTS
from .prices import LinkPrices
from .walk import Trail, Walk, WalkSettings, begin, random_node

#: Metres from one place to the next at the most: on large grounds the way to a far one costs more than it shows.
FARTHEST = 10.0

#: Metres within which a place is passed.
NEAR = 0.5

#: Segments that a way may have more than the one of the fewest.
MORE_SEGMENTS = 5

#: Segments beyond the place that a way is judged by, too.
LOOK_AHEAD = 3

#: By how much chance raises the price of each segment, at the most, anew for each place.
CHANCE = 0.3

#: Milliseconds for each second, beyond which a way is so dear that another place is drawn; how many are at the most.
DEAR, DRAWS = 3500.0, 3

#: By how much each time that a segment was played raises its price, and the share that is left of that after another.
AGAIN, MEMORY = 0.05, 0.9


def wandering_walk_steps(
    embedding: Embedding, rng: np.random.Generator, settings: WalkSettings
) -> Generator[Progress, None, Walk]:
    """Walk by places drawn evenly from the covered floor around.

    From one to the next it goes by the cheapest way (:mod:`.prices`, :mod:`.cheapest`) of those that have at most
    ``MORE_SEGMENTS`` more than the one of the fewest segments, and only come by nodes that are nearer, by the fewest
    segments, than its start. Chance makes each segment up to ``CHANCE`` dearer; if the way is too dear for the time
    that it takes, another place is drawn.

    Raises
    ------
    WalkError
        The embedding is empty, or the start is no node of it.
    """
    reader, start = begin(embedding, rng, settings.start)
    starts = [start]
    if settings.start is None:
        starts += [random_node(embedding, rng) for _ in range(STARTS - 1)]
    trail, wanted = Trail(reader, start), settings.duration * embedding.graph.frame_rate - 1e-6
    floor = np.argwhere(embedding.covered().any(axis=2))
    prices = LinkPrices(embedding)
    played = np.zeros(len(embedding.graph.segments))
    while trail.frames < wanted:
        yield Progress(trail.frames / wanted, "Walking")
        chance = 1 + CHANCE * rng.random(len(played)) + AGAIN * played
        drawn = prices.with_segments(np.rint(chance * prices.of_segment).astype(np.int64))
        ways = []
        for _ in range(DRAWS):
            cells = _cells_around(embedding, floor, _next_place(embedding, floor, trail.node, rng))
            row, way, price = yield from _way_past(reader, drawn, starts, cells)
            ways.append((price / _seconds(embedding, way), row, way[: len(way) - LOOK_AHEAD]))
            if ways[-1][0] <= DEAR:
                break
        _, row, way = min(ways)
        if not trail.stencils:
            trail = Trail(reader, starts[row])
        for stencil in way:
            trail.take(stencil)
            played *= MEMORY
            played[trail.node[3]] += 1
            if trail.frames >= wanted:
                break
        starts = [trail.node]
    return trail.walk()


def _way_past(
    reader: LinkReader, prices: LinkPrices, starts: list[Node], cells: np.ndarray
) -> Generator[Progress, None, tuple[int, list[int], int]]:
    """Find the cheapest way from one of some nodes to some cells and on: its start, stencils and milliseconds."""
    embedding, rings = reader.embedding, []
    for ring, before in _rings(embedding, cells):
        yield Progress(0.0, "Walking")
        rings.append(ring)
        if any(_holds(embedding, before, node) for node in starts):
            break
    guide, limit = _RingGuide(embedding, rings, prices), len(rings) + MORE_SEGMENTS
    return (yield from cheapest_way_steps(reader, prices, guide, np.array(starts), limit, look_ahead=LOOK_AHEAD))


def _seconds(embedding: Embedding, way: list[int]) -> float:
    return sum(embedding.graph.segments[s].duration for s in embedding.unrolling.stencils.segment[way].tolist())


class _RingGuide:
    """The fewest segments from everywhere to the first of some rings."""

    n_goals = 1

    def __init__(self, embedding: Embedding, rings: list[NodeSet], prices: LinkPrices):
        self.spends = np.ones(len(embedding.graph.segments), dtype=np.int64)
        frames = [segment.n_frames - 1 for segment in embedding.graph.segments]
        self.unit_price = round(prices.usual * float(np.median(frames)))
        self._embedding = embedding
        self._rings = [PlaneBits(ring.planes, embedding.unrolling.layout.n_bytes) for ring in rings]

    def passed(self, stage: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        return np.maximum(stage, self._ring_of(nodes, 1) == 0)

    def left(self, stage: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        left = np.zeros(len(nodes), dtype=np.int64)
        here = np.flatnonzero(stage == 0)
        left[here] = self._ring_of(nodes[here], len(self._rings))
        return left

    def _ring_of(self, nodes: np.ndarray, n_rings: int) -> np.ndarray:
        """Return (n,) the ring that each of (n, 4) nodes is in; far more than there are if it is in none of the first
        ones."""
        layout, n_headings = self._embedding.unrolling.layout, self._embedding.shape[2]
        plane, bit = nodes[:, 3] * n_headings + nodes[:, 2], layout.bit(nodes[:, 0], nodes[:, 1])
        ring_of = np.full(len(nodes), np.iinfo(np.int32).max, dtype=np.int64)
        others = np.arange(len(nodes))
        for number, ring in enumerate(self._rings[:n_rings]):
            inside = ring.at(plane[others], bit[others])
            ring_of[others[inside]] = number
            others = others[~inside]
        return ring_of


def _next_place(embedding: Embedding, floor: np.ndarray, node: Node, rng: np.random.Generator) -> np.ndarray:
    """Choose a cell of the floor (n, 2) that is not too far from a node, around the edges of a tiled ground, too."""
    near = floor[_away(embedding, floor, np.array(node[:2])) <= FARTHEST]
    return near[rng.integers(len(near))]


def _cells_around(embedding: Embedding, floor: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """Return the cells of the floor (n, 2) near to one of them."""
    return floor[_away(embedding, floor, cell) <= NEAR]


def _away(embedding: Embedding, floor: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """Return (n,) metres of cells (n, 2) from one, around the edges of a tiled ground, too."""
    grid = embedding.environment.grid
    size = np.array(grid.shape[:2])
    away = np.abs(floor - cell % size)
    if grid.tiled:
        away = np.minimum(away, size - away)
    return np.hypot(*away.T) * grid.cell_size


def _rings(embedding: Embedding, cells: np.ndarray) -> Iterator[tuple[NodeSet, NodeSet]]:
    """Yield the nodes in some cells (n, 2), those that lead there by one link at the least, by two, and so on.

    Each with all nodes from which one link leads to it.
    """
    network, layout = embedding.network, embedding.unrolling.layout
    inside = np.zeros(embedding.shape[:2], dtype=bool)
    inside[tuple(cells.T)] = True
    ring = embedding.nodes.on(layout.pack(inside))
    farther = embedding.nodes - ring
    while ring:
        before = network.preimage(ring)
        yield ring, before
        ring = before & farther
        farther = farther - ring


def _holds(embedding: Embedding, nodes: NodeSet, node: Node) -> bool:
    """Test whether a set holds a node, whose place may be unwrapped."""
    nx, ny, n_headings, _ = embedding.shape
    x, y, heading, segment = node
    return bool(nodes.planes[segment * n_headings + heading] >> embedding.unrolling.layout.bit(x % nx, y % ny) & 1)
