"""Detours: the long way around. How much longer it takes to get to a place nearby than the distance would say.

For places all over the covered floor: the time of the quickest walk to other places one to two metres away, less the
time that the geodesic to them takes at the mean speed of the motions. A place with a long detour is one that a player
would not expect: the goal is at hand, and the character walks off.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..environment.grid import Grid
from ..errors import EvaluationError
from ..motion.graph import MotionGraph
from ..progress import Progress, portion
from .geodesic import Geodesics
from .goals import goal_at
from .reach import time_to_reach_steps


@dataclass(frozen=True)
class Detours:
    """Detours from every place to some goals nearby.

    Attributes
    ----------
    goals : (n, 2) int array
        Cells: the goals that were looked at.
    n_near : (nx, ny) int array
        How many goals each place has nearby.
    mean, worst : (nx, ny) float array
        Seconds by which the quickest walk takes longer than the geodesic, in the mean over the goals nearby and to the
        worst of them; not a number where there is none. The start's heading is the mean over all that are covered
        there, the one on arrival is free. Quick motions may make the mean negative.
    worst_goal : (nx, ny, 2) int array
        The cell of the worst goal; -1 where there is none.
    radii : (float, float)
        Metres of geodesic between which a goal is nearby.
    speed : float
        Metres per second.
    grid : Grid
    """

    goals: np.ndarray
    n_near: np.ndarray
    mean: np.ndarray
    worst: np.ndarray
    worst_goal: np.ndarray
    radii: tuple[float, float]
    speed: float
    grid: Grid

    def describe(self) -> str:
        known = self.n_near > 0
        place = np.unravel_index(np.nanargmax(np.where(known, self.worst, np.nan)), known.shape)
        (x, y), (u, v) = self.grid.positions(np.array([place, self.worst_goal[place]]))
        return (
            f"To a place {wording.exact(self.radii[0])} to {wording.exact(self.radii[1])} m away, facing anywhere, it "
            f"takes {wording.time(self.mean[known].mean())} longer than straight there at {wording.speed(self.speed)}, "
            f"on average over {wording.counted(len(self.goals), 'goal')} on a lattice. The longest way around takes "
            f"{wording.time(self.worst[place])} longer, from {wording.place(x, y)} to {wording.place(u, v)}."
        )


def mean_speed(graph: MotionGraph) -> float:
    """Metres per second over all segments of a motion graph, one after the other; EvaluationError if none travels."""
    length = sum(np.linalg.norm(np.diff(segment.path[:, :2], axis=0), axis=1).sum() for segment in graph.segments)
    if not length > 0:
        raise EvaluationError("No segment of the motion graph travels: there is no speed to compare with; add clips.")
    return float(length / sum(segment.duration for segment in graph.segments))


def detours_steps(
    embedding: Embedding, spacing: float = 1.0, radii: tuple[float, float] = (1.0, 2.0), speed: float | None = None
) -> Generator[Progress, None, Detours]:
    """The long way around from every place that the embedding covers.

    Parameters
    ----------
    spacing : float
        Metres between the goals that are looked at, on a square lattice over the ground: each of them costs one field
        of exact times.
    radii : (float, float)
        Metres of geodesic between which a goal counts as nearby.
    speed : float, optional
        Metres per second; :func:`mean_speed` by default.

    Raises
    ------
    EvaluationError
        The embedding is empty, nothing travels, no place has a goal nearby, or a length is not positive.
    """
    if not (spacing > 0 and 0 < radii[0] <= radii[1]):
        raise EvaluationError(
            f"Goals every {spacing} m, from {radii[0]} to {radii[1]} m away, cannot be looked at; give lengths greater "
            "than zero, the nearer one first."
        )
    speed = mean_speed(embedding.graph) if speed is None else speed
    if not speed > 0:
        raise EvaluationError(f"The speed is {speed} m/s; it must be greater than zero.")
    environment = embedding.environment
    covered = embedding.covered()
    on_floor = covered.any(axis=2)
    nx, ny = on_floor.shape
    step = max(round(spacing / environment.grid.cell_size), 1)
    lattice = np.zeros_like(on_floor)
    lattice[(nx - 1) % step // 2 :: step, (ny - 1) % step // 2 :: step] = True
    goals = np.argwhere(lattice & on_floor)
    yield Progress(0.0, "Measuring the ground")
    geodesics = Geodesics(environment)
    total, n_near = np.zeros((nx, ny)), np.zeros((nx, ny), dtype=int)
    worst, worst_goal = np.full((nx, ny), -np.inf), np.full((nx, ny, 2), -1)
    for done, goal in enumerate(goals):
        metres = geodesics.distances(goal, limit=radii[1])[0]
        near = on_floor & (metres >= radii[0]) & (metres <= radii[1])
        if not near.any():
            continue
        steps = time_to_reach_steps(embedding, goal_at(embedding, environment.grid.positions(goal)))
        field = yield from portion(steps, done / len(goals), (done + 1) / len(goals))
        seconds = np.where(covered[near], field.quickest()[near], 0).sum(axis=1) / covered[near].sum(axis=1)
        longer = seconds - metres[near] / speed
        total[near] += longer
        n_near[near] += 1
        worse = np.zeros_like(near)
        worse[near] = longer > worst[near]
        worst_goal[worse] = goal
        worst[near] = np.maximum(worst[near], longer)
    if not n_near.any():
        raise EvaluationError(
            f"No place that the embedding covers has another one {wording.exact(radii[0])} to "
            f"{wording.exact(radii[1])} m away; give it more room, or look at nearer goals."
        )
    mean = np.divide(total, n_near, out=np.full((nx, ny), np.nan), where=n_near > 0)
    worst[n_near == 0] = np.nan
    return Detours(goals, n_near, mean, worst, worst_goal, radii, speed, environment.grid)
