"""The legend beside the map: a scale of greys, what the colours mean, and how long a metre is."""

from dataclasses import dataclass

import bpy

from ...core.maps.scales import GREYS
from ...core.wording import length as length_words
from .picture_scene import PictureScene

_TEXT = (0.86, 0.87, 0.89)
_FAINT = (0.58, 0.60, 0.64)
_STEPS = 48


@dataclass
class Legend:
    """Writes downwards from the top left corner (x, y), at height z; ``size`` is the height of a line in metres."""

    picture: PictureScene
    x: float
    y: float
    z: float
    size: float

    def title(self, text: str) -> None:
        self._text(text, self.x, 1.25 * self.size, _TEXT)
        self.y -= 2.0 * self.size

    def note(self, text: str) -> None:
        self._text(text, self.x, 0.72 * self.size, _FAINT)
        self.y -= 1.35 * self.size

    def gap(self, lines: float = 1.0) -> None:
        self.y -= lines * self.size

    def ramp(self, low: str, high: str) -> None:
        """The greys from the fewest to the most, with what stands at either end."""
        width, height = 9.0 * self.size, 1.0 * self.size
        for k in range(_STEPS):
            share = k / (_STEPS - 1)
            color = [(1 - share) * a + share * b for a, b in zip(*GREYS.stops, strict=True)]
            left = self.x + k * width / _STEPS
            self._patch(left, left + 1.02 * width / _STEPS, self.y - height, self.y, color)
        self.y -= height + 1.0 * self.size
        self._text(low, self.x, 0.72 * self.size, _FAINT)
        self._text(high, self.x + width, 0.72 * self.size, _FAINT, align="RIGHT")
        self.y -= 1.3 * self.size

    def entry(self, color, text: str, thin: bool = False) -> None:
        """A colour and what it stands for; ``thin`` for lines."""
        half = (0.14 if thin else 0.5) * self.size
        middle = self.y - 0.42 * self.size
        self._patch(self.x, self.x + 1.5 * self.size, middle - half, middle + half, color)
        self.y -= 0.72 * self.size
        self._text(text, self.x + 2.1 * self.size, 0.86 * self.size, _TEXT)
        self.y -= 0.95 * self.size

    def scale_bar(self, length: float = 1.0) -> None:
        thickness = 0.08 * self.size
        self._patch(self.x, self.x + length, self.y - thickness, self.y + thickness, _TEXT)
        for end in (self.x, self.x + length - thickness):
            self._patch(end, end + thickness, self.y - 3 * thickness, self.y + 3 * thickness, _TEXT)
        self.y -= 1.3 * self.size
        self._text(length_words(length), self.x, 0.72 * self.size, _FAINT)
        self.y -= self.size

    def _text(self, text: str, x: float, size: float, color, align: str = "LEFT") -> None:
        curve = bpy.data.curves.new("Legend", "FONT")
        curve.body, curve.size, curve.align_x = text, size, align
        obj = self.picture.add("Legend", curve)
        obj.location = (x, self.y, self.z)
        curve.materials.append(self.picture.flat_material(color))

    def _patch(self, left: float, right: float, bottom: float, top: float, color) -> None:
        mesh = bpy.data.meshes.new("Legend")
        corners = [(left, bottom, self.z), (right, bottom, self.z), (right, top, self.z), (left, top, self.z)]
        mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
        mesh.materials.append(self.picture.flat_material(color))
        self.picture.add("Legend", mesh)
