"""T-poses and rest poses that precede or follow the motion."""

import numpy as np

from .. import quat
from ..clip import MotionClip
from ..joint_roles import JointRole

_REST_ANGLE = np.radians(8.0)
_REST_SHARE = 0.85
"""Share of the animated joints that are within the angle above of their rest rotation in a rest pose."""
_T_COSINE = 0.9
"""Cosine of the angle up to which arms point to the side in a T-pose."""
_JUMP = 0.06
"""Statures that some joint jumps, as seen from the root, where the motion begins."""
_RATIO = 3.0
"""How many times larger the jump is than the steps after it."""


def rest_frames(clip: MotionClip) -> list[tuple[int, int]]:
    """Find (first, last) of rest poses or T-poses at the start and at the end of the clip, if the motion jumps there.

    A motion that comes gently out of its rest pose is not found.
    """
    at_rest = _like_rest(clip) | _like_t(clip)
    if at_rest.all() or not at_rest[[0, -1]].any():
        return []
    rotations, positions = clip.world
    local = quat.rotate(quat.inverse(rotations[:, :1]), positions - positions[:, :1])
    steps = np.linalg.norm(np.diff(local, axis=0), axis=2).max(axis=1) / clip.skeleton.stature
    found = []
    if at_rest[0]:
        end = int(np.argmin(at_rest))
        if _stands_out(steps[end - 1], steps[end : end + 6]):
            found.append((0, end - 1))
    if at_rest[-1]:
        start = clip.n_frames - int(np.argmin(at_rest[::-1]))
        if _stands_out(steps[start - 1], steps[max(start - 7, 0) : start - 1]):
            found.append((start, clip.n_frames - 1))
    return found


def _stands_out(step: float, others: np.ndarray) -> bool:
    return bool(step > _JUMP and (len(others) == 0 or step > _RATIO * np.median(others)))


def _like_rest(clip: MotionClip) -> np.ndarray:
    """(F,) bool: most joints that the clip animates are as in the rest pose; the root may be anywhere."""
    off = quat.angle_between(clip.rotations, clip.skeleton.rest_rotations)[:, 1:]
    animated = off.max(axis=0) > _REST_ANGLE
    if not animated.any():
        return np.zeros(clip.n_frames, dtype=bool)
    return np.mean(off[:, animated] < _REST_ANGLE, axis=1) >= _REST_SHARE


def _like_t(clip: MotionClip) -> np.ndarray:
    """(F,) bool: both arms point straight to their sides; False throughout if no arms are known."""
    roles, positions = clip.skeleton.roles, clip.world[1]
    heading = clip.ground_path[:, 2]
    left = np.column_stack([-np.sin(heading), np.cos(heading), 0 * heading])
    result = np.ones(clip.n_frames, dtype=bool)
    for side, sign in (("left", 1), ("right", -1)):
        if not {(JointRole.UPPER_ARM, side), (JointRole.LOWER_ARM, side)} <= roles.keys():
            return np.zeros(clip.n_frames, dtype=bool)
        upper, lower = (roles[role, side][0] for role in (JointRole.UPPER_ARM, JointRole.LOWER_ARM))
        hands = np.flatnonzero(clip.skeleton.parents == lower)
        for start, end in ((upper, lower), *((lower, hand) for hand in hands[:1])):
            bone = positions[:, end] - positions[:, start]
            result &= sign * np.sum(bone * left, axis=1) > _T_COSINE * np.linalg.norm(bone, axis=1)
    return result
