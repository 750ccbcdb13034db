"""When the feet are planted, as a picture: two rows for each clip, the left foot above the right one."""

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import blf
import bpy
import imbuf
import numpy as np

# sRGB; a blue and an orange that everybody can tell apart.
LEFT, RIGHT = (0.34, 0.71, 0.91), (0.90, 0.62, 0.00)
_BACKGROUND = (0.11, 0.11, 0.12)
_LIFTED = (0.20, 0.20, 0.21)
_SECOND = (0.30, 0.30, 0.31)
_TEXT = (0.85, 0.85, 0.85)

_NAMES_WIDTH = 200
_ROW, _GAP, _MARGIN = 9, 12, 16
_WIDEST = 1400
_PIXELS_PER_SECOND = 200.0
_FONT, _FONT_SIZE = 0, 13.0


@dataclass(frozen=True)
class ContactShares:
    """For which part of a clip (0 to 1) the left foot, the right foot, both and none of them are planted."""

    left: float
    right: float
    both: float
    none: float


@dataclass(frozen=True)
class ClipContacts:
    """A clip's name, its frames per second, and (F, 2) bool: whether left and right foot are planted."""

    name: str
    frame_rate: float
    planted: np.ndarray

    @property
    def shares(self) -> ContactShares:
        left, right = self.planted.T
        return ContactShares(*(float(mask.mean()) for mask in (left, right, left & right, ~(left | right))))


def contact_strip(clips: Sequence[ClipContacts]) -> np.ndarray:
    """(height, width, 4) float32 sRGB, the lowest row first, as Blender's images have it.

    All clips on the same scale of time, with a line for every second.
    """
    longest = max(len(clip.planted) / clip.frame_rate for clip in clips)
    scale = min(_PIXELS_PER_SECOND, _WIDEST / longest)
    width = _NAMES_WIDTH + int(np.ceil(longest * scale)) + _MARGIN
    step = 2 * _ROW + 1 + _GAP
    height = 2 * _MARGIN + step * len(clips) - _GAP
    # The highest row first while drawing.
    picture = np.tile(np.array((*_BACKGROUND, 1.0), np.float32), (height, width, 1))
    for second in range(int(longest) + 1):
        picture[_MARGIN // 2 : -_MARGIN // 2, _NAMES_WIDTH + int(second * scale), :3] = _SECOND
    for place, clip in enumerate(clips):
        top = _MARGIN + place * step
        n_columns = max(1, int(len(clip.planted) / clip.frame_rate * scale))
        frame_of = (np.arange(n_columns) + 0.5) * len(clip.planted) / n_columns
        shown = clip.planted[frame_of.astype(int)]
        for side, color in enumerate((LEFT, RIGHT)):
            row = top + side * (_ROW + 1)
            colors = np.where(shown[:, side, None], np.array(color, np.float32), np.array(_LIFTED, np.float32))
            picture[row : row + _ROW, _NAMES_WIDTH : _NAMES_WIDTH + n_columns, :3] = colors
    names = [(clip.name, height - (_MARGIN + place * step + _ROW + 5)) for place, clip in enumerate(clips)]
    picture = picture[::-1].copy()
    shade = _names_shade(names, width, height)
    picture[..., :3] += shade * (np.array(_TEXT, np.float32) - picture[..., :3])
    return picture


def _names_shade(names: Sequence[tuple[str, int]], width: int, height: int) -> np.ndarray:
    """(height, width, 1) float32, lowest row first: how much of each pixel is covered by text."""
    buffer = imbuf.new((width, height))
    blf.size(_FONT, _FONT_SIZE)
    blf.color(_FONT, 1.0, 1.0, 1.0, 1.0)
    drawing: Any = blf.bind_imbuf(_FONT, buffer)  # the stubs have it return nothing
    with drawing:
        for name, baseline in names:
            blf.position(_FONT, _MARGIN, baseline, 0)
            blf.draw_buffer(_FONT, _fitting(name, _NAMES_WIDTH - 2 * _MARGIN))
    # The pixels of such a buffer can be had through a file only.
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "names.png")
        imbuf.write(buffer, filepath=path)
        image = bpy.data.images.load(path)
        pixels = np.empty(4 * width * height, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    buffer.free()
    return pixels.reshape(height, width, 4)[..., 3:]


def _fitting(text: str, width: float) -> str:
    """The text, shortened so that it is not wider than ``width`` pixels."""
    shown = text
    while blf.dimensions(_FONT, shown)[0] > width and len(shown) > 2:
        shown = shown[:-2] + "…"
    return shown
