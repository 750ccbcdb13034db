"""Channels that stand still while they should not: lost data that was written as zero or held."""

import numpy as np

from .. import quat
from ..clip import MotionClip
from ..runs import runs

_STILL = 1e-7
"""Radians, and statures, from frame to frame that are rounding, not motion."""
_MIN_HELD = 4
"""Frames for which a value must be held to be called frozen; zero is suspicious in a single one."""
_ABRUPT_TURN = np.radians(1.0)
_ZERO_TURN = np.radians(5.0)
_LONE_ZERO_TURN = np.radians(15.0)
_ABRUPT_MOVE = 0.01
_ABRUPT_ROOT = 0.05
"""Turns (radians) and moves (statures) with which a held or zeroed channel must begin or end at least."""
_RATIO = 4.0
"""How many times larger than the neighbouring steps such a turn or move must be: who holds still starts gently."""


def frozen_joints(clip: MotionClip) -> list[tuple[int, int, tuple[int, ...]]]:
    """Find (first, last, joints) of stretches in which joints hold one rotation, or that of no data, and jump.

    No data is the identity or the rest rotation. What holds still and moves on gently is an animator's hold and
    not found; a joint that hardly ever moves is not animated. Fingers are left out.
    """
    lost: dict[tuple[int, int], dict[int, float]] = {}
    for joint in np.flatnonzero(~clip.skeleton.fingers).tolist():
        q = clip.rotations[:, joint]
        steps = quat.angle_between(q[:-1], q[1:])
        if steps.sum() < _ZERO_TURN:
            continue
        empty = np.zeros(clip.n_frames, dtype=bool)
        for value in (quat.IDENTITY, clip.skeleton.rest_rotations[joint]):
            empty |= quat.angle_between(q, value) < 1e-4
        if empty.mean() > 0.5:
            empty[:] = False  # this is how the joint is, and what moves it for a moment is no lack of data
        found = [run for run in runs(empty) if _is_lost(steps, *run, _ZERO_TURN)]
        for first, last in _stretches(steps < _STILL):
            short = last - first + 1 < clip.n_frames / 2
            if short and not empty[first] and _is_held(steps, first, last, _ABRUPT_TURN):
                found.append((first, last))
        for first, last in found:
            ends = steps[[at for at in (first - 1, last) if 0 <= at < len(steps)]]
            lost.setdefault((first, last), {})[joint] = float(ends.max())
    # Data is lost limb by limb. One joint alone may have swung to its limit within a frame.
    return [
        (first, last, tuple(joints))
        for (first, last), joints in sorted(lost.items())
        if last - first + 1 >= _MIN_HELD or len(joints) > 1 or max(joints.values()) > _LONE_ZERO_TURN
    ]


def lost_root(clip: MotionClip) -> list[tuple[int, int]]:
    """Find (first, last) of stretches in which the root is held in place, or is at the origin or at rest, and jumps."""
    size = clip.skeleton.stature
    places = clip.translations[:, 0]
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1) / size
    lost = np.zeros(clip.n_frames, dtype=bool)
    for place in (np.zeros(3), clip.skeleton.rest_translations[0]):
        lost |= np.linalg.norm(places - place, axis=1) < 1e-3 * size
    held = [run for run in _stretches(steps < _STILL) if not lost[run[0]] and _is_held(steps, *run, _ABRUPT_MOVE)]
    return sorted(held + [run for run in runs(lost) if _is_lost(steps, *run, _ABRUPT_ROOT)])


def _jumps(steps: np.ndarray, first: int, last: int, least: float) -> list[bool]:
    """True for each end of the stretch within the clip if its step is large, in itself and among its neighbours."""
    ends = []
    if first > 0:
        ends.append((steps[first - 1], steps[max(first - 7, 0) : max(first - 1, 0)]))
    if last < len(steps):
        ends.append((steps[last], steps[last + 1 : last + 7]))
    return [bool(step > least and (len(others) == 0 or step > _RATIO * np.median(others))) for step, others in ends]


def _is_lost(steps: np.ndarray, first: int, last: int, least: float) -> bool:
    """Test whether a value that means no data comes and goes with jumps: no knee is straight all of a sudden."""
    jumps = _jumps(steps, first, last, least)
    return bool(jumps) and all(jumps)


def _is_held(steps: np.ndarray, first: int, last: int, least: float) -> bool:
    """Test whether a value is held, and then jumps to where the motion has gone (or has jumped, at the end)."""
    jumps = _jumps(steps, first, last, least)
    return last - first + 1 >= _MIN_HELD and bool(jumps) and jumps[-1]


def _stretches(still: np.ndarray) -> list[tuple[int, int]]:
    """First and last frame of each run of still steps (F - 1,)."""
    return [(first, last + 1) for first, last in runs(still)]
