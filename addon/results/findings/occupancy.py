"""Occupancy: where random walkers spend their time."""

from collections.abc import Generator

import numpy as np

from ....core import wording
from ....core.embedding.embedding import Embedding
from ....core.evaluation.occupancy import occupancy_steps
from ....core.progress import Progress
from ....core.report.table import table
from .finding import OCCUPANCY, Finding, Row

_LISTED = 20
"""Segments in the list; the table has all."""


def occupancy_finding_steps(embedding: Embedding) -> Generator[Progress, None, Finding]:
    """How evenly walkers that take every link with the same probability use the floor and the segments."""
    found = yield from occupancy_steps(embedding)
    graph = embedding.graph
    order = np.argsort(-found.segments, kind="stable").tolist()
    rows = [(graph.segments[i].name, float(found.segments[i])) for i in order]
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
        rows=tuple(Row(name, wording.share(share), icon="ANIM_DATA") for name, share in rows[:_LISTED]),
        sentences=tuple(found.describe()),
    )
