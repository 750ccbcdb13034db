"""Walks: sequences of links through an embedding."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.footprint import edited_path
from ..errors import WalkError

#: x, y, heading, segment; x and y go on beyond a tiled ground.
Node = tuple[int, int, int, int]


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
    def seams(self) -> np.ndarray:
        """(n + 1,) frame at which each node is passed; the first is 0, the last is the last frame."""
        lengths = [self.embedding.graph.segments[s].n_frames - 1 for s in self.segments]
        return np.concatenate([[0], np.cumsum(lengths, dtype=int)])

    @property
    def duration(self) -> float:
        """Seconds."""
        return float(self.seams[-1]) / self.embedding.graph.frame_rate

    @cached_property
    def root_path(self) -> np.ndarray:
        """(F, 3) world x, y (m) and unwrapped heading (rad) of every frame: the edited paths laid end to end."""
        grid, segments = self.embedding.environment.grid, self.embedding.graph.segments
        stencils = self.embedding.unrolling.stencils
        path = np.empty((self.seams[-1] + 1, 3))
        path[0] = *grid.positions(self.states[0, :2]), self.states[0, 2] * grid.heading_step
        for i, k in enumerate(self.stencils):
            edited = edited_path(
                segments[self.states[i + 1, 3]],
                int(self.states[i, 2]),
                grid,
                stencils.position_error[k],
                stencils.heading_error[k],
            )
            first, last = self.seams[i], self.seams[i + 1]
            edited[:, :2] += grid.positions(self.states[i, :2])
            edited[:, 2] += path[first, 2] - edited[0, 2]
            path[first : last + 1] = edited
        return path


class LinkReader:
    """Reads single links out of an embedding's planes: which stencils may be played at a node."""

    def __init__(self, embedding: Embedding):
        self.embedding = embedding
        self._layout = embedding.unrolling.layout
        stencils = embedding.unrolling.stencils
        n_headings = stencils.n_headings
        first = np.searchsorted(
            stencils.segment * n_headings + stencils.heading, np.arange(len(embedding.planes) + 1)
        ).tolist()
        self._of_start = [range(a, b) for a, b in pairwise(first)]
        self._step = list(
            zip(
                stencils.dx.tolist(),
                stencils.dy.tolist(),
                stencils.destination_heading.tolist(),
                stencils.segment.tolist(),
                strict=True,
            )
        )
        self._bytes: dict[tuple[bool, int], bytes] = {}

    def is_node(self, node: Node) -> bool:
        """Whether (x, y, heading, segment) is a node of the embedding; x and y may be unwrapped on a tiled ground."""
        nx, ny, n_headings, n_segments = self.embedding.shape
        x, y, heading, segment = node
        if self.embedding.environment.grid.tiled:
            x, y = x % nx, y % ny
        inside = 0 <= x < nx and 0 <= y < ny and 0 <= heading < n_headings and 0 <= segment < n_segments
        return inside and self._is_set(False, segment * n_headings + heading, self._layout.bit(x, y))

    def stencils_from(self, state: Node) -> list[int]:
        """Stencils of all links from the node (x, y, heading, segment); x and y may be unwrapped."""
        nx, ny, n_headings, _ = self.embedding.shape
        x, y, heading, segment = state
        bit = self._layout.bit(x % nx, y % ny)
        found = []
        for child in self.embedding.network.children[segment]:
            for k in self._of_start[child * n_headings + heading]:
                if self._is_set(True, k, bit):
                    dx, dy, turned, _ = self._step[k]
                    if self._is_set(False, child * n_headings + turned, self._layout.bit((x + dx) % nx, (y + dy) % ny)):
                        found.append(k)
        return found

    def follow(self, state: Node, stencil: int) -> Node:
        """The node at the other end of a link; x and y go on beyond a tiled ground."""
        dx, dy, heading, segment = self._step[stencil]
        return state[0] + dx, state[1] + dy, heading, segment

    def _is_set(self, validity: bool, plane: int, bit: int) -> bool:
        # A single bit of a Python integer costs a shift of all of it; of bytes, nothing.
        raw = self._bytes.get((validity, plane))
        if raw is None:
            source = self.embedding.unrolling.valid if validity else self.embedding.planes
            raw = source[plane].to_bytes((self._layout.n_bits + 7) // 8, "little")
            self._bytes[validity, plane] = raw
        return bool(raw[bit >> 3] >> (bit & 7) & 1)


def _refuse_empty(embedding: Embedding) -> None:
    if embedding.n_nodes == 0:
        raise WalkError(
            "The embedding is empty: no endless walk fits into this scene. Use more or shorter clips, a smaller "
            "radius or a wider footprint, or remove obstacles."
        )


def random_node(embedding: Embedding, rng: np.random.Generator) -> Node:
    """A node (x, y, heading, segment), each with the same probability; WalkError if the embedding is empty."""
    _refuse_empty(embedding)
    last = np.cumsum([plane.bit_count() for plane in embedding.planes])
    index = int(rng.integers(last[-1]))
    plane = int(np.searchsorted(last, index, side="right"))
    x, y = embedding.unrolling.layout.cells(embedding.planes[plane])[index - last[plane]].tolist()
    segment, heading = divmod(plane, embedding.unrolling.stencils.n_headings)
    return x, y, heading, segment


def nearest_node(embedding: Embedding, position, rng: np.random.Generator) -> Node:
    """One of the nodes (x, y, heading, segment) in the covered cell nearest to the world position (x, y) in metres."""
    _refuse_empty(embedding)
    if not np.isfinite(position).all():
        raise WalkError("The place to start from is not a number; choose another one.")
    cells = np.argwhere(embedding.covered().any(axis=2))
    distance = np.linalg.norm(embedding.environment.grid.positions(cells) - np.asarray(position)[:2], axis=1)
    x, y = cells[np.argmin(distance)].tolist()
    bit = embedding.unrolling.layout.bit(x, y)
    here = [index for index, plane in enumerate(embedding.planes) if plane >> bit & 1]
    segment, heading = divmod(int(rng.choice(here)), embedding.unrolling.stencils.n_headings)
    return x, y, heading, segment


def begin(
    embedding: Embedding, rng: np.random.Generator, duration: float, start: Node | None
) -> tuple[LinkReader, Node]:
    """What every walk starts with: a reader of links, and the node to start from (a random one if ``start`` is None).

    WalkError if the duration is not positive, the embedding empty or ``start`` no node of it.
    """
    if not (np.isfinite(duration) and duration > 0):
        raise WalkError(f"A walk of {duration} s cannot be played; give a positive duration.")
    reader = LinkReader(embedding)
    state = random_node(embedding, rng) if start is None else start
    if not reader.is_node(state):
        raise WalkError("The walk's start is no node of the embedding; choose a place inside the covered area.")
    return reader, state


def random_walk(
    embedding: Embedding,
    rng: np.random.Generator,
    duration: float,
    start: Node | None = None,
) -> Walk:
    """A random walk of at least ``duration`` seconds that takes each outgoing link with the same probability.

    It never meets a dead end: every node of the embedding has a link to go on.

    Parameters
    ----------
    start : (x, y, heading, segment), optional
        Node to start from; a random one by default.

    Raises
    ------
    WalkError
        The embedding is empty, ``start`` is no node of it, or the duration is not positive.
    """
    reader, state = begin(embedding, rng, duration, start)
    segments, frame_rate = embedding.graph.segments, embedding.graph.frame_rate
    states, stencils, frames = [state], [], 0
    while frames < duration * frame_rate - 1e-6:
        choices = reader.stencils_from(state)
        stencil = choices[int(rng.integers(len(choices)))]
        state = reader.follow(state, stencil)
        frames += segments[state[3]].n_frames - 1
        states.append(state)
        stencils.append(stencil)
    return Walk(embedding, np.array(states), np.array(stencils))
