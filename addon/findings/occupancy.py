"""Occupancy: where random walkers spend their time."""

from collections.abc import Generator

import numpy as np

from ...core.embedding.embedding import Embedding
from ...core.evaluation.occupancy import occupancy_steps
from ...core.progress import Progress
from ...core.report.table import table
from .finding import OCCUPANCY, Finding, Row

_LISTED = 20
"""Segments in the list; the table has all."""


def occupancy_finding_steps(embedding: Embedding) -> Generator[Progress, None, Finding]:
    """How evenly walkers that take every link with the same probability use the floor and the segments."""
    found = yield from occupancy_steps(embedding)
    graph, (x, y) = embedding.graph, found.hot_spot
    order = np.argsort(-found.segments, kind="stable").tolist()
    rows = [(graph.segments[i].name, float(found.segments[i])) for i in order]
    return Finding(
        OCCUPANCY,
        embedding,
        table(("segment", "share of the time"), rows),
        numbers=(
            ("Used as if Evenly", f"{found.effective_area:.1f} of {found.visited_area:.1f} m²"),
            ("Half the Time On", f"{found.half_time_share:.0%} of that"),
            ("Busiest Place", f"{x:.1f}, {y:.1f} m"),
        ),
        rows=tuple(Row(name, f"{share:.1%}", icon="ANIM_DATA") for name, share in rows[:_LISTED]),
        sentences=tuple(found.describe()),
    )
