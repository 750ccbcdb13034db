"""The results of a study as a page: what failed, charts over the settings, small floor maps side by side, the table."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from .. import wording
from ..maps.colors import RULED
from ..maps.scales import CIVIDIS, SERIES
from ..report.chart import Series, bar_chart, line_chart, map_chart
from ..report.drawing import Anchor, Drawing, Label, Mark, Picture, Rectangle
from ..report.page import Block, Bullets, Figure, FigureRow, Paragraph, Section, html_page
from .maps import BLOCKED, NOT_REACHED, shaded
from .measures import QUANTITIES, Measure
from .picture import NOT_PASSED, ONLY_CROSSED, SmallMap
from .plan import shown
from .results import failures, results_table
from .run import CaseOutcome, StudyOutcome

#: Small maps on a page, at most: a browser has to show it.
MAX_MAPS = 200
_MAP_WIDTH, _CHART_WIDTH = 210, 520


def study_page(outcome: StudyOutcome) -> str:
    """Write the page as HTML that needs nothing from elsewhere."""
    done = [entry for entry in outcome.outcomes if entry.result is not None]
    sections = []
    if outcome.n_failed:
        sections.append(Section("What failed", (Bullets(tuple(failures(outcome))),)))
    if done:
        sections.append(Section("Measures", tuple(_charts(outcome, done))))
        sections.append(Section("Floor maps", tuple(_maps(outcome, done))))
    sections.append(Section("All cases", (results_table(outcome),)))
    return html_page(outcome.plan.title, _lead(outcome), sections)


def _lead(outcome: StudyOutcome) -> str:
    plan, n_cases = outcome.plan, len(outcome.outcomes)
    fixed = {name: values[0] for name, values in plan.settings.items() if len(values) == 1}
    said = ", ".join(f"{name} {shown(name, value)}" for name, value in fixed.items())
    ready = n_cases - outcome.n_failed
    sizes = f"{wording.counted(len(plan.scenes), 'scene')}, {wording.counted(len(plan.clip_sets), 'clip set')}"
    cases = f"{wording.counted(n_cases, 'case')} ({sizes}), {ready} of them with results."
    return cases + (f" With {said}." if said else "")


# ------------------------------------------------------------------------------------------------------ charts


def _charts(outcome: StudyOutcome, done: Sequence[CaseOutcome]) -> list[Block]:
    """For each measure a row of charts, one for each scene on the same scale, or one of bars.

    Cases without an answer are left out, which is said: it is not 0.
    """
    axis = _axis(outcome)
    blocks: list[Block] = []
    for measure in outcome.plan.measures:
        known = [(entry, number) for entry in done if (number := _number(entry, measure)) is not None]
        said = f"{measure.column}: {QUANTITIES[measure.quantity].meaning}."
        if len(known) < len(done):
            said += f" Without an answer, and left out: {wording.counted(len(done) - len(known), 'case')}."
        if not known:
            blocks.append(Paragraph(f"{measure.column}: no case has an answer."))
        elif axis is None or all(axis not in entry.case.values for entry, _ in known):
            blocks.append(Figure(_bars(outcome, measure, known), said))
        else:
            figures = []
            values = [number for _, number in known]
            for scene, of_scene in groupby(known, key=lambda place: place[0].case.scene):
                drawing = _lines(outcome, measure, axis, scene, list(of_scene), (min(values), max(values)))
                if drawing is not None:
                    figures.append(Figure(drawing))
            if figures:
                blocks.append(Paragraph(said))
                blocks.append(FigureRow(tuple(figures)))
    return blocks


def _axis(outcome: StudyOutcome) -> str | None:
    """Return the setting of most values that are numbers, which charts are drawn over; None if none varies.

    k stays aside: "all" is no number.
    """
    varied = {
        name: values
        for name, values in outcome.plan.varied.items()
        if name != "k" and not isinstance(values[0], bool | str)
    }
    return max(varied, key=lambda name: len(varied[name]), default=None)


def _lines(
    outcome: StudyOutcome,
    measure: Measure,
    axis: str,
    scene: str,
    known: Sequence[tuple[CaseOutcome, float]],
    span: tuple[float, float],
) -> Drawing | None:
    """Draw a measure over a setting in one scene, on the scale of all scenes: a curve for each set of the others."""
    curves: dict[str, list[tuple[float, float]]] = {}
    others = [name for name in outcome.plan.varied if name != axis]
    for entry, number in known:
        if axis in entry.case.values:
            said = [f"{name} {shown(name, entry.case.values[name])}" for name in others if name in entry.case.values]
            place = float(entry.case.values[axis]), number
            curves.setdefault(", ".join([entry.case.clips, *said]), []).append(place)
    if not curves:
        return None
    series = [Series(name, *np.array(sorted(points)).T) for name, points in curves.items()]
    # More curves than colours could not be told apart.
    series = series[: len(SERIES)]
    left_out = len(curves) - len(series)
    title = f"{measure.name} in {scene}" + (f" ({left_out} more curves: see the table)" if left_out else "")
    return line_chart(title, axis, measure.column, series, _CHART_WIDTH, span=span)


def _bars(outcome: StudyOutcome, measure: Measure, known: Sequence[tuple[CaseOutcome, float]]) -> Drawing:
    names = [entry.case.label(outcome.plan.varied) for entry, _ in known]
    values = [number for _, number in known]
    if min(values) < 0:
        x = np.arange(1, len(values) + 1)
        return line_chart(measure.name, "case", measure.column, [Series(measure.name, x, np.array(values))])
    return bar_chart(measure.name, QUANTITIES[measure.quantity].unit, names, values, _CHART_WIDTH)


def _number(entry: CaseOutcome, measure: Measure) -> float | None:
    number = None if entry.result is None else entry.result.numbers.get(measure.name)
    return None if number is None else float(number)


# -------------------------------------------------------------------------------------------------------- maps


def _maps(outcome: StudyOutcome, done: Sequence[CaseOutcome]) -> list[Block]:
    """For each scene a row of its floor maps, all maps on one scale."""
    highest = max((_highest(entry.result.picture) for entry in done if entry.result is not None), default=1.0)
    highest = max(highest, 1.0)
    blocks: list[Block] = [
        Paragraph("Ways through each cell, the same colours on all maps; red floor is free, but nothing passes.")
    ]
    blocks.append(Figure(_legend(highest)))
    for scene, of_scene in groupby(done[:MAX_MAPS], key=lambda entry: entry.case.scene):
        figures = []
        for entry in of_scene:
            if entry.result is not None:
                title = entry.case.label(outcome.plan.varied).removeprefix(f"{scene}, ")
                first = outcome.plan.measures[0]
                number = entry.result.numbers.get(first.name)
                said = f": {first.column} {wording.short(number)}" if number is not None else ""
                figures.append(Figure(_map(entry.result.picture, highest), title + said))
        blocks.append(Paragraph(f"{scene}:"))
        blocks.append(FigureRow(tuple(figures)))
    if len(done) > MAX_MAPS:
        blocks.append(Paragraph(f"{len(done) - MAX_MAPS} more maps are left out."))
    return blocks


def _highest(picture: SmallMap) -> float:
    return float(np.nanmax(picture.levels, initial=0.0)) if picture.levels.size else 0.0


def _colors(picture: SmallMap, highest: float) -> np.ndarray:
    levels = picture.levels.astype(float)
    return shaded(levels / highest, levels >= 0, levels == NOT_PASSED, levels == ONLY_CROSSED)


def _map(picture: SmallMap, highest: float) -> Drawing:
    return map_chart("", _colors(picture, highest), picture.cell_size, width=_MAP_WIDTH)


def _legend(highest: float) -> Drawing:
    """Draw the colours of the maps, with round powers of ten."""
    left, width = 24, 240
    ramp = np.round(255 * CIVIDIS.colors(np.linspace(0, 1, 64))).astype(np.uint8)[None]
    marks: list[Mark] = [Picture(left, 12, width, 14, ramp)]
    for power in range(0, int(highest) + 1, max(1, int(highest) // 4)):
        x = left + width * power / highest
        marks.append(Label(x, 42, wording.short(10.0**power), 11, anchor=Anchor.MIDDLE))
    x = left + width + 30
    for color, text, wide in (
        (NOT_REACHED, "Not reached", 120),
        (BLOCKED, "Blocked", 100),
        (RULED, "Only crossed, under a rule", 200),
    ):
        marks += [Rectangle(x, 12, 14, 14, color), Label(x + 20, 23, text, 12)]
        x += wide
    return Drawing(x, 52, tuple(marks))
