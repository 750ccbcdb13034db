"""Wandering: walks that go from place to place, so that every part of the floor is visited alike.

A random walk takes each link with the same probability and stays where many links are: near a wall, where all that a
character can do is to stand and turn, it may shuffle for a minute. A wanderer draws a place on the covered floor, goes
there by as few segments as it can, draws the next, and so on.
"""

from collections.abc import Generator, Iterator

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import Node
from ..embedding.node_set import NodeSet
from ..progress import Progress
from .walk import Trail, Walk, WalkSettings, begin

#: Metres from one place to the next at the most: on large grounds the way to a far one costs more than it shows.
FARTHEST = 10.0


def wandering_walk_steps(
    embedding: Embedding, rng: np.random.Generator, settings: WalkSettings
) -> Generator[Progress, None, Walk]:
    """Walk through places drawn evenly from the covered floor around.

    Among the links that lead to the next place by the fewest segments, each is taken with the same probability.

    Raises
    ------
    WalkError
        The embedding is empty, or the start is no node of it.
    """
    reader, start = begin(embedding, rng, settings.start)
    trail, wanted = Trail(reader, start), settings.duration * embedding.graph.frame_rate - 1e-6
    floor = np.argwhere(embedding.covered().any(axis=2))
    while trail.frames < wanted:
        rings = []
        for ring in _rings(embedding, _next_place(embedding, floor, trail.node, rng)):
            yield Progress(trail.frames / wanted, "Walking")
            rings.append(ring)
            if _holds(embedding, ring, trail.node):
                break
        # One step at least, even if the place drawn is the one where the wanderer stands.
        for ring in rings[-2::-1] or [None]:
            choices = [
                k
                for k in reader.stencils_from(trail.node).tolist()
                if ring is None or _holds(embedding, ring, reader.follow(trail.node, k))
            ]
            trail.take(choices[int(rng.integers(len(choices)))])
            if trail.frames >= wanted:
                break
    return trail.walk()


def _next_place(embedding: Embedding, floor: np.ndarray, node: Node, rng: np.random.Generator) -> np.ndarray:
    """Choose a cell of the floor (n, 2) that is not too far from a node, around the edges of a tiled ground, too."""
    grid = embedding.environment.grid
    size = np.array(grid.shape[:2])
    away = np.abs(floor - np.array(node[:2]) % size)
    if grid.tiled:
        away = np.minimum(away, size - away)
    near = floor[np.hypot(*away.T) * grid.cell_size <= FARTHEST]
    return near[rng.integers(len(near))]


def _rings(embedding: Embedding, cell: np.ndarray) -> Iterator[NodeSet]:
    network = embedding.network
    ring = embedding.nodes.on(1 << embedding.unrolling.layout.bit(*cell.tolist()))
    farther = embedding.nodes - ring
    while ring:
        yield ring
        ring = network.preimage(ring) & farther
        farther = farther - ring


def _holds(embedding: Embedding, nodes: NodeSet, node: Node) -> bool:
    """Test whether a set holds a node, whose place may be unwrapped."""
    nx, ny, n_headings, _ = embedding.shape
    x, y, heading, segment = node
    return bool(nodes.planes[segment * n_headings + heading] >> embedding.unrolling.layout.bit(x % nx, y % ny) & 1)
