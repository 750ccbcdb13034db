"""Areas within a few seconds of a goal, or from it (paper, section 4.1.2 and Fig. 8)."""

import numpy as np

from ...core.evaluation.reach import ReachField
from ...core.report.table import table
from ..query import Query
from .finding import REACH, Finding


def reach_finding(field: ReachField, query: Query) -> Finding:
    """The areas (m2) within each of the query's times, and the longest time."""
    embedding = field.embedding
    areas, seconds = field.areas(query.times), field.floor()
    covered = float(np.count_nonzero(embedding.covered().any(axis=2)) * embedding.environment.grid.cell_size**2)
    rows = [(time, area, area / covered if covered else 0.0) for time, area in zip(query.times, areas, strict=True)]
    longest = float(seconds[np.isfinite(seconds)].max(initial=0.0))
    numbers = [(f"Within {time:g} s", f"{area:.1f} m² ({share:.0%})") for time, area, share in rows]
    return Finding(
        REACH,
        embedding,
        table(("time (s)", "area (m2)", "share of the covered floor"), rows),
        numbers=(*numbers, ("Longest", f"{longest:.1f} s")),
        sentences=(query.title,),
    )
