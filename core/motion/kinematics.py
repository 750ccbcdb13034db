"""Forward kinematics: from local joint transforms to world space."""

import numpy as np
from scipy.spatial.transform import Rotation

FARTHEST = 1e6
"""Metres from the origin beyond which a position is a mistake, of units for example."""


def are_rotations(quaternions: np.ndarray) -> np.ndarray:
    """(...,) bool: which of the (..., 4) quaternions are finite and of unit length (to single precision and a bit)."""
    quaternions = np.asarray(quaternions, dtype=float)
    # Clipped, because squares of what is far too long overflow; what is not a number is nowhere near one.
    return np.abs(np.linalg.norm(np.clip(quaternions, -9, 9), axis=-1) - 1) < 1e-3


def are_positions(points: np.ndarray) -> np.ndarray:
    """(...,) bool: which of the (..., 3) points are finite and not absurdly far away."""
    return np.all(np.abs(np.asarray(points, dtype=float)) <= FARTHEST, axis=-1)


def as_rotation(quaternions: np.ndarray) -> Rotation:
    """(..., 4) quaternions (w, x, y, z) as one flat scipy Rotation."""
    return Rotation.from_quat(np.asarray(quaternions).reshape(-1, 4), scalar_first=True)


def as_quaternions(rotation: Rotation, shape: tuple[int, ...]) -> np.ndarray:
    """The rotations as quaternions (w, x, y, z) of shape ``shape`` + (4,)."""
    return rotation.as_quat(scalar_first=True).reshape(*shape, 4)


def world_transforms(
    rotations: np.ndarray, translations: np.ndarray, parents: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """World rotations (F, J, 4) and positions (F, J, 3) in metres from local ones of the same shapes.

    The root (joint 0) is already in world space; every other joint is relative to its parent.
    """
    world_rotations = np.array(rotations, dtype=float)
    world_positions = np.array(translations, dtype=float)
    for joint in range(1, len(parents)):
        parent = as_rotation(world_rotations[:, parents[joint]])
        world_positions[:, joint] = world_positions[:, parents[joint]] + parent.apply(translations[:, joint])
        world_rotations[:, joint] = as_quaternions(parent * as_rotation(rotations[:, joint]), (len(world_rotations),))
    return world_rotations, world_positions
