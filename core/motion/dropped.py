"""Motion that did not make it into the motion graph, and why."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import wording
from .clip import MotionClip
from .frame_pairs import FrameSet
from .segmentation import Segmentation, Transitions


@dataclass(frozen=True)
class DroppedClip:
    """Seconds of a clip that were left out of the graph, and why."""

    clip: str
    seconds: float
    reason: str


def dropped_motion(
    clips: Sequence[MotionClip], frames: FrameSet, cut: Segmentation, transitions: Transitions, threshold: float
) -> list[DroppedClip]:
    """List what of each clip is in no kept segment, in seconds by reason.

    ``threshold`` is the cost (rad^2) up to which the ``transitions`` go that the segments were linked by.
    """
    is_start, is_end = np.zeros((2, frames.n_frames), dtype=bool)
    is_start[cut.first[cut.kept]] = is_end[cut.last[cut.kept]] = True
    switches = transitions.end != transitions.start
    linkable, entered, left = np.zeros((3, len(clips)), dtype=bool)
    linkable[frames.owner[transitions.start[switches]]] = True
    entered[frames.owner[transitions.start[switches & is_end[transitions.end]]]] = True
    left[frames.owner[transitions.end[switches & is_start[transitions.start]]]] = True
    dropped = []
    for index, clip in enumerate(clips):
        own = np.flatnonzero(cut.kept & (frames.owner[cut.first] == index))
        if len(own):
            # What is kept of a clip is in one piece: whatever lies between two kept segments joins them.
            before = float(cut.first[own[0]] - frames.offsets[index]) / clip.frame_rate
            after = clip.duration - float(cut.last[own[-1]] - frames.offsets[index]) / clip.frame_rate
            if before > 0:
                dropped.append(DroppedClip(clip.name, before, "no transition leads to its beginning"))
            if after > 1e-9:
                dropped.append(DroppedClip(clip.name, after, "no transition leads back from its end"))
            continue
        if not linkable[index]:
            reason = f"no transitions at a cost of {wording.exact(threshold)} or less"
        elif entered[index] and left[index]:
            reason = "no transition leads to it early enough to leave it again"
        elif entered[index]:
            reason = "no transition leads back from it"
        elif left[index]:
            reason = "no transition leads to it"
        else:
            reason = "its transitions lead only to motion that was dropped"
        dropped.append(DroppedClip(clip.name, clip.duration, reason))
    return dropped
