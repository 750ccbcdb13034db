"""Fig. 4: how the reach of repeated steps grows, in theory and on the grid."""

import numpy as np
from scipy.spatial import ConvexHull

from ...core import wording
from ...core.embedding.footprint import FootprintSettings
from ...core.embedding.growth import gridded_growth, theoretical_growth
from ...core.environment.grid import Grid
from ...core.maps.scales import SERIES
from ...core.motion.graph import MotionSegment
from ...core.report.chart import Series, line_chart
from ...core.report.drawing import INK, QUIET, Anchor, Color, Drawing, Label, Line, Mark, Rectangle
from ...core.report.page import Figure, FigureRow, Paragraph, Section
from .chapter import Chapter, Comparison

N_STEPS = 4
_SAMPLES = 20_000
_WIDE = FootprintSettings(position_rate=0.15, heading_rate=0.12)
_WIDTH, _HEIGHT, _TOP = 520, 580, 66


def draw_footprint_growth(n_samples: int = _SAMPLES) -> Chapter:
    """Reach of one to four repetitions of a metre of walk, straight and turning, on two grids."""
    grids = (Grid((1, 1, 24), 0.125), Grid((1, 1, 72), 0.0625))
    figures, ratios = {}, {}
    for name, turn in (("straight", 0.0), ("turning", 0.5)):
        segment = _arc(1.0, turn)
        theory = theoretical_growth(segment, _WIDE, N_STEPS, np.random.default_rng(0), n_samples)
        hulls = [ConvexHull(ends[:, :2]) for ends in theory]
        for grid in grids:
            grown = gridded_growth(segment, grid, _WIDE, N_STEPS)
            cells = [np.unique(ends[:, :2], axis=0) for ends in grown]
            cell, angle = 100 * grid.cell_size, np.degrees(grid.heading_step)
            title = f"1 m {name}: cells of {wording.exact(cell)} cm, headings of {wording.exact(angle)}°"
            outlines = [ends[hull.vertices, :2] for ends, hull in zip(theory, hulls, strict=True)]
            figures[f"figure_4_{name}_{cell:g}cm"] = _chart(title, cells, grid.cell_size, outlines)
            ratios[name, grid.cell_size] = [
                len(found) * grid.cell_size**2 / hull.volume for found, hull in zip(cells, hulls, strict=True)
            ]
    steps = np.arange(1, N_STEPS + 1)
    growth = line_chart(
        "Area on the grid, as a multiple of that in theory",
        "steps",
        "times",
        [Series(f"{n}, {wording.exact(100 * c)} cm", steps, np.array(r)) for (n, c), r in ratios.items()],
    )
    figures["figure_4_ratio"] = growth
    coarse = ratios["straight", 0.125][-1], ratios["turning", 0.125][-1]
    fine = ratios["straight", 0.0625][-1], ratios["turning", 0.0625][-1]
    captions = "Outlines: in theory, by random edits within the footprint. Squares: cells reached on the grid."
    return Chapter(
        Section(
            "Fig. 4: footprint growth, theoretical against gridded",
            (
                Paragraph(
                    "Where repeated steps may end, with edits of up to 0.15 m and 0.12 rad for each metre of path. A "
                    "grid that is too coarse would promise more or less than edits allow: between 15° headings, edits "
                    "of 0.12 rad (6.9°) never reach the next one, so that there the reach does not fan out. After "
                    f"{N_STEPS} steps the gridded area is {wording.amount(coarse[0])} (straight) and "
                    f"{wording.amount(coarse[1])} times (turning) the theoretical one with the paper's grid, "
                    f"{wording.amount(fine[0])} and {wording.amount(fine[1])} times with cells half as large and "
                    "headings a third as far apart."
                ),
                FigureRow(tuple(Figure(chart, captions) for name, chart in figures.items() if "cm" in name)),
                Figure(growth, "Cells count with their whole area, which makes one step on a coarse grid look large."),
            ),
        ),
        figures=figures,
        numbers={f"{name}_{100 * cell:g}cm": ratio for (name, cell), ratio in ratios.items()},
        comparisons=(
            Comparison(
                "Fig. 4: gridded / theoretical area after 4 steps",
                "drawn",
                f"{wording.amount(coarse[0])} straight, {wording.amount(coarse[1])} turning",
                "Drawn without a number in the paper; 1 would be the same. Edits of less than half a heading do not "
                f"spread on the grid; with 5° headings it is {wording.amount(fine[0])} and {wording.amount(fine[1])}.",
            ),
        ),
    )


def _arc(length: float, turn: float) -> MotionSegment:
    """A walk of ``length`` metres that turns by ``turn`` radians."""
    t = np.linspace(0, 1, 31)
    middle = turn * (t[1:] + t[:-1]) / 2
    steps = np.column_stack([np.cos(middle), np.sin(middle)]) * length / 30
    xy = np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)])
    return MotionSegment("arc", 0, 0, 30, np.column_stack([xy, turn * t]), 1.0, {})


def _chart(title: str, cells: list[np.ndarray], cell_size: float, outlines: list[np.ndarray]) -> Drawing:
    """Cells (n, 2) and theoretical outlines (m, 2) in metres, after each step; the same metre across all charts."""
    low, high = np.array([-0.3, -1.6]), np.array([4.9, 3.4])
    scale = min((_WIDTH - 32) / (high - low)[0], (_HEIGHT - _TOP - 40) / (high - low)[1])

    def place(points):
        points = np.asarray(points, dtype=float)
        return np.stack([16 + (points[..., 0] - low[0]) * scale, _TOP + (high[1] - points[..., 1]) * scale], axis=-1)

    marks: list[Mark] = [Label(16, 24, title, 14, bold=True)]
    x = 16.0
    for step in range(len(cells)):
        marks += [
            Rectangle(x, 38, 12, 12, _tint(SERIES[step])),
            Label(x + 18, 49, f"{step + 1} step{'s' * (step > 0)}", 12),
        ]
        x += 78
    side = max(cell_size * scale - 0.6, 0.5)
    for step in reversed(range(len(cells))):
        for px, py in place(cells[step] * cell_size):
            marks.append(Rectangle(px - side / 2, py - side / 2, side, side, _tint(SERIES[step])))
    for step, outline in enumerate(outlines):
        marks.append(Line(place(np.concatenate([outline, outline[:1]])), SERIES[step], 2.0))
    start = place([0.0, 0.0])
    marks += [Rectangle(start[0] - 3, start[1] - 3, 6, 6, INK), Line(place([[0.0, 0.0], [0.25, 0.0]]), INK, 2.0)]
    base = _HEIGHT - 18
    marks += [Line(np.array([[16, base], [16 + scale, base]]), INK, 3.0), Label(24 + scale, base + 4, "1 m", 11)]
    marks.append(Label(_WIDTH - 16, base + 4, "start: black square, facing right", 11, QUIET, Anchor.END))
    return Drawing(_WIDTH, _HEIGHT, tuple(marks))


def _tint(color: Color) -> Color:
    red, green, blue = (0.45 * c + 0.55 for c in color)
    return red, green, blue
