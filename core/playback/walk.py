"""Walks: sequences of links through an embedding."""

from collections.abc import Generator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.footprint import edited_path
from ..embedding.link_reader import LinkReader, Node
from ..errors import NOTHING_FITS, WalkError
from ..progress import Progress
from .weighted import Crossing, Memory, Weighting, probabilities, uniform

#: Links between two reports of progress.
REPORTED_LINKS = 100

_BYTES = 800
"""Memory that a joint takes in a frame of a walk: 300 while its motion is made, 500 as curves of an action."""

NOT_A_START = "The walk's start is no node of the embedding; choose a place inside the covered area."


@dataclass(frozen=True)
class WalkSettings:
    """A walk that chance decides: how long it lasts, where it starts and which links it prefers.

    Attributes
    ----------
    duration : float
        Seconds that it lasts at least; it ends with a whole segment.
    start : (x, y, heading, segment), optional
        Node to start from; by default a random one.
    weighting : Weighting
        How likely each link is taken (:mod:`.weighted`); by default all alike. Wandering does not heed it.

    Raises
    ------
    WalkError
        The duration is not positive.
    """

    duration: float
    start: Node | None = None
    weighting: Weighting = uniform

    def __post_init__(self):
        refuse_bad_duration(self.duration)


@dataclass(frozen=True)
class Walk:
    """A walk of n links.

    Attributes
    ----------
    embedding : Embedding
    states : (n + 1, 4) int array
        x, y, heading, segment of every node on the way. x and y are not wrapped: on a tiled ground they go on
        beyond the grid. The segment of row i + 1 is played from row i to row i + 1.
    stencils : (n,) int array
        The stencil of each link.
    """

    embedding: Embedding
    states: np.ndarray
    stencils: np.ndarray

    def __len__(self) -> int:
        return len(self.stencils)

    @property
    def segments(self) -> np.ndarray:
        """(n,) index of the segment played by each link."""
        return self.states[1:, 3]

    @cached_property
    def node_frames(self) -> np.ndarray:
        """(n + 1,) frame at which each node is passed; the first is 0, the last is the last frame."""
        lengths = [self.embedding.graph.segments[s].n_frames - 1 for s in self.segments]
        return np.concatenate([[0], np.cumsum(lengths, dtype=int)])

    @property
    def duration(self) -> float:
        """Seconds."""
        return float(self.node_frames[-1]) / self.embedding.graph.frame_rate

    @cached_property
    def root_path(self) -> np.ndarray:
        """(F, 3) world x, y (m) and unwrapped heading (rad) of every frame: the edited paths laid end to end."""
        grid, segments = self.embedding.environment.grid, self.embedding.graph.segments
        stencils = self.embedding.unrolling.stencils
        path = np.empty((self.node_frames[-1] + 1, 3))
        path[0] = *grid.positions(self.states[0, :2]), self.states[0, 2] * grid.heading_step
        for i, k in enumerate(self.stencils):
            edited = edited_path(
                segments[self.states[i + 1, 3]],
                int(self.states[i, 2]),
                grid,
                stencils.position_error[k],
                stencils.heading_error[k],
            )
            first, last = self.node_frames[i], self.node_frames[i + 1]
            edited[:, :2] += grid.positions(self.states[i, :2])
            edited[:, 2] += path[first, 2] - edited[0, 2]
            path[first : last + 1] = edited
        return path


class Trail:
    """A walk in the making."""

    def __init__(self, reader: LinkReader, start: Node):
        self.reader = reader
        self.states = [start]
        self.stencils: list[int] = []
        self.frames = 0

    @property
    def node(self) -> Node:
        """The node that the walker has come to."""
        return self.states[-1]

    def take(self, stencil: int) -> None:
        """Go on by a link."""
        self.states.append(self.reader.follow(self.node, stencil))
        self.stencils.append(stencil)
        self.frames += self.reader.embedding.graph.segments[self.node[3]].n_frames - 1

    def back(self) -> None:
        """Take the last link back."""
        self.frames -= self.reader.embedding.graph.segments[self.node[3]].n_frames - 1
        self.states.pop()
        self.stencils.pop()

    def walk(self) -> Walk:
        return Walk(self.reader.embedding, np.array(self.states), np.array(self.stencils, dtype=int))


def refuse_bad_duration(duration: float) -> None:
    """Raise WalkError unless the duration is a positive number."""
    if not (np.isfinite(duration) and duration > 0):
        raise WalkError(f"A walk of {duration} s cannot be played; give a positive duration.")


def refuse_too_long(embedding: Embedding, duration: float, n_walkers: int = 1) -> None:
    """Raise WalkError, before any is planned, if the motion of so long walks (s) takes more memory than allowed."""
    graph = embedding.graph
    joints = max((len(clip.skeleton.names) for clip in graph.clips), default=1)
    needed = n_walkers * duration * graph.frame_rate * joints * _BYTES
    limit = embedding.settings.memory_limit
    if needed > limit:
        walks = f"{wording.counted(n_walkers, 'walk')} of {wording.time(duration)}"
        fewer = ", or use fewer Walkers" if n_walkers > 1 else ""
        raise WalkError(
            f"{walks} would need about {wording.memory(needed)}, more than the limit of {wording.memory(limit)}; give "
            f"a shorter Duration{fewer}."
        )


def refuse_empty(embedding: Embedding) -> None:
    """Raise WalkError if nobody can walk."""
    if embedding.n_nodes == 0:
        raise WalkError(f"The embedding is empty: {NOTHING_FITS}")


def random_node(embedding: Embedding, rng: np.random.Generator) -> Node:
    """Choose a node (x, y, heading, segment), each with the same probability; WalkError if there is none."""
    refuse_empty(embedding)
    last = np.cumsum([plane.bit_count() for plane in embedding.planes])
    index = int(rng.integers(last[-1]))
    plane = int(np.searchsorted(last, index, side="right"))
    x, y = embedding.unrolling.layout.cells(embedding.planes[plane])[index - last[plane]].tolist()
    segment, heading = divmod(plane, embedding.unrolling.stencils.n_headings)
    return x, y, heading, segment


def nearest_node(embedding: Embedding, position, rng: np.random.Generator) -> Node:
    """Choose one of the nodes in the covered cell nearest to the world position (x, y) in metres, by chance."""
    refuse_empty(embedding)
    if not np.isfinite(position).all():
        raise WalkError("The place to start from is not a number; choose another one.")
    cells = np.argwhere(embedding.covered().any(axis=2))
    distance = np.linalg.norm(embedding.environment.grid.positions(cells) - np.asarray(position)[:2], axis=1)
    return node_in_cell(embedding, cells[np.argmin(distance)], rng)


def node_in_cell(embedding: Embedding, cell: np.ndarray, rng: np.random.Generator) -> Node:
    """Choose one of the nodes (x, y, heading, segment) in a covered cell, each with the same probability."""
    x, y = cell.tolist()
    bit = embedding.unrolling.layout.bit(x, y)
    here = [index for index, plane in enumerate(embedding.planes) if plane >> bit & 1]
    segment, heading = divmod(int(rng.choice(here)), embedding.unrolling.stencils.n_headings)
    return x, y, heading, segment


def begin(embedding: Embedding, rng: np.random.Generator, start: Node | None) -> tuple[LinkReader, Node]:
    """Return a reader of links, and the node to start from: a random one if ``start`` is None.

    WalkError if the embedding is empty or ``start`` no node of it.
    """
    reader = LinkReader(embedding)
    node = random_node(embedding, rng) if start is None else start
    if not reader.is_node(node):
        raise WalkError(NOT_A_START)
    return reader, node


def random_walk_steps(
    embedding: Embedding, rng: np.random.Generator, settings: WalkSettings
) -> Generator[Progress, None, Walk]:
    """Walk from link to link by chance.

    The walk never meets a dead end: every node of the embedding has a link to go on.

    Raises
    ------
    WalkError
        The embedding is empty, the start is no node of it, or the weighting does not fit.
    """
    reader, node = begin(embedding, rng, settings.start)
    trail, memory = Trail(reader, node), Memory(reader)
    wanted = settings.duration * embedding.graph.frame_rate - 1e-6
    while trail.frames < wanted:
        if len(trail.stencils) % REPORTED_LINKS == 0:
            yield Progress(trail.frames / wanted, "Walking")
        memory.pass_by(trail.node)
        trail.take(draw(rng, settings.weighting, memory.crossing(trail.node)))
    return trail.walk()


def draw(rng: np.random.Generator, weighting: Weighting, crossing: Crossing) -> int:
    """Draw one of the stencils that lead on, by their weights."""
    up_to = np.cumsum(probabilities(weighting, crossing))
    return int(crossing.stencils[min(np.searchsorted(up_to, rng.random(), side="right"), len(up_to) - 1)])
