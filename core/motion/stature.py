"""How large a character is: the measure that tolerances are given in."""

import numpy as np

from .skeleton import Skeleton


def rest_world(skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    """World rotations (J, 4) and joint positions (J, 3) in metres of the rest pose; read-only."""
    return skeleton.rest_world


def stature(skeleton: Skeleton) -> float:
    """Size of the rest pose in metres: its largest extent along an axis of the world, a person's height."""
    return max(float(np.ptp(rest_world(skeleton)[1], axis=0).max()), 1e-6)
