"""Blender's rotation channels as quaternions, and back as curves without jumps; arrays only, no Blender."""

import numpy as np

from ...core.motion import quat

LINEAR_MODES = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
REST_CHANNELS = {
    "location": (0.0, 0.0, 0.0),
    "rotation_quaternion": (1.0, 0.0, 0.0, 0.0),
    "rotation_axis_angle": (0.0, 0.0, 1.0, 0.0),
    "rotation_euler": (0.0, 0.0, 0.0),
    "scale": (1.0, 1.0, 1.0),
}
"""Values of Blender's transform channels in the rest pose."""


def rotation_property(mode: str) -> str:
    """Name of the property that Blender reads in a rotation mode ('QUATERNION', 'AXIS_ANGLE', 'XYZ' ...)."""
    return LINEAR_MODES.get(mode, "rotation_euler")


def quaternions_from_channels(mode: str, values: np.ndarray) -> np.ndarray:
    """(..., 4) unit quaternions (w, x, y, z) of (..., C) channel values.

    C is 4 for quaternions (w, x, y, z) and axis-angle (angle, x, y, z), 3 for Euler angles (x, y, z whatever
    the order of rotation). Values need not be normalised: as in Blender, quaternions and axes are.
    """
    if mode == "QUATERNION":
        length = np.linalg.norm(values, axis=-1, keepdims=True)
        # Blender's own convention for a quaternion of zeros: half a turn about X.
        return np.where(length > 0, values / np.where(length > 0, length, 1.0), (0.0, 1.0, 0.0, 0.0))
    if mode == "AXIS_ANGLE":
        length = np.linalg.norm(values[..., 1:], axis=-1, keepdims=True)
        axis = values[..., 1:] / np.where(length > 0, length, 1.0)
        half = values[..., :1] / 2
        turned = np.concatenate([np.cos(half), np.sin(half) * axis], axis=-1)
        return np.where(length > 0, turned, (1.0, 0.0, 0.0, 0.0))
    # Blender's 'XYZ' turns about the fixed X first, then about Y, then about Z.
    return quat.from_euler(mode.lower(), values[..., ["XYZ".index(axis) for axis in mode]])


def channels_from_quaternions(mode: str, quaternions: np.ndarray) -> np.ndarray:
    """(F, C) channel values of (F, 4) unit quaternions (w, x, y, z), continuous from frame to frame.

    The inverse of :func:`quaternions_from_channels`: quaternions keep their hemisphere, axes their side,
    Euler angles are unwrapped and follow whichever of their two solutions lies nearer to the frame before.
    """
    quaternions = quat.continuous(-quaternions if quaternions[0, 0] < 0 else quaternions)
    if mode == "QUATERNION":
        return quaternions
    if mode == "AXIS_ANGLE":
        return _axis_angles(quaternions)
    return _euler_angles(mode, quaternions)


def _axis_angles(quaternions):
    sine = np.linalg.norm(quaternions[:, 1:], axis=1)
    # Where there is no rotation there is no axis: take the last one, at the start the first one.
    turned = sine > 1e-7
    if not turned.any():
        return np.tile(REST_CHANNELS["rotation_axis_angle"], (len(sine), 1))
    source = np.maximum.accumulate(np.where(turned, np.arange(len(sine)), np.argmax(turned)))
    axes = (quaternions[:, 1:] / np.where(turned, sine, 1.0)[:, None])[source]
    sides = np.where(np.sum(axes[1:] * axes[:-1], axis=1) < 0, -1.0, 1.0)
    sides = np.concatenate([[1.0], np.cumprod(sides)])
    angles = np.unwrap(2 * np.arctan2(sides * sine, quaternions[:, 0]))
    return np.column_stack([angles, axes * sides[:, None]])


def _euler_angles(mode, quaternions):
    first = quat.to_euler(mode.lower(), quaternions)
    second = np.column_stack([first[:, 0] + np.pi, np.pi - first[:, 1], first[:, 2] + np.pi])
    # From either solution the other one of the next frame is equally far, so whether to change over is a
    # question about pairs of frames only, and the state is the parity of the changes so far.
    stay = np.abs(_wrapped(first[1:] - first[:-1])).sum(axis=1)
    change = np.abs(_wrapped(second[1:] - first[:-1])).sum(axis=1)
    use_second = np.concatenate([[False], np.cumsum(change < stay) % 2 == 1])
    angles = np.unwrap(np.where(use_second[:, None], second, first), axis=0)
    values = np.empty_like(angles)
    values[:, ["XYZ".index(axis) for axis in mode]] = angles
    return values


def _wrapped(angles):
    return (angles + np.pi) % (2 * np.pi) - np.pi
