"""Variability and coverage (paper, section 4.1, equations 1 to 3)."""

import numpy as np

from ..embedding.embedding import Embedding


def segment_variability(embedding: Embedding) -> np.ndarray:
    """(nx, ny, n_headings, n_segments) int64: in-degree x out-degree of every node (eq. 1); 0 where there is none."""
    return embedding.in_degree().astype(np.int64) * embedding.out_degree()


def variability(embedding: Embedding) -> np.ndarray:
    """(nx, ny, n_headings) int64: segment variability summed over segments (eq. 2).

    The number of ways to come through p: pairs of a link that arrives there and a link that goes on.
    """
    return segment_variability(embedding).sum(axis=3)


def floor_variability(embedding: Embedding) -> np.ndarray:
    """(nx, ny) int64: variability summed over headings: the floor map of the paper's Fig. 1."""
    return variability(embedding).sum(axis=2)


def coverage(embedding: Embedding) -> np.ndarray:
    """(nx, ny, n_headings) bool: whether the character can pass through p (eq. 3).

    Variability is positive exactly where there is a node: in a strongly connected component, links lead to each of
    its nodes and from it.
    """
    return embedding.covered()


def coverage_share(embedding: Embedding) -> float:
    """Share of the free cells that the character can pass through in at least one heading; 0 if none is free."""
    free = embedding.environment.free_cells()
    covered = coverage(embedding).any(axis=2)
    return float(np.count_nonzero(covered & free) / max(np.count_nonzero(free), 1))
