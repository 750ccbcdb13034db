"""Quaternions: all algebra of rotations, over arrays.

A rotation is a unit quaternion (w, x, y, z), an array of them has shape (..., 4), and shapes broadcast. Rotations act
on column vectors: ``multiply(a, b)`` turns by ``b`` first, then by ``a``. ``q`` and ``-q`` are the same rotation.
Products are brought to unit length, and all else accepts quaternions of any length but zero.
"""

from functools import reduce

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
IDENTITY.flags.writeable = False


def are_rotations(q: ArrayLike) -> np.ndarray:
    """Test which of (..., 4) quaternions are finite and of unit length, to single precision and a bit."""
    # Clipped, because squares of what is far too long overflow; what is not a number is nowhere near one.
    return np.abs(np.linalg.norm(np.clip(np.asarray(q, dtype=float), -9, 9), axis=-1) - 1) < 1e-3


def normalized(q: np.ndarray) -> np.ndarray:
    """Return (..., 4) quaternions at unit length."""
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def multiply(*factors: ArrayLike) -> np.ndarray:
    """Return (..., 4) the Hamilton product, at unit length: the turn by the last of the factors first.

    >>> quarter = about("z", np.pi / 2)
    >>> multiply(quarter, quarter).round(6) + 0.0
    array([0., 0., 0., 1.])
    """
    return normalized(reduce(_product, map(np.asarray, factors)))


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w, x, y, z = np.moveaxis(a, -1, 0)
    ow, ox, oy, oz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            w * ow - x * ox - y * oy - z * oz,
            w * ox + x * ow + y * oz - z * oy,
            w * oy - x * oz + y * ow + z * ox,
            w * oz + x * oy - y * ox + z * ow,
        ],
        axis=-1,
    )


def inverse(q: ArrayLike) -> np.ndarray:
    """Return (..., 4) the rotations back."""
    return np.asarray(q) * (1.0, -1.0, -1.0, -1.0)


def rotate(q: ArrayLike, vectors: ArrayLike) -> np.ndarray:
    """Return (..., 3) the ``vectors``, turned.

    >>> rotate(about("z", np.pi / 2), [[1, 0, 0], [0, 0, 2]]).round(6) + 0.0
    array([[0., 1., 0.],
           [0., 0., 2.]])
    """
    w, x, y, z = np.moveaxis(np.asarray(q), -1, 0)
    vx, vy, vz = np.moveaxis(np.asarray(vectors), -1, 0)
    # v + 2 w (u x v) + 2 u x (u x v), for quaternions of any length
    twice = 2 / (w * w + x * x + y * y + z * z)
    tx, ty, tz = twice * (y * vz - z * vy), twice * (z * vx - x * vz), twice * (x * vy - y * vx)
    return np.stack(
        [vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx], axis=-1
    )


def about(axis: str, angles: ArrayLike) -> np.ndarray:
    """Return (..., 4) the turns about the coordinate axis "x", "y" or "z" by (...,) angles in radians."""
    half = np.asarray(angles, dtype=float) / 2
    q = np.zeros((*half.shape, 4))
    q[..., 0], q[..., 1 + "xyz".index(axis)] = np.cos(half), np.sin(half)
    return q


def between(start: ArrayLike, end: ArrayLike) -> np.ndarray:
    """Return (..., 4) the smallest turns that bring (..., 3) directions to others, which are not opposite to them."""
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (np.asarray(start), np.asarray(end)))
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    return normalized(np.concatenate([1 + cosine, np.cross(a, b)], axis=-1))


def angle(q: ArrayLike) -> np.ndarray:
    """Return (...,) radians, 0 to pi, that the rotations turn by.

    >>> float(angle(about("x", -0.5)))
    0.5
    """
    q = np.asarray(q)
    return 2 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0]))


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return (...,) radians between unit quaternions; from the chord, because an arccos loses small angles."""
    chord = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return 4 * np.arcsin(np.minimum(chord / 2, 1.0))


def twist(q: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return (...,) radians that rotations turn by about a (3,) unit axis, what they tilt it by left out."""
    return 2 * np.arctan2(q[..., 1:] @ axis, q[..., 0])


def from_rotvec(vectors: ArrayLike) -> np.ndarray:
    """Return (..., 4) the turns about (..., 3) vectors by their lengths in radians: the exponential map.

    >>> from_rotvec([0, 0, np.pi]).round(6)
    array([0., 0., 0., 1.])
    """
    vectors = np.asarray(vectors, dtype=float)
    half = np.linalg.norm(vectors, axis=-1, keepdims=True) / 2
    return np.concatenate([np.cos(half), np.sinc(half / np.pi) / 2 * vectors], axis=-1)


def to_rotvec(q: ArrayLike) -> np.ndarray:
    """Return (..., 3) rotation vectors, at most pi long: the logarithm.

    >>> to_rotvec(from_rotvec([[0.1, 0.2, -0.3], [0, 0, 0]])).round(6)
    array([[ 0.1,  0.2, -0.3],
           [ 0. ,  0. ,  0. ]])
    """
    q = np.asarray(q, dtype=float)
    w, xyz = q[..., :1], q[..., 1:]
    sine = np.linalg.norm(xyz, axis=-1, keepdims=True)
    turn = 2 * np.arctan2(sine, np.abs(w))
    # The limit of angle / sin(angle / 2) is 2.
    return np.where(w < 0, -1, 1) * np.divide(turn, sine, out=np.full_like(sine, 2.0), where=sine > 0) * xyz


def rotvec_rate(vectors: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return (..., 3) rates of rotation vectors whose rotations have angular velocities ``omega`` in their own frames.

    The inverse of the right Jacobian of SO(3) (Solà et al. 2018, "A micro Lie theory", eq. 144).
    """
    turn = np.linalg.norm(vectors, axis=-1, keepdims=True)
    small = turn < 1e-4
    safe = np.where(small, 1.0, turn)
    factor = np.where(small, 1 / 12, 1 / safe**2 - 1 / (2 * safe * np.tan(safe / 2)))
    turned = np.cross(vectors, omega)
    return omega + turned / 2 + factor * np.cross(vectors, turned)


def from_matrix(matrices: ArrayLike) -> np.ndarray:
    """Return (..., 4) the rotations that (..., 3, 3) orthogonal matrices stand for; columns are the turned axes."""
    matrices = np.asarray(matrices, dtype=float)
    return Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat(scalar_first=True).reshape(*matrices.shape[:-2], 4)


def to_matrix(q: ArrayLike) -> np.ndarray:
    """Return (..., 3, 3) rotation matrices.

    >>> to_matrix(about("z", np.pi / 2)).round(6) + 0.0
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    return np.stack([rotate(q, axis) for axis in np.eye(3)], axis=-1)


def from_euler(order: str, angles: ArrayLike) -> np.ndarray:
    """Return (..., 4) the turns about axes by (..., n) angles in radians.

    ``order`` are the axes: in capitals those that turn along ("YXZ": about Y, then the new X, then the new Z), in
    small letters the fixed ones.

    >>> from_euler("Z", [np.pi]).round(6)
    array([0., 0., 0., 1.])
    """
    angles = np.asarray(angles, dtype=float)
    turns = [about(axis.lower(), angles[..., place]) for place, axis in enumerate(order)]
    return multiply(*turns) if order.isupper() else multiply(*reversed(turns))


def to_euler(order: str, q: ArrayLike) -> np.ndarray:
    """Return (..., 3) angles in radians of :func:`from_euler`; the third is zero in gimbal lock."""
    q = np.asarray(q)
    angles = Rotation.from_quat(q.reshape(-1, 4), scalar_first=True).as_euler(order, suppress_warnings=True)
    return angles.reshape(*q.shape[:-1], 3)


def slerp(start: np.ndarray, end: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return (..., 4) quaternions on the shorter arc from ``start`` to ``end``, ``weight`` (..., 1) of the way.

    >>> float(angle(slerp(IDENTITY, about("y", 1.0), np.array([0.25]))).round(6))
    0.25
    """
    cosine = np.einsum("...c,...c->...", start, end)[..., None]
    # The half angle from its tangent, because an arccos would lose the digits of small angles.
    sine = np.linalg.norm(end * np.where(cosine < 0, -1, 1) - start * np.abs(cosine), axis=-1, keepdims=True)
    half = np.arctan2(sine, np.abs(cosine))
    from_start = np.sinc((1 - weight) * half / np.pi) * (1 - weight)
    from_end = np.sinc(weight * half / np.pi) * weight * np.where(cosine < 0, -1, 1)
    return normalized(from_start * start + from_end * end)


def mean(q: np.ndarray) -> np.ndarray:
    """Return (4,) the mean of (N, 4) rotations (Markley et al. 2007): the first eigenvector of their moments."""
    return np.linalg.eigh(q.T @ q)[1][:, -1]


def continuous(q: np.ndarray) -> np.ndarray:
    """Return the rotations (F, ..., 4) with each quaternion in the hemisphere of the one before it.

    >>> continuous(np.array([[1.0, 0, 0, 0], [-1.0, 0, 0, 0]]))[1] + 0.0
    array([1., 0., 0., 0.])
    """
    flips = np.where(np.sum(q[1:] * q[:-1], axis=-1, keepdims=True) < 0, -1.0, 1.0)
    return np.concatenate([q[:1], q[1:] * np.cumprod(flips, axis=0)])


def mirrored(q: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return (..., 4) M R M of the reflection M in a plane with a (3,) unit normal: the axis mirrored, the turn too."""
    return np.concatenate([q[..., :1], -reflected(q[..., 1:], normal)], axis=-1)


def reflected(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return (..., 3) vectors reflected in the plane through the origin with a (3,) unit normal."""
    return vectors - 2 * (vectors @ normal)[..., None] * normal
