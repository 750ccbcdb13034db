"""Path efficiency: how direct the ways are that the motion allows (Reitsma & Pollard 2007).

The article's path efficiency compares the length of the way that the character walks with that of the shortest one
that is free of collisions. Here it is the shortest length as a share of the walked one: 1 if the quickest walk from one
place to another goes straight there, 0.5 if it is twice as long as it need be; never more. The walk may start and end
in any heading.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.footprint import edited_path
from ..embedding.link_reader import LinkReader
from ..errors import EvaluationError
from ..progress import Progress, portion
from .geodesic import Geodesics
from .goals import goal_at
from .reach import NEVER, ReachField, time_to_reach_steps

#: Metres between two places below which single segments decide, not the way.
MIN_DISTANCE = 1.0

#: Pairs that are compared at most; the standard error of their mean is a thousandth by then.
MOST_PAIRS = 100_000


@dataclass(frozen=True)
class PathEfficiency:
    """Efficiency of the ways between n pairs of places.

    Attributes
    ----------
    starts, goals : (n, 2) int arrays of cells
    seconds, walked : (n,) float arrays
        Of the quickest walk, and the metres that it covers.
    metres : (n,) float array
        Of the shortest free way: of the geodesic, or of the walk, if that cuts a corner closer than straight lines
        between the centres of cells can.
    """

    starts: np.ndarray
    goals: np.ndarray
    seconds: np.ndarray
    walked: np.ndarray
    metres: np.ndarray

    @property
    def efficiency(self) -> np.ndarray:
        """(n,) float, above 0 and up to 1."""
        return self.metres / self.walked

    @property
    def mean(self) -> float:
        return float(self.efficiency.mean())

    @property
    def n_goals(self) -> int:
        """Different goals among the pairs."""
        return len(np.unique(self.goals, axis=0))

    @property
    def standard_error(self) -> float:
        """Standard error of the mean, as far as pairs with different goals are independent; nan for a single goal.

        Pairs that share a goal are alike, so that goals are what is drawn (the cluster-robust variance of a mean).
        """
        _, group = np.unique(self.goals, axis=0, return_inverse=True)
        off = np.bincount(group.ravel(), self.efficiency - self.mean)
        if len(off) < 2:
            return float("nan")
        return float(np.sqrt(np.square(off).sum() * len(off) / (len(off) - 1)) / len(self.goals))

    @property
    def mean_in_words(self) -> str:
        """The mean with its standard error, if that is known: "61.3% ± 1.2%"."""
        mean, error = wording.share(self.mean), self.standard_error
        return mean if np.isnan(error) else f"{mean} ± {wording.share(error)}"

    @property
    def sample(self) -> str:
        """The numbers of pairs and goals that were drawn, in words."""
        return f"{wording.counted(len(self.walked), 'pair')}, {wording.counted(self.n_goals, 'goal')}"

    @property
    def worst(self) -> int:
        """Index of the pair with the least efficiency."""
        return int(np.argmin(self.efficiency))

    def describe(self) -> str:
        low, middle = np.percentile(self.efficiency, [10, 50])
        worst = self.worst
        mean = f"{self.mean_in_words} ({self.sample})"
        return (
            f"The shortest free way is {mean} as long as the quickest walk (median {wording.share(middle)}, one in ten "
            f"below {wording.share(low)}); at worst the character walks {wording.length(self.walked[worst])} where "
            f"{wording.length(self.metres[worst])} would do."
        )


def path_efficiency_steps(
    embedding: Embedding, rng: np.random.Generator, n_pairs: int = 100, n_goals: int = 20
) -> Generator[Progress, None, PathEfficiency]:
    """Measure efficiency over pairs of places drawn from the floor that the embedding covers, at least a metre apart.

    Parameters
    ----------
    n_pairs, n_goals : int
        Pairs, and how many different goals they share: each goal costs one field of exact times. About as many pairs
        end at each.

    Raises
    ------
    EvaluationError
        The embedding is empty, there are to be no pairs or too many, or no two places are far enough apart.
    """
    if n_pairs < 1 or n_goals < 1:
        raise EvaluationError(f"{n_pairs} pairs with {n_goals} goals cannot be compared; ask for one or more of each.")
    if max(n_pairs, n_goals) > MOST_PAIRS:
        raise EvaluationError(
            f"{wording.counted(max(n_pairs, n_goals), 'pair')} of places would take days to compare; ask for "
            f"{wording.number(MOST_PAIRS)} or fewer, which tell as much."
        )
    places = np.argwhere(embedding.covered().any(axis=2))
    yield Progress(0.0, "Measuring the ground")
    geodesics, lengths = Geodesics(embedding.environment), WalkedLengths(embedding)
    n_goals = min(n_goals, n_pairs)
    wanted = np.diff(np.linspace(0, n_pairs, n_goals + 1).astype(int)).tolist()
    starts, goals, seconds, walked, metres = [], [], [], [], []
    # A goal without any place far enough away is passed over, and the next one drawn takes its turn.
    for goal in places[rng.permutation(len(places))]:
        if not wanted:
            break
        distance = geodesics.distances(goal)[0][tuple(places.T)]
        far = np.flatnonzero((distance >= MIN_DISTANCE) & np.isfinite(distance))
        if not len(far):
            continue
        chosen = rng.choice(far, wanted.pop(), replace=True)
        done, nodes = len(starts) / n_goals, goal_at(embedding, embedding.environment.grid.positions(goal))
        field = yield from portion(time_to_reach_steps(embedding, nodes), done, done + 1 / n_goals)
        starts.append(places[chosen])
        goals.append(np.broadcast_to(goal, (len(chosen), 2)))
        seconds.append(field.floor()[tuple(places[chosen].T)].astype(float))
        walked.append(lengths.from_cells(field, places[chosen]))
        metres.append(np.minimum(distance[chosen], walked[-1]))
    if not starts:
        raise EvaluationError(
            f"No two places of the floor that the embedding covers are {wording.exact(MIN_DISTANCE)} m apart on a free "
            "way; give the character more room."
        )
    return PathEfficiency(*(np.concatenate(parts) for parts in (starts, goals, seconds, walked, metres)))


class WalkedLengths:
    """Lengths of the quickest walks of an embedding, to the goals of any of its fields of times to reach."""

    def __init__(self, embedding: Embedding):
        self._embedding, self._reader = embedding, LinkReader(embedding)
        self._metres = np.full(len(embedding.unrolling.stencils), np.nan)

    def from_cells(self, field: ReachField, cells: np.ndarray) -> np.ndarray:
        """(n,) metres of a quickest walk from each of (n, 2) cells, in whatever heading is best; infinite if none.

        Of several links that are as quick the walk takes the shortest, and of these the first stencil: others that
        arrive as early may be a little longer or shorter.
        """
        nodes = np.array([self._quickest_node(field, cell) for cell in np.asarray(cells).tolist()], dtype=int)
        metres = np.zeros(len(nodes))
        left = field.frames_at(nodes)
        metres[left == NEVER] = np.inf
        on = np.flatnonzero((left > 0) & (left != NEVER))
        while len(on):
            rows, stencils = self._reader.links_from(nodes[on])
            ends = self._reader.wrapped(self._reader.ends(nodes[on][rows], stencils))
            quick = field.on_quickest_way(nodes[on][rows], ends)
            rows, stencils, ends = rows[quick], stencils[quick], ends[quick]
            lengths = self._lengths(stencils)
            order = np.lexsort((stencils, lengths, rows))
            # Every node with a time has a quickest link: as many are chosen as there are rows.
            chosen = order[np.flatnonzero(np.diff(rows[order], prepend=-1))]
            metres[on] += lengths[chosen]
            nodes[on] = ends[chosen]
            on = on[field.frames_at(nodes[on]) > 0]
        return metres

    def _quickest_node(self, field: ReachField, cell: list[int]) -> tuple[int, int, int, int]:
        """The node of a cell with the least time; the one of the lowest segment and heading if there are several."""
        _, _, n_headings, n_segments = self._embedding.shape
        segment, heading = np.divmod(np.arange(n_segments * n_headings), n_headings)
        here = np.column_stack([np.broadcast_to(cell, (len(segment), 2)), heading, segment])
        best = int(np.argmin(field.frames_at(here)))
        return cell[0], cell[1], int(heading[best]), int(segment[best])

    def _lengths(self, stencils: np.ndarray) -> np.ndarray:
        """(n,) metres of the edited paths of stencils, each measured once."""
        known, of = self._embedding.unrolling.stencils, self._embedding.graph.segments
        for k in np.unique(stencils[np.isnan(self._metres[stencils])]).tolist():
            path = edited_path(
                of[known.segment[k]],
                int(known.heading[k]),
                self._embedding.environment.grid,
                known.position_error[k],
                known.heading_error[k],
            )
            self._metres[k] = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum()
        return self._metres[stencils]
