"""Single frames at which something jumps away and back, or jumps at all."""

from dataclasses import dataclass

import numpy as np

from ..clip import MotionClip

_NEAR = 3
"""Frames on either side that a pop spoils, and at most between two flags of the same pop."""


@dataclass(frozen=True)
class PopSettings:
    """Thresholds of a pop: a jump must be large, and stand out from the motion around it.

    Attributes
    ----------
    distance : float
        How far a joint must be from where its neighbouring frames put it, in statures (the character's height).
    speed : float
        Statures per second by which an impact may change a joint's speed from one frame to the next, and that is no
        pop: it adds ``speed / frame_rate`` to ``distance``.
    ratio : float
        How many times farther it must be than three in four frames within half a second are.
    """

    distance: float = 0.011
    speed: float = 0.5
    ratio: float = 5.0


def pops(clip: MotionClip, settings: PopSettings) -> list[tuple[int, int, tuple[int, ...]]]:
    """Find (first, last, joints) of every pop, the joints that jump farthest first.

    A turn of a joint is seen by where its children go; of joints without children only the places are seen. Fingers
    are left out: they rap and snap.
    """
    n_frames, rate = clip.n_frames, clip.frame_rate
    if n_frames < 8:
        return []
    size = clip.skeleton.stature
    off = misplacement(clip.world[1])
    off[:, clip.skeleton.fingers] = 0.0
    far = off > size * (settings.distance + settings.speed / rate)
    flagged, always = np.zeros_like(far), np.median(off[2:-2], axis=0)
    for frame in np.flatnonzero(far.any(axis=1)):
        flagged[frame] = far[frame] & (off[frame] > settings.ratio * (_usual(off, frame, rate, always) + 2e-4 * size))
    found = []
    frames = np.flatnonzero(flagged.any(axis=1))
    for group in np.split(frames, np.flatnonzero(np.diff(frames) > _NEAR) + 1):
        if len(group) == 0:
            continue
        largest = np.where(flagged[group], off[group], 0).max(axis=1)
        # The neighbours of a frame that is off look two thirds as far off themselves.
        peaks = group[largest > 0.75 * largest.max()]
        joints = np.flatnonzero(flagged[peaks].any(axis=0))
        order = np.argsort(-off[peaks][:, joints].max(axis=0), kind="stable")
        found.append((int(peaks[0]), int(peaks[-1]), tuple(int(joint) for joint in joints[order])))
    return found


def _usual(off: np.ndarray, frame: int, rate: float, always: np.ndarray) -> np.ndarray:
    """(J,) what three in four frames around ``frame`` stay below, ``always`` at least; without a pop's own."""
    window = np.arange(frame - round(rate / 2), frame + round(rate / 2) + 1)
    # The first two and last two frames are judged from one side, and less surely.
    window = window[(np.abs(window - frame) > _NEAR) & (window >= 2) & (window < len(off) - 2)]
    return np.maximum(always, np.percentile(off[window], 75, axis=0)) if len(window) else always


def misplacement(positions: np.ndarray) -> np.ndarray:
    """Return the (F, J) metres between each position of (F, J, 3) and where its four neighbours in time put it.

    A cubic through the two frames before and the two after. At the two frames next to either end, which have fewer
    neighbours, what the next frame may be to blame for is left out.
    """
    fourth = np.linalg.norm(np.diff(positions, 4, axis=0), axis=2)
    third = np.linalg.norm(np.diff(positions, 3, axis=0), axis=2)
    # A frame that is off by s makes fourth differences of s, 4s, 6s, 4s, s and third ones of s, 3s, 3s, s.
    first, last = np.maximum(third[[0, -1]] - 3 * third[[1, -2]], 0) / 2  # with one side only, half as sure
    second, second_last = np.maximum(fourth[[0, -1]] - 1.5 * fourth[[1, -2]], 0) / 2.5
    return np.concatenate([[first, second], fourth / 6, [second_last, last]])
