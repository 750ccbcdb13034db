"""Findings as charts, drawn from the tables that are kept with the scene."""

from collections.abc import Callable

import numpy as np

from ...core.report.chart import Series, bar_chart, line_chart
from ...core.report.drawing import Drawing
from ...core.report.table import Table
from ..findings.finding import (
    ABLATION,
    ACTIONS,
    CAPTURE,
    OCCUPANCY,
    PRUNING_CURVE,
    REACH,
    TITLES,
    WEAK_SPOTS,
    find_finding,
    table_of,
)
from .raster import show_image

_BARS = 40
"""Bars of a chart at the most: the table has all."""

_WIDTH = 640


def _bars(title: str, unit: str, names, values) -> Drawing:
    return bar_chart(title, unit, list(names)[:_BARS], list(values)[:_BARS], _WIDTH)


def _actions(found: Table) -> Drawing:
    rows = sorted(found.rows, key=lambda row: -row[2])
    return _bars("Where clips can begin", "% of the floor", [r[0] for r in rows], [100 * r[2] for r in rows])


def _weak_spots(found: Table) -> Drawing:
    names = [f"{row[0].lower()} at {row[3]:.1f}, {row[4]:.1f} m" for row in found.rows]
    return _bars("Weak spots", "m²", names, [row[1] for row in found.rows])


def _ablation(found: Table) -> Drawing:
    kind = found.rows[0][1]
    return _bars(f"Lost without the {kind}", "m²", [r[0] for r in found.rows], [max(r[2], 0.0) for r in found.rows])


def _capture(found: Table) -> Drawing:
    names = [row[0] for row in found.rows]
    if any(row[4] > 0 for row in found.rows):
        return _bars("What one more motion would open", "m²", names, [row[4] for row in found.rows])
    unit = "positions and headings"
    return _bars("What one more motion would open", unit, names, [row[5] for row in found.rows])


def _occupancy(found: Table) -> Drawing:
    names, shares = [row[0] for row in found.rows], [100 * row[1] for row in found.rows]
    return _bars("What random walkers play", "% of the time", names, shares)


def _reach(found: Table) -> Drawing:
    return _bars("Floor within reach", "m²", [f"{row[0]:g} s" for row in found.rows], [row[1] for row in found.rows])


def _pruning_curve(found: Table) -> Drawing:
    k, nodes, links, floor, places = np.array(found.rows, dtype=float).T
    return line_chart(
        "What local pruning leaves",
        "segments kept at each place (k)",
        "%",
        [
            Series("floor", k, 100 * floor),
            Series("floor and headings", k, 100 * places),
            Series("nodes", k, 100 * nodes / max(nodes[-1], 1)),
            Series("links", k, 100 * links / max(links[-1], 1)),
        ],
        width=_WIDTH,
    )


CHARTS: dict[str, Callable[[Table], Drawing]] = {
    ACTIONS: _actions,
    WEAK_SPOTS: _weak_spots,
    ABLATION: _ablation,
    CAPTURE: _capture,
    OCCUPANCY: _occupancy,
    PRUNING_CURVE: _pruning_curve,
    REACH: _reach,
}


def chart_of(kept) -> Drawing | None:
    """The chart of a finding that is kept in a scene; None if its kind has none, or there is nothing to draw."""
    draw, found = CHARTS.get(kept.name), table_of(kept)
    return draw(found) if draw is not None and found.rows else None


def show_chart(scene, kind: str):
    """The image with the chart of the scene's finding of this kind; None if there is nothing to draw."""
    kept = find_finding(scene, kind)
    drawing = chart_of(kept) if kept is not None else None
    return show_image(f"Wayfarer {TITLES[kind]}", drawing) if drawing is not None else None
