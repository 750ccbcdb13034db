"""Wandering: walks that go from place to place, so that every part of the floor is visited alike.

A random walk takes each link with the same probability and stays where many links are: near a wall, where all that a
character can do is to stand and turn, it may shuffle for a minute. A wanderer draws a place on the covered floor, goes
there by as few segments as it can, draws the next, and so on.
"""

from collections.abc import Iterator

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.network import Nodes, difference, intersection
from ..errors import WalkError
from .walk import LinkReader, Node, Walk, random_node


def wandering_walk(embedding: Embedding, rng: np.random.Generator, duration: float, start: Node | None = None) -> Walk:
    """A walk of at least ``duration`` seconds through places drawn evenly from the covered floor.

    Among the links that lead to the next place by the fewest segments, each is taken with the same probability.

    Parameters
    ----------
    start : (x, y, heading, segment), optional
        Node to start from; a random one by default.

    Raises
    ------
    WalkError
        The embedding is empty, ``start`` is no node of it, or the duration is not positive.
    """
    if not (np.isfinite(duration) and duration > 0):
        raise WalkError(f"A walk of {duration} s cannot be played; give a positive duration.")
    reader = LinkReader(embedding)
    state = random_node(embedding, rng) if start is None else start
    if not reader.is_node(state):
        raise WalkError("The walk's start is no node of the embedding; choose a place inside the covered area.")
    segments, frame_rate = embedding.graph.segments, embedding.graph.frame_rate
    floor = np.argwhere(embedding.covered().any(axis=2))
    states, stencils, frames = [state], [], 0
    while frames < duration * frame_rate - 1e-6:
        rings = _rings_around(embedding, floor[rng.integers(len(floor))], state)
        # One step at least, even if the place drawn is the one where the wanderer stands.
        for ring in rings[-2::-1] or [None]:
            choices = [
                k
                for k in reader.stencils_from(state)
                if ring is None or _holds(embedding, ring, reader.follow(state, k))
            ]
            stencil = choices[int(rng.integers(len(choices)))]
            state = reader.follow(state, stencil)
            frames += segments[state[3]].n_frames - 1
            states.append(state)
            stencils.append(stencil)
            if frames >= duration * frame_rate - 1e-6:
                break
    return Walk(embedding, np.array(states), np.array(stencils))


def _rings_around(embedding: Embedding, cell: np.ndarray, start: Node) -> list[Nodes]:
    """Sets of the nodes that are 0, 1, 2, ... links away from a cell (x, y), up to the one that holds ``start``."""
    rings = []
    for ring in _rings(embedding, cell):
        rings.append(ring)
        if _holds(embedding, ring, start):
            break
    return rings


def _rings(embedding: Embedding, cell: np.ndarray) -> Iterator[Nodes]:
    network, layout = embedding.network, embedding.unrolling.layout
    there = 1 << layout.bit(*cell.tolist())
    ring = network.bundles([plane & there for plane in embedding.planes])
    farther = difference(network.bundles(list(embedding.planes)), ring)
    while any(ring):
        yield ring
        ring = intersection(network.preimage(ring), farther)
        farther = difference(farther, ring)


def _holds(embedding: Embedding, nodes: Nodes, node: Node) -> bool:
    """Whether a set holds a node, whose place may be unwrapped."""
    network, (nx, ny, _, _) = embedding.network, embedding.shape
    x, y, heading, segment = node
    block, place = divmod(heading, network.bundled)
    bit = place * network.plane_bytes * 8 + embedding.unrolling.layout.bit(x % nx, y % ny)
    return bool(nodes[segment * network.n_blocks + block] >> bit & 1)
