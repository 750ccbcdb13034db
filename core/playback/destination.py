"""Destinations of walks: a place, perhaps with a direction to face; and why nobody can get there, if so."""

from collections.abc import Sequence

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..errors import EvaluationError, WalkError
from ..evaluation.goals import facing, goal_at
from ..evaluation.why_not import Reason, floor_reasons, why_not_steps
from ..progress import finish

_BECAUSE = {
    Reason.BLOCKED: "An obstacle is closer than the character's radius.",
    Reason.FORBIDDEN: "The regions allow no frame there.",
    Reason.NO_WAY_OUT: "Walks lead there, but none leads back.",
    Reason.NO_WAY_IN: "Walks lead away from there, but none leads to it.",
    Reason.NO_MATCH: "Walks lead there and away, but by clips that cannot follow one another.",
    Reason.OTHER_COMPONENT: "Walks pass there, but none connects it with the rest of the floor.",
    Reason.UNREACHABLE: "No clip fits in there.",
    Reason.NO_GROUND: "There is no ground.",
}


def destination(
    embedding: Embedding,
    position: Sequence[float],
    radius: float = 0.0,
    heading: float | None = None,
    tolerance: float = 0.0,
) -> NodeSet:
    """Return the nodes within ``radius`` metres of world x, y that face ``heading`` (rad), or any way if it is None.

    Raises
    ------
    WalkError
        Off the ground, in an obstacle, or where no walk passes: with the reason, and the nearest place that can be
        reached (:func:`..evaluation.goals.goal_at`).
    """
    try:
        goal = goal_at(embedding, (float(position[0]), float(position[1])), radius)
        return goal if heading is None else facing(embedding, goal, heading, tolerance)
    except EvaluationError as error:
        reason = reason_at(embedding, position)
        because = None if reason is None else _BECAUSE.get(reason)
        raise WalkError(f"{error} {because}" if because else str(error)) from error


def reason_at(embedding: Embedding, position: Sequence[float]) -> Reason | None:
    """Find why the cell at a world position cannot be reached in most of its headings; None off the ground."""
    grid = embedding.environment.grid
    if not np.isfinite(position).all():
        return None
    cell = grid.cells(np.asarray(position, dtype=float)[:2])
    if grid.tiled:
        cell = cell % grid.shape[:2]
    elif np.any(cell < 0) or np.any(cell >= grid.shape[:2]):
        return None
    return Reason(int(floor_reasons(finish(why_not_steps(embedding)))[tuple(cell)]))
