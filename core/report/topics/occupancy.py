"""Occupancy: time that random walkers spend on the floor and in the segments."""

from collections.abc import Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.occupancy import Occupancy, occupancy_steps
from ...maps.scales import CIVIDIS
from ...progress import Progress, finish
from ..chart import bars
from ..drawing import Drawing
from ..finding import Contribution, Finding, Questions, Row, Topic
from ..floor_chart import amount_chart
from ..page import Figure, Paragraph, Section
from ..quantity import Options, Quantity
from ..table import Table, table

_LISTED = 20
"""Segments in the list; the table has all."""


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    found = yield from occupancy_steps(embedding, tolerance=1e-5 if questions.thorough else 1e-4)
    order, segments = np.argsort(-found.segments, kind="stable").tolist(), embedding.graph.segments
    rows = [(segments[i].name, float(found.segments[i])) for i in order]
    said = tuple(found.describe())
    return Finding(
        OCCUPANCY,
        embedding,
        table(("segment", "share of the time"), rows),
        numbers=(
            ("Evenly Used Floor", f"{wording.amount(found.effective_area)} of {wording.area(found.visited_area)}"),
            ("Half the Time On", f"{wording.share(found.half_time_share)} of it"),
            ("Busiest Place", wording.place(*found.hot_spot)),
            ("Exact But For", f"{wording.share(found.error)} of the time"),
        ),
        rows=tuple(Row(name, wording.share(share), sign="segment") for name, share in rows[:_LISTED]),
        sentences=said,
        summary=said[2].rstrip("."),
        contribute=lambda: _contribution(embedding, questions, found),
    )


def _contribution(embedding: Embedding, questions: Questions, found: Occupancy) -> Contribution:
    # Counted in the mean, so that the scale, which starts at 1, has something to tell apart.
    times_mean = found.floor * np.count_nonzero(found.floor)
    chart = amount_chart(
        questions.floor_scene(embedding),
        "Where random walkers spend their time",
        times_mean,
        "times the mean",
        "never passed",
        scale=CIVIDIS,
        least="little",
    )
    caption = (
        "Time spent in each cell in the long run, if each link is taken with the same probability, compared to the "
        "mean over all cells that are passed."
    )
    return Contribution(
        Section("Where does it spend its time?", (Paragraph(" ".join(found.describe())), Figure(chart, caption))),
        numbers={
            "half_time_share": found.half_time_share,
            "effective_m2": found.effective_area,
            "hot_spot_m": list(found.hot_spot),
        },
        maps={"occupancy": chart},
    )


def _chart(found: Table) -> Drawing:
    return bars("What random walkers play", "% of the time", found.texts(0), [100 * x for x in found.values(1)])


def _asked(embedding: Embedding, _: Options) -> Occupancy:
    return finish(occupancy_steps(embedding))


OCCUPANCY = Topic(
    "OCCUPANCY",
    "Occupancy",
    _find_steps,
    operator="find_occupancy",
    button="Find Occupancy",
    help="Where walkers that take every link with the same probability spend their time in the long run, and which "
    "segments they play; the map Occupancy paints it",
    columns="Share of the Time",
    chart=_chart,
    section="occupancy",
    effort=12,
    quantities={
        "visited_area": Quantity("floor that random walkers pass", lambda found: found.visited_area, "m2", find=_asked),
        "effective_area": Quantity(
            "floor that random walkers would use evenly", lambda found: found.effective_area, "m2", find=_asked
        ),
        "half_time_share": Quantity(
            "share of the floor on which random walkers spend half of their time",
            lambda found: found.half_time_share,
            find=_asked,
        ),
        "crowding": Quantity(
            "time spent at the busiest place, times the mean over the floor passed",
            lambda found: float(found.density.max()) * found.visited_area,
            find=_asked,
        ),
    },
)
