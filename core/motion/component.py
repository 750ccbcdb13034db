"""The part of a motion graph that can be walked in for ever."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components


def largest_component(n_segments: int, links: np.ndarray) -> np.ndarray:
    """(S,) bool: the segments of the largest strongly connected component of ``links`` (L, 2).

    Of equally large ones the one with most links. A component must hold a link, so that it can be walked in:
    all False if there is none.
    """
    if len(links) == 0:
        return np.zeros(n_segments, dtype=bool)
    ones = np.ones(len(links), dtype=np.int8)
    adjacency = csr_matrix((ones, (links[:, 0], links[:, 1])), shape=(n_segments, n_segments))
    _, label = connected_components(adjacency, directed=True, connection="strong")
    inner = label[links[:, 0]] == label[links[:, 1]]
    n_links = np.bincount(label[links[inner, 0]], minlength=n_segments)
    n_members = np.bincount(label, minlength=n_segments) * (n_links > 0)
    best = np.lexsort((n_links, n_members))[-1]
    return (label == best) & (n_members[best] > 0)
