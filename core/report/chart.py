"""Charts: curves, bars and floor maps, drawn from numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .color_scale import SERIES, ColorScale
from .drawing import FAINT, INK, QUIET, Anchor, Box, Color, Drawing, Label, Line, Mark, Picture
from .ticks import number_text, ticks

_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 20, 44, 50
_LINE = 18
"""Pixels from one line of text to the next."""


@dataclass(frozen=True)
class Series:
    """A named curve through the points (x[i], y[i])."""

    name: str
    x: np.ndarray
    y: np.ndarray


def line_chart(
    title: str, x_label: str, y_label: str, series: Sequence[Series], width: int = 520, height: int = 320
) -> Drawing:
    """Curves over a common pair of axes, with a legend if there are several. The y axis starts at zero.

    Raises ValueError if no series has a point, or one has values that are not finite.
    """
    x = np.concatenate([np.asarray(s.x, dtype=float) for s in series]) if series else np.empty(0)
    y = np.concatenate([np.asarray(s.y, dtype=float) for s in series]) if series else np.empty(0)
    if x.size == 0 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError(f"'{title}' has no finite points to draw")
    x_ticks, y_ticks = ticks(x.min(), x.max(), 6), ticks(min(y.min(), 0.0), y.max())
    legend = _LINE if len(series) > 1 else 0
    top, bottom, right = _TOP + legend, height - _BOTTOM, width - _RIGHT

    def across(values):
        return _LEFT + (np.asarray(values) - x_ticks[0]) / (x_ticks[-1] - x_ticks[0]) * (right - _LEFT)

    def up(values):
        return bottom - (np.asarray(values) - y_ticks[0]) / (y_ticks[-1] - y_ticks[0]) * (bottom - top)

    marks: list[Mark] = [Label(16, 24, title, 14, bold=True)]
    for value, place in zip(y_ticks, up(y_ticks), strict=True):
        marks.append(Line(np.array([[_LEFT, place], [right, place]]), FAINT))
        marks.append(Label(_LEFT - 8, place + 4, number_text(value), 11, QUIET, Anchor.END))
    for value, place in zip(x_ticks, across(x_ticks), strict=True):
        marks.append(Line(np.array([[place, bottom], [place, bottom + 4]]), QUIET))
        marks.append(Label(place, bottom + 18, number_text(value), 11, QUIET, Anchor.MIDDLE))
    marks.append(Line(np.array([[_LEFT, bottom], [right, bottom]]), QUIET))
    marks.append(Label((_LEFT + right) / 2, height - 12, x_label, 12, INK, Anchor.MIDDLE))
    marks.append(Label(16, (top + bottom) / 2, y_label, 12, INK, Anchor.MIDDLE, upright=True))
    legend_x = float(_LEFT)
    for i, curve in enumerate(series):
        color = SERIES[i % len(SERIES)]
        marks.append(Line(np.column_stack([across(curve.x), up(curve.y)]), color, 2.0))
        for cx, cy in zip(across(curve.x), up(curve.y), strict=True):
            marks.append(Box(cx - 2, cy - 2, 4, 4, color))
        if legend:
            marks.append(Box(legend_x, _TOP - 2, 12, 4, color))
            marks.append(Label(legend_x + 18, _TOP + 4, curve.name, 12))
            legend_x += 36 + 7 * len(curve.name)
    return Drawing(width, height, tuple(marks))


def bar_chart(title: str, unit: str, names: Sequence[str], values: Sequence[float], width: int = 520) -> Drawing:
    """A horizontal bar for each name, in the order given; values must not be negative."""
    if not names or not np.isfinite(values).all() or min(values) < 0:
        raise ValueError(f"'{title}' has no bars to draw, or negative ones")
    left = min(24 + 7 * max(len(name) for name in names), width // 2)
    right, step = width - 70, 20
    highest = max(max(values), 1e-12)
    marks: list[Mark] = [Label(16, 24, title, 14, bold=True), Label(right, 24, unit, 12, QUIET, Anchor.END)]
    for i, (name, value) in enumerate(zip(names, values, strict=True)):
        y = _TOP + i * step
        shown = name if len(name) <= left // 7 else name[: left // 7 - 1] + "…"
        marks.append(Label(left - 8, y + 12, shown, 12, INK, Anchor.END))
        marks.append(Box(left, y, max((right - left) * value / highest, 0.0), step - 6, SERIES[0]))
        marks.append(Label(left + (right - left) * value / highest + 6, y + 12, number_text(value), 11, QUIET))
    return Drawing(width, _TOP + len(names) * step + 12, tuple(marks))


@dataclass(frozen=True)
class Swatch:
    """A colour of a map and what it stands for."""

    color: Color
    text: str


@dataclass(frozen=True)
class ColorBar:
    """A colour scale and the texts at its ends."""

    scale: ColorScale
    lowest: str
    highest: str


def map_chart(
    title: str,
    colors: np.ndarray,
    cell_size: float,
    legend: Sequence[Swatch | ColorBar] = (),
    paths: Sequence[np.ndarray] = (),
    width: int = 520,
) -> Drawing:
    """A floor seen from above, +Y upwards, with a scale of metres and a legend.

    Parameters
    ----------
    colors : (nx, ny, 3) float array
        sRGB of each cell, components from 0 to 1.
    cell_size : float
        Metres.
    paths : sequence of (n, 2) arrays
        Lines over the floor, in cells: the centre of cell (x, y) is (x, y).
    """
    nx, ny, _ = colors.shape
    pixels = np.round(255 * np.clip(colors, 0.0, 1.0)).astype(np.uint8).transpose(1, 0, 2)[::-1]
    scale = min((width - 32) / nx, 1.25 * width / ny)
    shown_width, shown_height = nx * scale, ny * scale
    left = (width - shown_width) / 2
    marks: list[Mark] = [Label(16, 24, title, 14, bold=True)]
    marks.append(Picture(left, _TOP - 6, shown_width, shown_height, np.ascontiguousarray(pixels)))
    for path in paths:
        places = np.column_stack(
            [left + (path[:, 0] + 0.5) * scale, _TOP - 6 + shown_height - (path[:, 1] + 0.5) * scale]
        )
        marks.append(Line(places, (0.10, 0.78, 0.25), 2.0))
    y = _TOP + shown_height + 12
    metres = float(ticks(0.0, max(nx * cell_size / 5, cell_size), 2)[1])
    marks.append(Line(np.array([[left, y], [left + metres / cell_size * scale, y]]), INK, 3.0))
    marks.append(Label(left + metres / cell_size * scale + 8, y + 4, f"{metres:g} m", 11))
    x, y = left, y + 10
    for entry in legend:
        wide = 26 + 6.5 * len(entry.text) if isinstance(entry, Swatch) else 190.0
        if x > left and x + wide > width - 16:
            x, y = left, y + _LINE
        if isinstance(entry, Swatch):
            marks.append(Box(x, y, 12, 12, entry.color))
            marks.append(Label(x + 18, y + 11, entry.text, 11))
        else:
            marks.append(Label(x, y + 11, entry.lowest, 11))
            start = x + 8 + 6.5 * len(entry.lowest)
            ramp = np.round(255 * entry.scale.colors(np.linspace(0, 1, 64))).astype(np.uint8)[None]
            marks.append(Picture(start, y, 90, 12, ramp))
            marks.append(Label(start + 98, y + 11, entry.highest, 11))
            wide = start + 98 + 6.5 * len(entry.highest) - x + 14
        x += wide
    return Drawing(width, round(y + 26), tuple(marks))
