"""Random walks that see much of the scene."""

import numpy as np

from ..embedding.embedding import Embedding
from ..errors import WalkError
from .walk import Walk, random_walk


def cells_visited(walk: Walk) -> int:
    """How many grid cells the root passes through."""
    return len(np.unique(walk.embedding.environment.grid.cells(walk.root_path[:, :2]), axis=0))


def widest_walk(
    embedding: Embedding,
    rng: np.random.Generator,
    duration: float,
    n_walks: int,
    start: tuple[int, int, int, int] | None = None,
) -> Walk:
    """Of ``n_walks`` random walks, the one that passes through the most cells.

    Each is a :func:`random_walk` and takes its links with equal probability; a repertoire with many ways to stand
    makes most of them rest more than they walk. The first walk is the one that ``random_walk`` makes of the same
    ``rng``. WalkError for less than one walk, and for the reasons of ``random_walk``.
    """
    if n_walks < 1:
        raise WalkError(f"{n_walks} walks leave nothing to choose from; ask for at least one.")
    walks = (random_walk(embedding, rng, duration, start) for _ in range(n_walks))
    return max(walks, key=cells_visited)
