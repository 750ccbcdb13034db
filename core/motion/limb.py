"""Two-bone limbs: inverse kinematics in closed form."""

import numpy as np

from . import quat


def limb_frames(
    start: np.ndarray, end: np.ndarray, hinge: np.ndarray, upper: float, lower: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the world orientations of the two bones of a limb that reaches from ``start`` to ``end``.

    Parameters
    ----------
    start, end : (F, 3) float array
        Positions of the limb's first joint and of the tip of its second bone, in metres.
    hinge : (F, 3) float array
        The axis that the middle joint turns about, roughly; it is made perpendicular to the limb, which bends
        towards ``cross(hinge, end - start)``.
    upper, lower : float
        Lengths of the two bones in metres.

    Returns
    -------
    (F, 4), (F, 4) float arrays
        Quaternions that turn Y along the bone and X along the hinge. If ``end`` is out of reach, the limb points at
        it, stretched (or folded) as far as it goes.
    """
    span = end - start
    distance = np.linalg.norm(span, axis=-1)
    along = span / distance[:, None]
    axis = hinge - np.sum(hinge * along, axis=-1, keepdims=True) * along
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    bend = np.cross(axis, along)

    reach = np.clip(distance, abs(upper - lower) + 1e-9, upper + lower - 1e-9)
    first = np.arccos(np.clip((upper**2 + reach**2 - lower**2) / (2 * upper * reach), -1, 1))
    second = np.arccos(np.clip((lower**2 + reach**2 - upper**2) / (2 * lower * reach), -1, 1))

    def frame(angle: np.ndarray) -> np.ndarray:
        direction = np.cos(angle)[:, None] * along + np.sin(angle)[:, None] * bend
        return quat.from_matrix(np.stack([axis, direction, np.cross(axis, direction)], axis=-1))

    return frame(first), frame(-second)
