"""Findings as charts, drawn from the tables that are kept with the scene."""

from collections.abc import Callable, Sequence

import numpy as np

from ....core.report.chart import Series, bar_chart, line_chart
from ....core.report.drawing import Drawing
from ....core.report.table import Table
from ...bridge.text import exact, place
from ...render.raster import show_image
from .finding import (
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

_BARS = 40
"""Bars of a chart at the most: the table has all."""

_WIDTH = 640


def _bars(title: str, unit: str, names: Sequence[str], values: Sequence[float]) -> Drawing:
    return bar_chart(title, unit, names[:_BARS], values[:_BARS], _WIDTH)


def _words(found: Table, column: int = 0) -> list[str]:
    return [str(row[column]) for row in found.rows]


def _numbers(found: Table, column: int) -> list[float]:
    return np.array([row[column] for row in found.rows], dtype=float).tolist()


def _actions(found: Table) -> Drawing:
    rows = sorted(zip(_words(found), _numbers(found, 2), strict=True), key=lambda row: -row[1])
    return _bars("Where clips can begin", "% of the floor", [clip for clip, _ in rows], [100 * x for _, x in rows])


def _weak_spots(found: Table) -> Drawing:
    places = zip(_words(found), _numbers(found, 3), _numbers(found, 4), strict=True)
    names = [f"{kind.lower()} at {place(x, y)}" for kind, x, y in places]
    return _bars("Weak spots", "m²", names, _numbers(found, 1))


def _ablation(found: Table) -> Drawing:
    kind = _words(found, 1)[0]
    return _bars(f"Lost without the {kind}", "m²", _words(found), [max(lost, 0.0) for lost in _numbers(found, 2)])


def _capture(found: Table) -> Drawing:
    opened, unit = _numbers(found, 4), "m²"
    if max(opened) <= 0:
        opened, unit = _numbers(found, 5), "positions and headings"
    return _bars("What one more motion would open", unit, _words(found), opened)


def _occupancy(found: Table) -> Drawing:
    return _bars("What random walkers play", "% of the time", _words(found), [100 * x for x in _numbers(found, 1)])


def _reach(found: Table) -> Drawing:
    return _bars("Floor within reach", "m²", [f"{exact(limit)} s" for limit in _numbers(found, 0)], _numbers(found, 1))


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
