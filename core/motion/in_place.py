"""Root motion for clips that walk on the spot: the ground is where the standing foot is."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from ..errors import ClipError
from . import quat
from .clip import MotionClip
from .contacts import FLOOR_PERCENTILE, Feet, foot_joints

_TOUCH_HEIGHT = 0.006
"""Height above its floor, as a share of the character's stature, at which a joint bears little weight any more."""
_CLIMB_SPEED = 0.2
"""Vertical speed, in statures per second, at which a joint is not standing but landing or leaving."""
_CLIMB_SHARE = 0.15
"""The same as a share of the speed at which feet pass under the root: who runs lands and leaves faster."""
_FINER = 3
"""Steps looked at from each frame to the next: a run at 30 frames per second stands for two or three frames only."""
_STANDS = 0.02
"""Weight on the ground from which a foot stands; between such moments its motion is interpolated."""


def stance_steps(clip: MotionClip, feet: Feet | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Measure how the standing foot moves over the ground from each frame to the next.

    On the spot it slides back at the speed at which the character should go forward; where the root travels as it
    should, it does not move. How low a joint of a foot is, not how slow, says how much weight it bears, which
    passes smoothly from joint to joint and from foot to foot. Between frames the feet go on along splines.

    Parameters
    ----------
    clip : MotionClip
    feet : pair of tuple of str, optional
        Bone names of the left and the right foot, ankle first, then toes; guessed if not given.

    Returns
    -------
    moves : (F - 1, 2) float array
        x and y in metres, in world space; in flight interpolated over time from stance to stance.
    turns : (F - 1,) float array
        Radians about Z that the standing foot turns.

    Raises ClipError if the skeleton has no feet that can be recognized, or if neither of them ever stands.
    """
    chains = foot_joints(clip.skeleton, feet)
    joints = [joint for chain in chains for joint in chain]
    rotations, points, root = _finer(clip, joints)
    rate, size = clip.frame_rate * _FINER, clip.skeleton.stature
    height = points[..., 2] - np.percentile(points[..., 2], FLOOR_PERCENTILE, axis=0)
    bearing = np.exp(-((np.maximum(height, 0) / (_TOUCH_HEIGHT * size)) ** 2))
    passing = np.linalg.norm(np.diff(points[..., :2] - root[:, None, :2], axis=0), axis=2) * rate
    limit = max(_CLIMB_SPEED * size, _CLIMB_SHARE * float(np.median(passing)))
    weights = np.minimum(bearing[:-1], bearing[1:]) * np.exp(-((np.diff(points[..., 2], axis=0) * rate / limit) ** 2))
    # A foot that rolls over its heel moves at the ankle: the ankle stands only with the toes on the ground.
    last = np.cumsum([len(chain) for chain in chains]) - 1
    weights *= np.repeat(weights[:, last], [len(chain) for chain in chains], axis=1)
    standing = np.flatnonzero(weights.max(axis=1) > _STANDS)
    if len(standing) == 0:
        raise ClipError(
            f"Clip '{clip.name}': neither foot stands on the ground in any frame, so that nothing says how far it "
            "should travel; move its root by hand, or drop it."
        )
    shares = weights / (weights.sum(axis=1, keepdims=True) + 1e-9)

    moves = np.einsum("fk,fkc->fc", shares, np.diff(points[..., :2], axis=0))
    # Toes bend; which way a foot points, its ankle says.
    ankles = [joints.index(chain[0]) for chain in chains for _ in chain]
    turned = quat.multiply(rotations[1:, ankles], quat.inverse(rotations[:-1, ankles]))
    turns = np.einsum("fk,fk->f", shares, quat.to_rotvec(turned)[..., 2])
    x, y, turns = (
        np.interp(np.arange(len(moves)), standing, values[standing]).reshape(-1, _FINER).sum(axis=1)
        for values in (moves[:, 0], moves[:, 1], turns)
    )
    return np.column_stack([x, y]), turns


def _finer(clip: MotionClip, joints: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """World rotations (n, k, 4) and positions (n, k, 3) of some joints and the root's (n, 3) at every frame and
    between: n = _FINER (F - 1) + 1.
    """
    rotations, positions = clip.world
    at = np.arange(_FINER * (clip.n_frames - 1) + 1) / _FINER
    before = np.minimum(at.astype(int), clip.n_frames - 2)
    turning = quat.slerp(rotations[before][:, joints], rotations[before + 1][:, joints], (at - before)[:, None, None])
    going = CubicSpline(np.arange(clip.n_frames), positions[:, [0, *joints]])(at)
    return turning, going[:, 1:], going[:, 0]


def missing_speed(clip: MotionClip, feet: Feet | None = None) -> float:
    """Return the speed in m/s at which the ground slides under the standing feet: near 0 where the root travels well.

    The length of the mean, seen from the character, so that noise and steps to and fro cancel. ClipError if the
    skeleton has no feet that can be recognized, or neither ever stands.
    """
    moves, _ = stance_steps(clip, feet)
    seen = (moves[:, 0] + 1j * moves[:, 1]) * np.exp(-1j * clip.ground_path[:-1, 2])
    return float(np.abs(seen.mean()) * clip.frame_rate)


def with_root_motion(clip: MotionClip, turning: bool = False, feet: Feet | None = None) -> MotionClip:
    """Return the clip, carried over the ground so that the standing foot stays where it is.

    The first frame is kept. With ``turning``, the character is also turned by what its standing foot turns, for
    clips whose root does not even turn; otherwise its heading is kept. ClipError if no feet are
    recognized, or neither ever stands; ``feet`` names them.
    """
    if turning:
        _, turns = stance_steps(clip, feet)
        clip = _turned(clip, np.concatenate([[0.0], -np.cumsum(turns)]))
    moves, _ = stance_steps(clip, feet)
    translations = clip.translations.copy()
    translations[1:, 0, :2] -= np.cumsum(moves, axis=0)
    return replace(clip, translations=translations)


def _turned(clip: MotionClip, angles: np.ndarray) -> MotionClip:
    """The clip with each frame turned about the vertical through its own root by ``angles`` (F,) radians."""
    rotations = clip.rotations.copy()
    rotations[:, 0] = quat.multiply(quat.about("z", angles), rotations[:, 0])
    heading = None if clip.heading is None else clip.heading + angles
    return replace(clip, rotations=rotations, heading=heading)
