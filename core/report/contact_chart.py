"""Contacts of feet as a chart: two rows for each clip, the left foot above the right one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .drawing import FAINT, QUIET, Anchor, Drawing, Label, Line, Mark, Rectangle

# sRGB; a blue and an orange that everybody can tell apart.
LEFT, RIGHT = (0.34, 0.71, 0.91), (0.90, 0.62, 0.00)

_NAMES_WIDTH, _WIDTH = 200, 1080
_ROW, _GAP, _TOP, _MARGIN = 9, 12, 28, 16
_PIXELS_PER_SECOND = 200.0


@dataclass(frozen=True)
class ContactShares:
    """Parts of a clip (0 to 1) in which the left foot, the right foot, both and none of them are planted."""

    left: float
    right: float
    both: float
    none: float


@dataclass(frozen=True)
class ClipContacts:
    """Contacts of a clip.

    Attributes
    ----------
    name : str
    frame_rate : float
        Frames per second.
    planted : (F, 2) bool array
        Frames in which the left and the right foot are planted.
    """

    name: str
    frame_rate: float
    planted: np.ndarray

    @property
    def shares(self) -> ContactShares:
        left, right = self.planted.T
        return ContactShares(*(float(mask.mean()) for mask in (left, right, left & right, ~(left | right))))


def contact_chart(clips: Sequence[ClipContacts]) -> Drawing:
    """Draw a bar wherever a foot is planted; all clips on the same scale of time, with a line for every second."""
    longest = max(len(clip.planted) / clip.frame_rate for clip in clips)
    scale = min(_PIXELS_PER_SECOND, (_WIDTH - _NAMES_WIDTH - _MARGIN) / longest)
    step = 2 * _ROW + 1 + _GAP
    bottom = _TOP + step * len(clips)
    marks: list[Mark] = []
    for second in range(int(longest) + 1):
        x = _NAMES_WIDTH + second * scale
        marks.append(Line(np.array([[x, _TOP - 6], [x, bottom]]), FAINT))
        if second % max(1, round(40 / scale)) == 0:
            marks.append(Label(x, _TOP - 12, f"{second} s", 11, QUIET, Anchor.MIDDLE))
    for place, clip in enumerate(clips):
        top, width = _TOP + place * step, scale / clip.frame_rate
        name = clip.name if len(clip.name) <= 26 else clip.name[:25] + "…"
        marks.append(Label(_NAMES_WIDTH - 8, top + _ROW + 4, name, 12, anchor=Anchor.END))
        for foot, color in enumerate((LEFT, RIGHT)):
            y = top + foot * (_ROW + 1)
            marks.append(Rectangle(_NAMES_WIDTH, y, len(clip.planted) * width, _ROW, FAINT))
            # Where planted frames begin and end.
            edges = np.flatnonzero(np.diff(clip.planted[:, foot].astype(int), prepend=0, append=0))
            for begin, end in edges.reshape(-1, 2).tolist():
                marks.append(Rectangle(_NAMES_WIDTH + begin * width, y, (end - begin) * width, _ROW, color))
    return Drawing(_WIDTH, bottom + _MARGIN, tuple(marks))
