"""SciPy's rotations, which the tests compute with: an algebra independent of :mod:`core.motion.quat`."""

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation


def as_rotation(quaternions: np.ndarray) -> Rotation:
    """(..., 4) quaternions (w, x, y, z) as one flat scipy Rotation."""
    return Rotation.from_quat(np.asarray(quaternions).reshape(-1, 4), scalar_first=True)


def as_quaternions(rotation: Rotation, shape: tuple[int, ...]) -> np.ndarray:
    """The rotations as quaternions (w, x, y, z) of shape ``shape`` + (4,)."""
    return rotation.as_quat(scalar_first=True).reshape(*shape, 4)


def matrices(turns: Iterable[np.ndarray]) -> list[np.ndarray]:
    """Some (F, 4) quaternions as (F, 3, 3) matrices."""
    return [as_rotation(quaternions).as_matrix() for quaternions in turns]
