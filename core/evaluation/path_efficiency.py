"""Path efficiency: how close the quickest ways come to the shortest ones (Reitsma & Pollard 2007).

Between two places, the efficiency is the time that the geodesic of the free ground takes at the mean speed of the
motions, as a share of the time that the quickest walk of the embedding takes: 1 if the character goes straight there
as if it could start at that speed in any direction, 0.5 if it takes twice as long. The walk may start and end in any
heading. Recorded motions vary in speed, so that a quick one may reach more than 1.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..errors import EvaluationError
from ..motion.graph import MotionGraph
from ..progress import Progress, finish, portion
from .geodesic import Geodesics
from .goals import goal_in_cells
from .reach import time_to_reach_steps

#: Metres between two places below which single segments decide, not the way.
MIN_DISTANCE = 1.0


@dataclass(frozen=True)
class PathEfficiency:
    """Efficiency of the ways between n pairs of places.

    Attributes
    ----------
    starts, goals : (n, 2) int arrays of cells
    seconds : (n,) float array
        Of the quickest walk.
    metres : (n,) float array
        Of the geodesic.
    speed : float
        Metres per second at which the geodesic is taken to be walked.
    """

    starts: np.ndarray
    goals: np.ndarray
    seconds: np.ndarray
    metres: np.ndarray
    speed: float

    @property
    def efficiency(self) -> np.ndarray:
        """(n,) float"""
        return self.metres / self.speed / self.seconds

    @property
    def mean(self) -> float:
        return float(self.efficiency.mean())

    @property
    def worst(self) -> int:
        """Index of the pair with the least efficiency."""
        return int(np.argmin(self.efficiency))

    def describe(self) -> str:
        low, middle = np.percentile(self.efficiency, [10, 50])
        worst = self.worst
        return (
            f"Over {len(self.seconds)} pairs of places the quickest way is {100 * self.mean:.0f} % as efficient as the "
            f"shortest one at {self.speed:.2f} m/s (median {100 * middle:.0f} %, one in ten below {100 * low:.0f} %); "
            f"at worst {self.seconds[worst]:.1f} s for {self.metres[worst]:.1f} m."
        )


def mean_speed(graph: MotionGraph) -> float:
    """Metres per second over all segments of a motion graph, one after the other; EvaluationError if none travels."""
    length = sum(np.linalg.norm(np.diff(segment.path[:, :2], axis=0), axis=1).sum() for segment in graph.segments)
    if not length > 0:
        raise EvaluationError("No segment of the motion graph travels: there is no speed to compare with; add clips.")
    return float(length / sum(segment.duration for segment in graph.segments))


def path_efficiency(
    embedding: Embedding, rng: np.random.Generator, n_pairs: int = 100, n_goals: int = 20, speed: float | None = None
) -> PathEfficiency:
    """Efficiency over pairs of places drawn from the floor that the embedding covers, at least a metre apart.

    Parameters
    ----------
    n_pairs, n_goals : int
        Pairs, and how many different goals they share: each goal costs one field of exact times. About as many pairs
        end at each.
    speed : float, optional
        Metres per second; :func:`mean_speed` by default.

    Raises
    ------
    EvaluationError
        The embedding is empty, no two places are far enough apart, or nothing travels.
    """
    return finish(path_efficiency_steps(embedding, rng, n_pairs, n_goals, speed))


def path_efficiency_steps(
    embedding: Embedding, rng: np.random.Generator, n_pairs: int = 100, n_goals: int = 20, speed: float | None = None
) -> Generator[Progress, None, PathEfficiency]:
    """As :func:`path_efficiency`, as a generator that yields progress."""
    if n_pairs < 1 or n_goals < 1:
        raise EvaluationError(f"{n_pairs} pairs with {n_goals} goals cannot be compared; ask for one or more of each.")
    speed = mean_speed(embedding.graph) if speed is None else speed
    if not speed > 0:
        raise EvaluationError(f"The speed is {speed} m/s; it must be greater than zero.")
    free = embedding.environment.free_cells()
    places = np.argwhere(embedding.covered().any(axis=2) & free)
    yield Progress(0.0, "Measuring the ground")
    geodesics = Geodesics(embedding.environment)
    n_goals = min(n_goals, n_pairs)
    wanted = np.diff(np.linspace(0, n_pairs, n_goals + 1).astype(int)).tolist()
    starts, goals, seconds, metres = [], [], [], []
    # A goal without any place far enough away is passed over, and the next one drawn takes its turn.
    for goal in places[rng.permutation(len(places))]:
        if not wanted:
            break
        distance = geodesics.distances(goal)[0][tuple(places.T)]
        far = np.flatnonzero((distance >= MIN_DISTANCE) & np.isfinite(distance))
        if not len(far):
            continue
        chosen = rng.choice(far, wanted.pop(), replace=True)
        mask = np.zeros(free.shape, dtype=bool)
        mask[tuple(goal)] = True
        done = len(starts) / n_goals
        field = yield from portion(
            time_to_reach_steps(embedding, goal_in_cells(embedding, mask)), done, done + 1 / n_goals
        )
        starts.append(places[chosen])
        goals.append(np.broadcast_to(goal, (len(chosen), 2)))
        seconds.append(field.floor()[tuple(places[chosen].T)].astype(float))
        metres.append(distance[chosen])
    if not starts:
        raise EvaluationError(
            f"No two places of the floor that the embedding covers are {MIN_DISTANCE:g} m apart on a free way; give "
            "the character more room."
        )
    return PathEfficiency(
        starts=np.concatenate(starts),
        goals=np.concatenate(goals),
        seconds=np.concatenate(seconds),
        metres=np.concatenate(metres),
        speed=speed,
    )
