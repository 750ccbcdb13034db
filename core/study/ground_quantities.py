"""Quantities read off maps and counts: also of grounds in parcels."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..report.quantity import Quantity
from .subject import Subject


def _area(subject: Subject, cells: np.ndarray) -> float:
    return int(np.count_nonzero(cells)) * subject.cell_size**2


def _share(subject: Subject, cells: np.ndarray) -> float:
    return int(np.count_nonzero(cells)) / max(int(np.count_nonzero(subject.free)), 1)


def _task_share(subject: Subject) -> float:
    n_places = int(np.count_nonzero(subject.free)) * subject.n_headings
    return int(subject.headings[subject.free].sum()) / max(n_places, 1)


def _of_ways(reduce: Callable[[np.ndarray], Any]) -> Callable[[Subject], float]:
    def number(subject: Subject) -> float:
        ways = subject.ways[subject.ways > 0]
        return reduce(ways).item() if len(ways) else 0

    return number


GROUND_QUANTITIES: dict[str, Quantity] = {
    "nodes": Quantity("nodes of the embedding", lambda s: s.n_nodes),
    "links": Quantity("links of the embedding", lambda s: s.n_links),
    "segments": Quantity("segments of the motion graph", lambda s: len(s.graph.segments)),
    "transitions": Quantity("links of the motion graph", lambda s: len(s.graph.links)),
    "motion": Quantity("motion in the graph", lambda s: sum(g.duration for g in s.graph.segments), "s"),
    "coverage": Quantity("share of the free floor", lambda s: _share(s, s.covered)),
    "covered_area": Quantity("floor that can be passed", lambda s: _area(s, s.covered), "m2"),
    "free_area": Quantity("free floor", lambda s: _area(s, s.free), "m2"),
    "heading_coverage": Quantity("share of positions x headings over free floor", _task_share),
    "places": Quantity("positions x headings that can be passed", lambda s: int(s.headings.sum())),
    "full_area": Quantity(
        "floor that can be passed in every heading",
        lambda s: _area(s, s.free & (s.headings == s.n_headings)),
        "m2",
    ),
    "variability": Quantity("ways through a cell, mean over those passed", _of_ways(np.mean)),
    "median_variability": Quantity("ways through a cell, median", _of_ways(np.median)),
    "highest_variability": Quantity("ways through the best cell", _of_ways(np.max)),
    "total_variability": Quantity("ways through all cells", _of_ways(np.sum)),
}
