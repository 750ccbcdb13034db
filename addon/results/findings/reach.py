"""Areas within a few seconds of a goal, or from it (paper, section 4.1.2 and Fig. 8)."""

import numpy as np

from ....core import wording
from ....core.evaluation.query import Query
from ....core.evaluation.reach import ReachField
from ....core.report.finding_tables import reach_table
from .finding import REACH, Finding


def reach_finding(field: ReachField, query: Query) -> Finding:
    """The areas (m2) within each of the query's times, and the longest time."""
    embedding = field.embedding
    found, seconds = reach_table(field, query.times), field.floor()
    longest = float(seconds[np.isfinite(seconds)].max(initial=0.0))
    rows = np.array(found.rows, dtype=float).tolist()
    numbers = [
        (f"Within {wording.exact(time)} s", f"{wording.area(area)} ({wording.share(share)})")
        for time, area, share in rows
    ]
    return Finding(
        REACH,
        embedding,
        found,
        numbers=(*numbers, ("Longest", wording.time(longest))),
        sentences=(query.title,),
    )
