"""Jumps, in which both feet are off the ground and may cross what walking may not."""

from collections.abc import Sequence

import numpy as np

from ..errors import ClipError
from .clip import MotionClip
from .contacts import FLOOR_PERCENTILE, foot_joints
from .runs import runs


def clearance_mask(clip: MotionClip, feet: Sequence[Sequence[int]], height: float) -> np.ndarray:
    """Find the (F,) bool mask of frames in which all joints of both feet are ``height`` (m) above where they stand.

    ``feet`` holds the joint indices of either foot, as from :func:`core.motion.contacts.foot_joints`. Each joint's
    floor is the clip's own.
    """
    joints = [joint for foot in feet for joint in foot]
    if not joints:
        raise ClipError(f"Clip '{clip.name}': there are no foot bones to tell its jumps by.")
    heights = clip.world[1][:, joints, 2]
    return np.all(heights - np.percentile(heights, FLOOR_PERCENTILE, axis=0) > height, axis=1)


def jump_mask(clip: MotionClip, height: float, lift: float = 0.03, lead: float = 0.1) -> np.ndarray:
    """Find the (F,) bool mask of the jumps of a clip that clear ``height`` (m), from before take-off to after landing.

    A jump is a stretch in which both feet are off the ground, by more than ``lift`` (m), and at some moment by more
    than ``height``; it counts from ``lead`` (s) before to ``lead`` after that stretch, in which the body leans into
    the jump and catches itself. No frame if the clip holds no such jump.

    Raises ClipError if the skeleton has no feet that can be recognized.
    """
    feet = foot_joints(clip.skeleton)
    off_ground, high = clearance_mask(clip, feet, lift), clearance_mask(clip, feet, height)
    margin = round(lead * clip.frame_rate)
    mask = np.zeros(clip.n_frames, dtype=bool)
    for first, last in runs(off_ground):
        if high[first : last + 1].any():
            mask[max(first - margin, 0) : last + 1 + margin] = True
    return mask
