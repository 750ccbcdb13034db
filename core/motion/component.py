"""The part of a motion graph that can be walked in for ever."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components


def largest_component(n_segments: int, links: np.ndarray) -> np.ndarray:
    """Find the (S,) bool mask of the segments of the largest strongly connected component of ``links`` (L, 2).

    Of equally large ones the one with most links. A component must hold a link, so that it can be walked in:
    all False if there is none.

    >>> largest_component(4, np.array([[0, 1], [1, 0], [1, 2], [3, 3]]))
    array([ True,  True, False, False])
    """
    if len(links) == 0:
        return np.zeros(n_segments, dtype=bool)
    # Thousands of small graphs are looked at while cutting: rows are made here, in the form that SciPy works
    # on, which takes a third of the time that its conversions take.
    source, target = links[:, 0], links[:, 1]
    rows = np.zeros(n_segments + 1, dtype=np.int32)
    np.cumsum(np.bincount(source, minlength=n_segments), out=rows[1:])
    columns = target[np.argsort(source, kind="stable")].astype(np.int32)
    adjacency = csr_matrix((np.ones(len(links)), columns, rows), shape=(n_segments, n_segments))
    _, label = connected_components(adjacency, directed=True, connection="strong")
    inner = label[source] == label[target]
    n_links = np.bincount(label[source[inner]], minlength=n_segments)
    n_members = np.bincount(label, minlength=n_segments) * (n_links > 0)
    best = np.lexsort((n_links, n_members))[-1]
    return (label == best) & (n_members[best] > 0)
