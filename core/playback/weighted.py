"""Weightings: how likely a random walker takes each of the links before it.

A weighting is any function of a :class:`Crossing` that returns one weight for each link, zero or more. Where all are
zero the links are taken alike: a walker has to go on.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..embedding.link_reader import LinkReader, Node
from ..errors import WalkError

#: Metres across the squares in which a walker remembers how often it came by.
VISIT_SQUARE = 0.5


@dataclass(frozen=True)
class Crossing:
    """A node with the links that lead on, as a walker sees it.

    Attributes
    ----------
    reader : LinkReader
    node : (x, y, heading, segment)
    stencils : (L,) int array
        The links that lead on.
    ends : (L, 4) int array
        The nodes that they lead to; x and y go on beyond a tiled ground.
    visits : (L,) int array
        Times that the walker has passed the squares in which the links end.
    """

    reader: LinkReader
    node: Node
    stencils: np.ndarray
    ends: np.ndarray
    visits: np.ndarray


Weighting = Callable[[Crossing], np.ndarray]


def uniform(crossing: Crossing) -> np.ndarray:
    """Every link alike."""
    return np.ones(len(crossing.stencils))


@dataclass(frozen=True)
class ByGoodness:
    """Links with smooth transitions: goodness exp(-D / width) of the transition's cost D.

    Attributes
    ----------
    width : float, optional
        Cost (rad^2) at which the weight has fallen to 37 %; a fifth of the dearest link of the graph by default.
    """

    width: float | None = None

    def __post_init__(self):
        if self.width is not None and not (np.isfinite(self.width) and self.width > 0):
            raise WalkError(f"A width of {self.width} rad^2 weighs nothing; give a positive cost.")

    def __call__(self, crossing: Crossing) -> np.ndarray:
        graph = crossing.reader.embedding.graph
        width = self.width or max(float(graph.link_costs.max()) / 5, 1e-9)
        # Links are sorted, so that those from one segment follow one another.
        start, stop = np.searchsorted(graph.links[:, 0], [crossing.node[3], crossing.node[3] + 1])
        which = start + np.searchsorted(graph.links[start:stop, 1], crossing.ends[:, 3])
        return np.exp(-graph.link_costs[which] / width)


def by_variability(crossing: Crossing) -> np.ndarray:
    """Links towards nodes with many ways in and out: the destination's segment variability (paper, eq. 1)."""
    return crossing.reader.variability(crossing.ends).astype(float)


@dataclass(frozen=True)
class Evenly:
    """Links towards places where the walker has seldom been: (1 + visits) ** -power.

    Looks one link ahead; to be sent across the whole floor, wander (:mod:`.wandering`).
    """

    power: float = 4.0

    def __call__(self, crossing: Crossing) -> np.ndarray:
        return (1.0 + crossing.visits) ** -self.power


@dataclass(frozen=True)
class PerClip:
    """Links by the weights that an artist gives to clips, to see more of them, or less.

    Attributes
    ----------
    weights : mapping of clip name to weight
        Clips that are not named weigh 1. The weight of a clip is shared by all its links at hand, so that a clip that
        fits in more ways is not played more often. 0: only where nothing else can be played.
    """

    weights: Mapping[str, float]

    def __post_init__(self):
        for name, weight in self.weights.items():
            if not (np.isfinite(weight) and weight >= 0):
                raise WalkError(f"The weight of the clip '{name}' is {weight}; it must be zero or more.")

    def __call__(self, crossing: Crossing) -> np.ndarray:
        graph = crossing.reader.embedding.graph
        unknown = set(self.weights) - {clip.name for clip in graph.clips}
        if unknown:
            raise WalkError(f"The motion graph has no clip '{min(unknown)}' to weigh; choose one of its clips.")
        clip = np.array([graph.segments[s].clip for s in crossing.ends[:, 3]])
        weight = np.array([self.weights.get(graph.clips[c].name, 1.0) for c in clip])
        return weight / np.bincount(clip)[clip]


class Memory:
    """The squares that a walker has passed, and the crossings that it sees."""

    def __init__(self, reader: LinkReader):
        grid = reader.embedding.environment.grid
        self._reader = reader
        self._square = max(round(VISIT_SQUARE / grid.cell_size), 1)
        self._visits = np.zeros([-(-n // self._square) for n in grid.shape[:2]], dtype=int)

    def crossing(self, node: Node) -> Crossing:
        """Find all links from ``node``."""
        stencils = self._reader.stencils_from(node)
        ends = self._reader.ends(np.array(node), stencils)
        x, y = (self._reader.wrapped(ends)[:, :2] // self._square).T
        return Crossing(self._reader, node, stencils, ends, self._visits[x, y])

    def pass_by(self, node: Node) -> None:
        """Remember that the walker has come to ``node``."""
        self._visits[self._place(node)] += 1

    def forget(self, node: Node) -> None:
        """Take back one :meth:`pass_by`."""
        self._visits[self._place(node)] -= 1

    def _place(self, node: Node) -> tuple[int, int]:
        nx, ny = self._reader.embedding.shape[:2]
        return node[0] % nx // self._square, node[1] % ny // self._square


def probabilities(weighting: Weighting, crossing: Crossing) -> np.ndarray:
    """Return (L,) the probability of each link.

    WalkError if the weights are negative, not finite or not one for each link.
    """
    weights = np.asarray(weighting(crossing), dtype=float)
    if weights.shape != crossing.stencils.shape or not np.isfinite(weights).all() or np.any(weights < 0):
        raise WalkError("The weights of the links must be numbers of zero or more, one for each link.")
    total = weights.sum()
    return weights / total if total > 0 else np.full(len(weights), 1 / len(weights))
