"""Trees of joints: their hierarchy, and forward kinematics from local transforms to world space and back."""

from collections.abc import Sequence

import numpy as np

from . import quat

FARTHEST = 1e6
"""Metres from the origin beyond which a position is a mistake, of units for example."""


def are_positions(points: np.ndarray) -> np.ndarray:
    """Test which of (..., 3) points are finite and not absurdly far away."""
    return np.all(np.abs(np.asarray(points, dtype=float)) <= FARTHEST, axis=-1)


def ancestors(parents: Sequence[int] | np.ndarray, joint: int) -> list[int]:
    """List the joints above one, nearest first; ``parents`` (J,) holds the index of each one's parent, or -1.

    >>> ancestors([-1, 0, 1, 0], 2)
    [1, 0]
    """
    found = []
    while (joint := int(parents[joint])) >= 0:
        found.append(joint)
    return found


def descendants(parents: Sequence[int] | np.ndarray, joint: int) -> list[int]:
    """List the joints that hang from one, itself left out, in ascending order.

    >>> descendants([-1, 0, 1, 0], 0)
    [1, 2, 3]
    """
    return [other for other in range(len(parents)) if joint in ancestors(parents, other)]


def world_transforms(
    rotations: np.ndarray, translations: np.ndarray, parents: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return world rotations (..., J, 4) and positions (..., J, 3) in metres from local ones of the same shapes.

    The root (joint 0) is already in world space; every other joint is relative to its parent.

    >>> rotations = quat.about("z", np.full(2, np.pi / 2))  # two bones that each turn to the left
    >>> world_transforms(rotations, np.array([[0, 0, 0], [1.0, 0, 0]]), np.array([-1, 0]))[1].round(6) + 0.0
    array([[0., 0., 0.],
           [0., 1., 0.]])
    """
    world_rotations = np.array(rotations, dtype=float)
    world_positions = np.array(translations, dtype=float)
    for joint in range(1, len(parents)):
        parent = world_rotations[..., parents[joint], :]
        moved = quat.rotate(parent, world_positions[..., joint, :])
        world_positions[..., joint, :] = world_positions[..., parents[joint], :] + moved
        world_rotations[..., joint, :] = quat.multiply(parent, world_rotations[..., joint, :])
    return world_rotations, world_positions


def local_transforms(
    world_rotations: np.ndarray, world_positions: np.ndarray, parents: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the local rotations (..., J, 4) and translations (..., J, 3): the inverse of :func:`world_transforms`."""
    above = np.asarray(parents)[1:]
    back = quat.inverse(world_rotations[..., above, :])
    rotations = np.array(world_rotations, dtype=float)
    translations = np.array(world_positions, dtype=float)
    rotations[..., 1:, :] = quat.multiply(back, world_rotations[..., 1:, :])
    translations[..., 1:, :] = quat.rotate(back, world_positions[..., 1:, :] - world_positions[..., above, :])
    return rotations, translations
