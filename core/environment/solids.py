"""Solids: the closed parts of a mesh, and which way their faces look."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


@dataclass(frozen=True)
class TurnedFaces:
    """Faces of closed parts that look inwards.

    Attributes
    ----------
    turned : (T,) bool array
        True for each triangle that looks into the part that it belongs to.
    inside_out : (T,) int array
        The number of the part, from 0 on, for all triangles of parts that look inwards as a whole; -1 for others.
    """

    turned: np.ndarray
    inside_out: np.ndarray


def turned_faces(triangles: np.ndarray) -> TurnedFaces | None:
    """Return which of (T, 3, 3) triangles look into the closed part of the mesh that they belong to; None if none does.

    Triangles hang together at edges that two of them share, corner by corner at the same place. A part is closed if
    none of its edges belongs to one triangle alone, and looks outwards if it has a volume when all its triangles are
    turned to agree with each other.
    """
    n = len(triangles)
    corners = _places(triangles.reshape(-1, 3)).reshape(-1, 3)
    start, stop = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    face, forwards = np.repeat(np.arange(n), 3), start < stop
    edge = np.minimum(start, stop) * (corners.max(initial=0) + 1) + np.maximum(start, stop)
    order = np.argsort(edge, kind="stable")
    first = np.flatnonzero(np.diff(edge[order], prepend=-1))
    count = np.diff(first, append=len(order))
    pair = first[count == 2]
    a, b = order[pair], order[pair + 1]
    # Each triangle twice, as it is and turned round; those that agree hang together.
    unlike = (forwards[a] == forwards[b]) * n
    ends = np.concatenate([face[a], face[a] + n]), np.concatenate([face[b] + unlike, face[b] + n - unlike])
    links = coo_array((np.ones(len(ends[0]), dtype=bool), ends), shape=(2 * n, 2 * n))
    n_parts, part = connected_components(links, directed=False)
    # A part and the same part turned round; where they are one, it has no two sides.
    kept, round_ = part[:n], part[n:]
    open_ = np.zeros(n_parts, dtype=bool)
    open_[kept[face[order[np.repeat(count % 2 == 1, count)]]]] = True
    volume = np.bincount(kept, _volumes(triangles, kept), n_parts)
    volume -= np.bincount(round_, _volumes(triangles, kept), n_parts)
    closed = ~open_[kept] & ~open_[round_] & (kept != round_)
    turned = closed & (volume[kept] < 0)
    if not turned.any():
        return None
    # Most of such a part looks inwards: that may be meant, see .pieces.
    whole = np.minimum(kept, round_)
    n_turned, size = np.bincount(whole, turned, n_parts), np.bincount(whole, minlength=n_parts)
    inward = closed & (2 * n_turned > size)[whole]
    inside_out = np.full(n, -1)
    inside_out[inward] = np.unique(whole[inward], return_inverse=True)[1]
    return TurnedFaces(turned, inside_out)


def _places(points: np.ndarray) -> np.ndarray:
    """(n,) the same number for the same place (n, 3)."""
    bits = np.ascontiguousarray(points + 0.0, dtype=float).view(np.uint64)  # no negative zero
    mixed = np.zeros(len(points), dtype=np.uint64)
    for column in bits.T:
        # Odd multipliers and shifts, as in SplitMix64: sorting numbers is ten times as fast as sorting places.
        mixed = (mixed ^ column) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0x94D049BB133111EB)
        mixed ^= mixed >> np.uint64(32)
    return np.unique(mixed, return_inverse=True)[1]


def _volumes(triangles: np.ndarray, part: np.ndarray) -> np.ndarray:
    """(T,) six times the volume between each triangle and a point near its part."""
    first = np.full(part.max(initial=0) + 1, -1)
    first[part[::-1]] = np.arange(len(part))[::-1]
    moved = triangles - triangles[first[part], :1]
    return np.einsum("ij,ij->i", moved[:, 0], np.cross(moved[:, 1], moved[:, 2]))
