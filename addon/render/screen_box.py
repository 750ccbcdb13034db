"""Boxes of text and colour over a viewport, in the colours of the user's theme.

What is to be drawn is laid out first, as plain numbers; only :func:`draw_box` needs a window.
"""

import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import blf
import gpu
from gpu_extras.batch import batch_for_shader

RGBA = tuple[float, float, float, float]

_FONT = 0
_POINTS = 11.0


@dataclass(frozen=True)
class BoxText:
    """A line of text; x, y of its baseline's left end in pixels from the box's lower left corner."""

    x: float
    y: float
    text: str
    points: float
    faint: bool = False
    warning: bool = False


@dataclass(frozen=True)
class BoxPatch:
    """A rectangle that runs from one sRGB colour at its left to another at its right; a ``framed`` one has a border,
    so that it can be told from a box of the same colour."""

    x: float
    y: float
    width: float
    height: float
    left: tuple[float, float, float]
    right: tuple[float, float, float]
    framed: bool = False


@dataclass
class Box:
    """A box that is written from its top downwards; sizes in pixels, from its lower left corner.

    ``scale`` is the user's size of the interface. Call :meth:`done` at the end.
    """

    scale: float
    width: float = 0.0
    height: float = 0.0
    texts: list[BoxText] = field(default_factory=list)
    patches: list[BoxPatch] = field(default_factory=list)

    @property
    def line(self) -> float:
        return 18.0 * self.scale

    @property
    def margin(self) -> float:
        return 9.0 * self.scale

    def text(self, text: str, indent: float = 0.0, size: float = 1.0, faint: bool = False, warning: bool = False):
        """A line of text."""
        self.text_at(text, indent, size, faint, warning)
        self.height += self.line

    def text_at(self, text: str, x: float, size: float = 1.0, faint: bool = False, warning: bool = False) -> None:
        """Text on the line that comes next, without going on to another."""
        points = _POINTS * size * self.scale
        # Growing downwards as negative numbers; :meth:`done` turns that over.
        self.texts.append(BoxText(x, -(self.height + 0.72 * self.line), text, points, faint, warning))
        self.width = max(self.width, x + text_width(text, points))

    def patch(self, x: float, width: float, height: float, left, right=None, framed: bool = False) -> None:
        """A rectangle in the middle of the line that comes next."""
        top = self.height + (self.line - height) / 2
        right = left if right is None else right
        self.patches.append(BoxPatch(x, -(top + height), width, height, left, right, framed))
        self.width = max(self.width, x + width)

    def gap(self, lines: float) -> None:
        self.height += lines * self.line

    def done(self) -> "Box":
        """With margins, and all heights from the lower edge."""
        up, across = self.height + self.margin, self.margin
        self.texts = [replace(t, x=t.x + across, y=t.y + up) for t in self.texts]
        self.patches = [replace(p, x=p.x + across, y=p.y + up) for p in self.patches]
        self.width, self.height = self.width + 2 * self.margin, self.height + 2 * self.margin
        return self


def text_width(text: str, points: float) -> float:
    """Pixels that a line takes up."""
    blf.size(_FONT, points)
    return blf.dimensions(_FONT, text)[0]


@dataclass(frozen=True)
class BoxTheme:
    """Colours of a box: those of tooltips."""

    background: RGBA
    outline: RGBA
    text: RGBA
    faint: RGBA
    warning: RGBA

    @classmethod
    def of(cls, preferences) -> "BoxTheme":
        theme = preferences.themes[0]
        colors = theme.user_interface.wcol_tooltip
        inner, text = tuple(colors.inner), tuple(colors.text)
        faint = tuple(0.65 * a + 0.35 * b for a, b in zip(text, inner, strict=False))
        warning = (0.95, 0.6, 0.1) if sum(inner[:3]) < 1.5 else (0.7, 0.35, 0.0)
        return cls((*inner[:3], 0.92), (*colors.outline[:3], 1.0), (*text[:3], 1.0), (*faint[:3], 1.0), (*warning, 1.0))


def draw_box(box: Box, x: float, y: float, theme: BoxTheme) -> None:
    """Draw a finished box with its lower left corner at x, y of the region that is being drawn."""
    gpu.state.blend_set("ALPHA")
    try:
        _rectangles([(0.0, 0.0, box.width, box.height, theme.outline, theme.outline)], x, y)
        _rectangles([(1.0, 1.0, box.width - 2, box.height - 2, theme.background, theme.background)], x, y)
        patches = [(p.x, p.y, p.width, p.height, (*p.left, 1.0), (*p.right, 1.0)) for p in box.patches]
        frames = [
            (p.x - 1, p.y - 1, p.width + 2, p.height + 2, theme.faint, theme.faint) for p in box.patches if p.framed
        ]
        if patches:
            _rectangles([*frames, *patches], x, y)
        for text in box.texts:
            color = theme.warning if text.warning else theme.faint if text.faint else theme.text
            blf.size(_FONT, text.points)
            blf.color(_FONT, *color)
            blf.position(_FONT, round(x + text.x), round(y + text.y), 0.0)
            blf.draw(_FONT, text.text)
    finally:
        gpu.state.blend_set("NONE")


def _rectangles(rectangles, x: float, y: float) -> None:
    positions, colors, indices = [], [], []
    for left, bottom, width, height, first, last in rectangles:
        k = len(positions)
        positions += [
            (x + left, y + bottom),
            (x + left + width, y + bottom),
            (x + left + width, y + bottom + height),
            (x + left, y + bottom + height),
        ]
        colors += [first, last, last, first]
        indices += [(k, k + 1, k + 2), (k, k + 2, k + 3)]
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch_for_shader(shader, "TRIS", {"pos": positions, "color": colors}, indices=indices).draw(shader)


def guarded(draw: Callable[[], None]) -> Callable[[], None]:
    """A draw handler that reports an error once, instead of at every redraw, and draws nothing from then on."""

    def handler() -> None:
        if handler.failed:
            return
        try:
            draw()
        except Exception:
            # Blender would print it many times a second.
            handler.failed = True
            traceback.print_exc()

    handler.failed = False
    return handler
