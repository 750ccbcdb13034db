"""The tables of what was found out: the same columns wherever they are shown or written."""

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.link_utility import LinkUtility
from ..evaluation.maneuverability import PROMPT
from ..evaluation.metrics import Metrics
from ..evaluation.reach import ReachField
from ..evaluation.weak_spots import WeakSpots
from ..tuning.pruning_curve import PruningCurve
from .table import Table, table


def metrics_table(found: Metrics) -> Table:
    """A row for each number."""
    return table(("metric", "value", "unit"), found.rows())


def actions_table(found: Metrics) -> Table:
    """Where and how soon each clip can begin, least floor first."""
    rows = []
    for index in found.actions.ranked():
        action, wait = found.actions.actions[index], found.prompt[index]
        area, share = float(found.actions.areas[index]), float(found.actions.shares[index])
        rows.append((action.name, area, share, wait.mean, wait.worst, wait.at_once, wait.promptly))
    columns = ("clip", "can begin on (m2)", "share of the free floor", "mean wait (s)", "worst wait (s)")
    return table((*columns, "share of nodes at once", f"share of nodes within {wording.exact(PROMPT)} s"), rows)


def links_table(embedding: Embedding, found: LinkUtility) -> Table:
    """Uses of each link of the motion graph, and the nodes that hang on it; what most hangs on first."""
    order = np.lexsort((-found.link_uses, -found.link_dependents)).tolist()
    ends, costs = found.links.tolist(), embedding.graph.link_costs.tolist()
    rows = [
        (*(found.names[end] for end in ends[i]), int(found.link_uses[i]), int(found.link_dependents[i]), costs[i])
        for i in order
    ]
    return table(("from", "to", "uses", "nodes that die without it", "cost (rad2)"), rows)


def weak_spots_table(found: WeakSpots) -> Table:
    """A row for each weak spot, largest first."""
    columns = ("weakness", "area (m2)", "floor (m2)", "x (m)", "y (m)", "heading (rad)", "share of headings")
    columns += ("mean variability", "lowest variability", "reason", "share with this reason")
    return table(
        columns,
        [
            (
                spot.weakness.value,
                spot.area,
                spot.floor_area,
                *spot.position,
                spot.heading,
                spot.heading_share,
                spot.mean_variability,
                spot.lowest_variability,
                spot.reason.name.lower(),
                spot.reason_share,
            )
            for spot in found.spots
        ],
    )


def pruning_table(curve: PruningCurve) -> Table:
    """What local pruning leaves for each k."""
    arrays = (curve.k, curve.n_nodes, curve.n_links, curve.floor_coverage, curve.coverage)
    columns = ("k", "nodes", "links", "share of the floor", "share of floor and headings")
    return table(columns, list(zip(*(array.tolist() for array in arrays), strict=True)))


def reach_table(field: ReachField, times: tuple[float, ...]) -> Table:
    """The area within each of some times (s), and its share of the covered floor."""
    grid = field.embedding.environment.grid
    covered = float(np.count_nonzero(field.embedding.covered().any(axis=2)) * grid.cell_size**2)
    areas = field.areas(times)
    rows = [(time, area, area / covered if covered else 0.0) for time, area in zip(times, areas, strict=True)]
    return table(("time (s)", "area (m2)", "share of the covered floor"), rows)
