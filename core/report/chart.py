"""Charts: curves, bars and floor maps, drawn from numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..maps.legend import ColorBar, Swatch
from ..maps.scales import SERIES, ColorScale
from .drawing import FAINT, INK, QUIET, Anchor, Color, Drawing, Label, Line, Mark, Picture, Rectangle
from .ticks import ticks

_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 20, 44, 50
_LINE = 18
"""Pixels from one line of text to the next."""

#: Width of charts that stand alone (pixels).
WIDE = 640

_BARS = 40
"""Bars of a chart at the most, where a table beside it has all."""


@dataclass(frozen=True)
class Series:
    """A named curve through the points (x[i], y[i])."""

    name: str
    x: np.ndarray
    y: np.ndarray


def line_chart(
    title: str,
    x_label: str,
    y_label: str,
    series: Sequence[Series],
    width: int = 520,
    height: int = 320,
    from_zero: bool = False,
    span: tuple[float, float] | None = None,
) -> Drawing:
    """Curves over a common pair of axes, with a legend if there are several. The y axis starts at zero, and with
    ``from_zero`` the x axis, too: for what may be proportional. The y axis holds ``span``, so that charts side by side
    can be compared.

    Raises ValueError if no series has a point, or one has values that are not finite.
    """
    x = np.concatenate([np.asarray(s.x, dtype=float) for s in series]) if series else np.empty(0)
    y = np.concatenate([np.asarray(s.y, dtype=float) for s in series]) if series else np.empty(0)
    if x.size == 0 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError(f"'{title}' has no finite points to draw")
    x_ticks = ticks(min(x.min(), 0.0) if from_zero else x.min(), x.max(), 6)
    lowest, highest = (y.min(), y.max()) if span is None else (min(y.min(), span[0]), max(y.max(), span[1]))
    y_ticks = ticks(min(lowest, 0.0), highest)
    right = width - _RIGHT
    legend = _legend_places([curve.name for curve in series], right) if len(series) > 1 else []
    lines = round((legend[-1][1] - _TOP) / _LINE) + 1 if legend else 0
    top, bottom = _TOP + lines * _LINE, height - _BOTTOM

    def across(values):
        return _LEFT + (np.asarray(values) - x_ticks[0]) / (x_ticks[-1] - x_ticks[0]) * (right - _LEFT)

    def up(values):
        return bottom - (np.asarray(values) - y_ticks[0]) / (y_ticks[-1] - y_ticks[0]) * (bottom - top)

    marks: list[Mark] = [Label(16, 24, title, 14, bold=True)]
    for value, place in zip(y_ticks, up(y_ticks), strict=True):
        marks.append(Line(np.array([[_LEFT, place], [right, place]]), FAINT))
        marks.append(Label(_LEFT - 8, place + 4, wording.short(value), 11, QUIET, Anchor.END))
    for value, place in zip(x_ticks, across(x_ticks), strict=True):
        marks.append(Line(np.array([[place, bottom], [place, bottom + 4]]), QUIET))
        marks.append(Label(place, bottom + 18, wording.short(value), 11, QUIET, Anchor.MIDDLE))
    marks.append(Line(np.array([[_LEFT, bottom], [right, bottom]]), QUIET))
    marks.append(Label((_LEFT + right) / 2, height - 12, x_label, 12, INK, Anchor.MIDDLE))
    marks.append(Label(16, (top + bottom) / 2, y_label, 12, INK, Anchor.MIDDLE, upright=True))
    for i, curve in enumerate(series):
        color = SERIES[i % len(SERIES)]
        marks.append(Line(np.column_stack([across(curve.x), up(curve.y)]), color, 2.0))
        for cx, cy in zip(across(curve.x), up(curve.y), strict=True):
            marks.append(Rectangle(cx - 2, cy - 2, 4, 4, color))
        if legend:
            legend_x, legend_y = legend[i]
            marks.append(Rectangle(legend_x, legend_y - 2, 12, 4, color))
            marks.append(Label(legend_x + 18, legend_y + 4, curve.name, 12))
    return Drawing(width, height, tuple(marks))


def _legend_places(names: Sequence[str], right: float) -> list[tuple[float, float]]:
    """Place the entries of a legend, in as many lines as it takes."""
    places, x, y = [], float(_LEFT), float(_TOP)
    for name in names:
        wide = 36 + 7 * len(name)
        if x > _LEFT and x + wide > right:
            x, y = float(_LEFT), y + _LINE
        places.append((x, y))
        x += wide
    return places


def bar_chart(title: str, unit: str, names: Sequence[str], values: Sequence[float], width: int = 520) -> Drawing:
    """Draw a horizontal bar for each name, in the order given; ValueError if a value is negative."""
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
        marks.append(Rectangle(left, y, max((right - left) * value / highest, 0.0), step - 6, SERIES[0]))
        marks.append(Label(left + (right - left) * value / highest + 6, y + 12, wording.short(value), 11, QUIET))
    return Drawing(width, _TOP + len(names) * step + 12, tuple(marks))


def bars(title: str, unit: str, names: Sequence[str], values: Sequence[float]) -> Drawing:
    """Draw a wide :func:`bar_chart` of the first rows of a table."""
    return bar_chart(title, unit, names[:_BARS], values[:_BARS], WIDE)


@dataclass(frozen=True)
class Trace:
    """A line over a map.

    Attributes
    ----------
    points : (n, 2) float array
        In cells: the centre of cell (x, y) is (x, y). Where a tiled floor is crossed, the line goes on from the other
        side.
    """

    points: np.ndarray
    color: Color


def map_chart(
    title: str,
    colors: np.ndarray,
    cell_size: float,
    legend: Sequence[Swatch | ColorBar] = (),
    traces: Sequence[Trace] = (),
    width: int = 520,
) -> Drawing:
    """Draw a floor seen from above, +Y upwards, with a scale of metres and a legend.

    Parameters
    ----------
    colors : (nx, ny, 3) float array
        sRGB of each cell, components from 0 to 1.
    cell_size : float
        Metres.
    traces : sequence of Trace
        Each begins with a dot.
    """
    nx, ny, _ = colors.shape
    pixels = np.round(255 * np.clip(colors, 0.0, 1.0)).astype(np.uint8).transpose(1, 0, 2)[::-1]
    scale = min((width - 32) / nx, 1.25 * width / ny)
    shown_width, shown_height = nx * scale, ny * scale
    left = (width - shown_width) / 2
    marks: list[Mark] = [Label(16, 24, title, 14, bold=True)]
    marks.append(Picture(left, _TOP - 6, shown_width, shown_height, np.ascontiguousarray(pixels)))
    for trace in traces:
        for stretch in _stretches(trace.points, nx, ny):
            marks.append(
                Line(
                    np.column_stack(
                        [left + (stretch[:, 0] + 0.5) * scale, _TOP - 6 + shown_height - (stretch[:, 1] + 0.5) * scale]
                    ),
                    trace.color,
                    2.0,
                )
            )
        first = (trace.points[0] + 0.5) % (nx, ny)
        marks.append(
            Rectangle(left + first[0] * scale - 4, _TOP - 10 + shown_height - first[1] * scale, 8, 8, trace.color)
        )
    y = _TOP + shown_height + 12
    metres = float(ticks(0.0, max(nx * cell_size / 5, cell_size), 2)[1])
    marks.append(Line(np.array([[left, y], [left + metres / cell_size * scale, y]]), INK, 3.0))
    marks.append(Label(left + metres / cell_size * scale + 8, y + 4, f"{wording.exact(metres)} m", 11))
    x, y = left, y + 10
    for entry in legend:
        words = f"{entry.text} {entry.value}".strip() if isinstance(entry, Swatch) else ""
        wide = 26 + 6.5 * len(words) if words else 190.0
        if x > left and x + wide > width - 16:
            x, y = left, y + _LINE
        if isinstance(entry, Swatch):
            marks.append(Rectangle(x, y, 12, 12, entry.color))
            marks.append(Label(x + 18, y + 11, words, 11))
        else:
            (_, lowest), (_, highest) = entry.ticks[0], entry.ticks[-1]
            marks.append(Label(x, y + 11, lowest, 11))
            start = x + 8 + 6.5 * len(lowest)
            ramp = np.round(255 * ColorScale("", entry.stops).colors(np.linspace(0, 1, 64))).astype(np.uint8)[None]
            marks.append(Picture(start, y, 90, 12, ramp))
            marks.append(Label(start + 98, y + 11, highest, 11))
            wide = start + 98 + 6.5 * len(highest) - x + 14
        x += wide
    return Drawing(width, round(y + 26), tuple(marks))


def _stretches(points: np.ndarray, nx: int, ny: int) -> list[np.ndarray]:
    """Cut a line into the pieces that lie on one copy of a tiled floor each, and move all onto the floor itself."""
    tile = np.floor((np.asarray(points) + 0.5) / (nx, ny)).astype(int)
    ends = np.flatnonzero(np.any(np.diff(tile, axis=0) != 0, axis=1)) + 1
    return [piece - of[0] * (nx, ny) for piece, of in zip(np.split(points, ends), np.split(tile, ends), strict=True)]
