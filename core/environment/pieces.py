"""Obstacles where they stand: shapes, which many of them may share, each with its place."""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .ground import fills_rectangle
from .solids import TurnedFaces, turned_faces


@dataclass(frozen=True, eq=False)
class Shape:
    """A mesh in its own space.

    Attributes
    ----------
    triangles : (T, 3, 3) float array
        Corners in metres: [triangle, corner, xyz].
    """

    triangles: np.ndarray

    @cached_property
    def digest(self) -> str:
        """Equal for equal triangles."""
        digest = hashlib.blake2b(repr((self.triangles.shape, self.triangles.dtype.str)).encode(), digest_size=16)
        digest.update(np.ascontiguousarray(self.triangles).data)
        return digest.hexdigest()

    @cached_property
    def bounds(self) -> np.ndarray:
        """(2, 3): lowest and highest coordinates in metres; the shape must have triangles."""
        corners = self.triangles.reshape(-1, 3)
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @cached_property
    def is_finite(self) -> bool:
        """True if every coordinate is a number."""
        return bool(np.isfinite(self.triangles).all())

    @cached_property
    def turned(self) -> TurnedFaces | None:
        """Faces that look into the closed part that they belong to, see :mod:`.solids`; None if none does."""
        return turned_faces(self.triangles)


@dataclass(frozen=True, eq=False)
class Piece:
    """A shape in the world.

    Attributes
    ----------
    shape : Shape
    matrix : (4, 4) float array
        From the shape's space to the world's, for columns (x, y, z, 1).
    """

    shape: Shape
    matrix: np.ndarray

    @cached_property
    def key(self) -> tuple[str, bytes]:
        """Equal for pieces with the same triangles in the world."""
        return self.shape.digest, np.ascontiguousarray(self.matrix, dtype=float).tobytes()

    @cached_property
    def bounds(self) -> np.ndarray:
        """(2, 3): lowest and highest world coordinates in metres; the shape must have triangles."""
        corners = self.triangles().reshape(-1, 3)
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @cached_property
    def fills_rectangle(self) -> bool:
        """True if the piece, seen from above, surely fills the rectangle that holds it; see :mod:`.ground`."""
        return fills_rectangle(self.triangles())

    @cached_property
    def farthest(self) -> float:
        """The largest world coordinate that it may reach along an axis, in metres; the shape must have triangles."""
        corners = np.stack(np.meshgrid(*self.shape.bounds.T), axis=-1).reshape(-1, 3)
        return float(np.abs(corners @ self.matrix[:3, :3].T + self.matrix[:3, 3]).max())

    def triangles(self) -> np.ndarray:
        """(T, 3, 3) world positions in metres; made anew each time, because they take much more than the shape.

        Faces that look outwards go on doing so where the matrix mirrors.
        """
        corners = self.shape.triangles.reshape(-1, 3) @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        triangles = corners.reshape(-1, 3, 3)
        mirrors = np.linalg.det(self.matrix[:3, :3]) < 0
        return np.ascontiguousarray(triangles[:, ::-1]) if mirrors else triangles


def all_triangles(pieces: Iterable[Piece]) -> np.ndarray:
    """Return (T, 3, 3) world positions in metres of the triangles of all pieces, in their order."""
    parts = [piece.triangles() for piece in pieces]
    return np.concatenate(parts) if parts else np.empty((0, 3, 3))


_ROOM = 0.5
"""Share of the ground from which on what looks inwards is a room around it."""


def solid_triangles(
    pieces: Iterable[Piece],
    corners: Sequence[Sequence[float]],
    heights: tuple[float, float] = (np.inf, -np.inf),
) -> np.ndarray:
    """Return the (T, 3, 3) triangles of :func:`all_triangles`, those of closed parts turned so that they look outwards.

    A part that looks inwards and holds most of the ground is a room around it, and stays as it is.

    Parameters
    ----------
    pieces : sequence of Piece
    corners : (2, 2) floats
        Lowest and highest x and y of the ground, in metres.
    heights : (low, high), optional
        Pieces that do not reach below and above these (m) are left as they are: there is nothing solid about them
        that their faces between the heights do not show.
    """
    parts = []
    for piece in pieces:
        triangles = piece.triangles()
        z = triangles[..., 2]
        reaches = z.min(initial=np.inf) < heights[0] and z.max(initial=-np.inf) > heights[1]
        if reaches and piece.shape.is_finite:
            turned = _outwards(piece.shape.turned, triangles, np.asarray(corners, dtype=float))
            triangles[turned] = triangles[turned][:, ::-1]
        parts.append(triangles)
    return np.concatenate(parts) if parts else np.empty((0, 3, 3))


def _outwards(faces: TurnedFaces | None, triangles: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(T,) bool: the faces to turn of a piece with these (T, 3, 3) world triangles."""
    if faces is None:
        return np.zeros(len(triangles), dtype=bool)
    part, xy = faces.inside_out, triangles[..., :2]
    low = np.full((part.max() + 2, 2), np.inf)
    high = -low
    np.minimum.at(low, part, xy.min(axis=1))
    np.maximum.at(high, part, xy.max(axis=1))
    held = np.prod(np.clip(np.minimum(high, corners[1]) - np.maximum(low, corners[0]), 0, None), axis=1)
    is_room = held > _ROOM * np.prod(corners[1] - corners[0])
    is_room[-1] = False  # what is no part that looks inwards as a whole
    return faces.turned & ~is_room[part]
