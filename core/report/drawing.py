"""Drawings: lines, boxes, texts and pictures on a sheet, in pixels from the top left; written as SVG.

Charts are made of these few marks, so that whoever can draw them - a browser, Blender's image buffers - can show every
chart.
"""

import base64
from dataclasses import dataclass
from enum import Enum
from html import escape

import numpy as np

from ..maps.scales import Color
from .png import png_bytes

INK: Color = (0.13, 0.14, 0.16)
FAINT: Color = (0.86, 0.87, 0.88)
QUIET: Color = (0.42, 0.44, 0.47)
PAPER: Color = (1.0, 1.0, 1.0)


class Anchor(Enum):
    """End of a text that lies at its place."""

    START = "start"
    MIDDLE = "middle"
    END = "end"


@dataclass(frozen=True)
class Line:
    """An open polyline.

    Attributes
    ----------
    points : (n, 2) float array
    width : float
    """

    points: np.ndarray
    color: Color = INK
    width: float = 1.0


@dataclass(frozen=True)
class Rectangle:
    """A filled rectangle; ``x`` and ``y`` are its top left corner."""

    x: float
    y: float
    width: float
    height: float
    color: Color


@dataclass(frozen=True)
class Label:
    """A text in one line; ``x`` and ``y`` are a point of its base line. Upright labels are read from below upwards."""

    x: float
    y: float
    text: str
    size: float = 12.0
    color: Color = INK
    anchor: Anchor = Anchor.START
    bold: bool = False
    upright: bool = False


@dataclass(frozen=True)
class Picture:
    """An image, its pixels shown as they are.

    Attributes
    ----------
    pixels : (rows, columns, 3) uint8 array
        sRGB, the first row on top.
    """

    x: float
    y: float
    width: float
    height: float
    pixels: np.ndarray


Mark = Line | Rectangle | Label | Picture


@dataclass(frozen=True)
class Drawing:
    """Marks on a sheet of ``width`` x ``height`` pixels, later ones over earlier ones."""

    width: int
    height: int
    marks: tuple[Mark, ...]


def svg(drawing: Drawing) -> str:
    """Write the drawing as an SVG element that needs nothing from elsewhere.

    >>> "<rect" in svg(Drawing(40, 20, (Rectangle(0, 0, 10, 10, PAPER),)))
    True
    """
    body = "".join(_element(mark) for mark in drawing.marks)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {drawing.width} {drawing.height}" '
        f'width="{drawing.width}" height="{drawing.height}" font-family="system-ui, sans-serif">'
        f'<rect width="100%" height="100%" fill="{_hex(PAPER)}"/>{body}</svg>'
    )


def _element(mark: Mark) -> str:
    if isinstance(mark, Line):
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in np.asarray(mark.points))
        return (
            f'<polyline points="{points}" fill="none" stroke="{_hex(mark.color)}" stroke-width="{mark.width:g}" '
            'stroke-linejoin="round"/>'
        )
    if isinstance(mark, Rectangle):
        return (
            f'<rect x="{mark.x:.1f}" y="{mark.y:.1f}" width="{mark.width:.1f}" height="{mark.height:.1f}" '
            f'fill="{_hex(mark.color)}"/>'
        )
    if isinstance(mark, Label):
        turn = f' transform="rotate(-90 {mark.x:.1f} {mark.y:.1f})"' if mark.upright else ""
        weight = ' font-weight="600"' if mark.bold else ""
        return (
            f'<text x="{mark.x:.1f}" y="{mark.y:.1f}" font-size="{mark.size:g}" fill="{_hex(mark.color)}" '
            f'text-anchor="{mark.anchor.value}"{weight}{turn}>{escape(mark.text)}</text>'
        )
    data = base64.b64encode(png_bytes(mark.pixels)).decode("ascii")
    return (
        f'<image x="{mark.x:.1f}" y="{mark.y:.1f}" width="{mark.width:.1f}" height="{mark.height:.1f}" '
        f'preserveAspectRatio="none" style="image-rendering: pixelated" href="data:image/png;base64,{data}"/>'
    )


def _hex(color: Color) -> str:
    return "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in color)
