"""Walks beside the embedding written out: is every step one of its links?"""

import numpy as np

from core.embedding.embedding import Embedding
from core.embedding.node_set import NodeSet
from core.playback.walk import Walk


def some_nodes(embedding: Embedding, rows: np.ndarray) -> NodeSet:
    """The set of (n, 4) nodes x, y, heading, segment."""
    _, ny, n_headings, _ = embedding.shape
    return embedding.network.nodes(
        np.column_stack([rows[:, 3] * n_headings + rows[:, 2], rows[:, 0] * ny + rows[:, 1]])
    )


def assert_links(walk: Walk) -> None:
    """Every step of the walk is a link of its embedding: bit by bit, from the planes themselves."""
    embedding = walk.embedding
    layout, stencils = embedding.unrolling.layout, embedding.unrolling.stencils
    nx, ny, n_headings, _ = embedding.shape
    linked = set(map(tuple, embedding.graph.links.tolist()))

    def is_set(plane: int, x: int, y: int) -> bool:
        if not embedding.environment.grid.tiled:
            assert 0 <= x < nx and 0 <= y < ny
        return bool(layout.unpack(plane)[x % nx, y % ny])

    assert len(walk.states) == len(walk.stencils) + 1
    for (x, y, heading, segment), (x2, y2, heading2, segment2), k in zip(
        walk.states[:-1].tolist(), walk.states[1:].tolist(), walk.stencils.tolist(), strict=True
    ):
        assert (segment, segment2) in linked
        assert (stencils.segment[k], stencils.heading[k]) == (segment2, heading)
        assert (stencils.dx[k], stencils.dy[k]) == (x2 - x, y2 - y)
        assert stencils.destination_heading[k] == heading2
        assert is_set(embedding.unrolling.valid[k], x, y)
        assert is_set(embedding.planes[segment * n_headings + heading], x, y)
        assert is_set(embedding.planes[segment2 * n_headings + heading2], x2, y2)
