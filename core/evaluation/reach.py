"""Times to get from everywhere to a goal, and from a start to everywhere (paper, section 4.1.2)."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet, union_of
from ..errors import NOTHING_FITS, EvaluationError
from ..progress import Progress
from .wavefront import NEVER, wave_steps

#: Seconds for which the paper shows what lies within reach (Fig. 8).
PAPER_TIMES = (2.0, 3.0, 5.0, 7.0)

#: Shares of the places reached that the limits of :func:`round_times` hold.
_SHARES = (0.2, 0.5, 0.8, 0.95)

_ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)


@dataclass(frozen=True)
class ReachField:
    """Exact shortest times between every node of an embedding and a set of nodes.

    The time of a link is that of the segment it plays; places between the nodes of a walk do not count.

    Attributes
    ----------
    embedding : Embedding
    goal : NodeSet
        The set of nodes that times count to, or from; 0 there.
    forwards : bool
        False: times to the goal. True: times from it.
    limit : float
        Seconds after which the search ended; infinite if it went on to the end.
    frames : (n_groups, n_headings, nx, ny) uint16 array
        Frames of every place, 65535 where there is no way; it says nothing about whether a node stands there, and
        counts the goal's own nodes like all others. See :meth:`frames_at` for single nodes.
    group_of : tuple of int
        For each segment the group that holds its times. Backwards, segments with the same children share them.
    """

    embedding: Embedding
    goal: NodeSet
    forwards: bool
    limit: float
    frames: np.ndarray
    group_of: tuple[int, ...]

    @property
    def frame_rate(self) -> float:
        return self.embedding.graph.frame_rate

    def frames_at(self, nodes: Sequence[int] | np.ndarray) -> np.ndarray:
        """Frames of nodes: () uint16 for x, y, heading, segment; (n,) uint16 for (n, 4) rows of them.

        65535 where there is no way within the limit, or no node. On a tiled ground x and y may lie beyond it.
        """
        x, y, heading, segment = np.moveaxis(np.asarray(nodes), -1, 0)
        nx, ny, n_headings, _ = self.embedding.shape
        on_ground = np.asarray((x >= 0) & (x < nx) & (y >= 0) & (y < ny)) | self.embedding.environment.grid.tiled
        x, y = x % nx, y % ny
        plane, bit = segment * n_headings + heading, self.embedding.network.layout.bit(x, y)
        frames = self.frames[np.asarray(self.group_of)[segment], heading, x, y]
        frames = np.where(_bits(self._goal_rows, plane, bit), np.uint16(0), frames)
        return np.where(_bits(self._node_rows, plane, bit) & on_ground, frames, np.uint16(NEVER))

    def on_quickest_way(self, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """(n,) bool: True for links from (n, 4) nodes to (n, 4) nodes on a quickest way to the goal, or from it.

        Exactly: what the link takes is what the times differ by. Every node with a time other than 0 has such a link
        (out of it backwards, into it forwards), so that whoever follows them arrives after just that time.
        """
        starts, ends = np.asarray(starts), np.asarray(ends)
        taken = np.array([segment.n_frames - 1 for segment in self.embedding.graph.segments])[ends[:, 3]]
        near, away = (starts, ends) if self.forwards else (ends, starts)
        near, away = self.frames_at(near).astype(int), self.frames_at(away).astype(int)
        return (away != NEVER) & (away > 0) & (near + taken == away)

    def frames_of(self, segment: int) -> np.ndarray:
        """(nx, ny, n_headings) uint16: frames of the nodes of a segment; 65535 where there is no way, or no node."""
        n_headings, unpack = self.embedding.shape[2], self.embedding.network.layout.unpack
        frames = np.empty(self.embedding.shape[:3], dtype=np.uint16)
        for heading in range(n_headings):
            plane = segment * n_headings + heading
            nodes, goal = self.embedding.planes[plane], self.goal.planes[plane]
            here = np.where(unpack(nodes), self.frames[self.group_of[segment], heading], np.uint16(NEVER))
            here[unpack(goal)] = 0
            frames[:, :, heading] = here
        return frames

    def quickest(self) -> np.ndarray:
        """(nx, ny, n_headings) float32: seconds of the best segment to have come by; infinite where there is no way."""
        return self._in_seconds(self._quickest_frames.transpose(1, 2, 0))

    def floor(self) -> np.ndarray:
        """(nx, ny) float32: seconds in the best heading; infinite where there is no way."""
        return self._in_seconds(self._quickest_frames.min(axis=0))

    def area_within(self, time: float) -> float:
        """Square metres of the cells from which the goal is reached (or which are reached) within ``time`` seconds."""
        n_cells = np.count_nonzero(self._quickest_frames.min(axis=0) <= self._whole_frames(time))
        return float(n_cells * self.embedding.environment.grid.cell_size**2)

    def areas(self, times: Sequence[float] = PAPER_TIMES) -> list[float]:
        """Return the square metres within each of some times, by default those of the paper's Fig. 8."""
        return [self.area_within(time) for time in times]

    def histogram(self) -> np.ndarray:
        """(n,) int: how many nodes have a time of 0, 1, 2, ... frames; nodes out of reach are in no place."""
        counts = np.zeros(NEVER + 1, dtype=np.int64)
        for segment in range(self.embedding.shape[3]):
            counts += np.bincount(self.frames_of(segment).ravel(), minlength=NEVER + 1)
        reached = counts[:NEVER]
        return reached[: int(np.flatnonzero(reached).max(initial=-1)) + 1]

    def _whole_frames(self, time: float) -> int:
        """The last frame that is not later than ``time``; a time that was computed from frames is the same frame."""
        if not time >= 0:
            raise EvaluationError(f"A time of {time} s lies before the start; ask for zero seconds or more.")
        return int(min(np.floor(time * self.frame_rate + 1e-3), NEVER - 1))

    def _in_seconds(self, frames: np.ndarray) -> np.ndarray:
        seconds = (frames / np.float32(self.frame_rate)).astype(np.float32)
        seconds[frames == NEVER] = np.inf
        return seconds

    @cached_property
    def _quickest_frames(self) -> np.ndarray:
        """(n_headings, nx, ny) uint16: frames of the best segment."""
        network = self.embedding.network
        unpack, n_headings = network.layout.unpack, network.n_headings
        standing = [0] * (len(self.frames) * n_headings)
        at_goal = [0] * n_headings
        for plane, (nodes, goal) in enumerate(zip(self.embedding.planes, self.goal.planes, strict=True)):
            segment, heading = divmod(plane, n_headings)
            standing[self.group_of[segment] * n_headings + heading] |= nodes
            at_goal[heading] |= goal
        quickest = np.full(self.frames.shape[1:], NEVER, dtype=np.uint16)
        for index, nodes in enumerate(standing):
            if nodes:
                group, heading = divmod(index, n_headings)
                np.minimum(
                    quickest[heading],
                    np.where(unpack(nodes), self.frames[group, heading], np.uint16(NEVER)),
                    out=quickest[heading],
                )
        for heading, goal in enumerate(at_goal):
            if goal:
                quickest[heading][unpack(goal)] = 0
        return quickest

    @cached_property
    def _goal_rows(self) -> np.ndarray:
        return self.embedding.network.layout.to_rows(self.goal.planes)

    @cached_property
    def _node_rows(self) -> np.ndarray:
        return self.embedding.network.layout.to_rows(self.embedding.planes)


def _bits(rows: np.ndarray, row: np.ndarray, bit: np.ndarray) -> np.ndarray:
    return (rows[row, bit >> 3] >> (bit & 7) & 1).astype(bool)


def round_times(seconds: np.ndarray) -> tuple[float, ...]:
    """Choose up to four ascending round times, within which about 20, 50, 80 and 95 % of some times lie.

    ``seconds`` is an array of any shape, not finite where there is no time. (1.0,) if there is none at all.

    >>> round_times(np.array([0.4, 1.9, 2.2, 3.1, 9.7, np.inf]))
    (1.5, 2.0, 4.0, 8.0)
    """
    known = seconds[np.isfinite(seconds)]
    if not known.size:
        return (1.0,)
    return tuple(sorted({_rounded(float(limit)) for limit in np.quantile(known, _SHARES)}))


def _rounded(seconds: float) -> float:
    """The round number nearest to a time, by ratio; half a second at least."""
    if seconds <= 0.5:
        return 0.5
    magnitude = 10.0 ** np.floor(np.log10(seconds))
    nearest = min(_ROUND, key=lambda step: abs(np.log(step * magnitude / seconds)))
    # The digits that were meant, without what multiplying adds.
    return float(f"{nearest * magnitude:.2g}")


def time_to_reach_steps(
    embedding: Embedding, goal: NodeSet, limit: float | None = None
) -> Generator[Progress, None, ReachField]:
    """Find the exact shortest time from every node of the embedding to a set of its nodes.

    Parameters
    ----------
    goal : NodeSet
        A set of ``embedding.network``; what of it is not in the embedding does not count. See :mod:`.goals`.
    limit : float, optional
        Seconds after which the search ends; nodes that are farther count as out of reach.

    Raises
    ------
    EvaluationError
        No node of the goal is in the embedding, or the limit is negative.
    EmbeddingError
        The times would take more than ``embedding.settings.memory_limit`` bytes.
    """
    goal = _within(embedding, goal)
    frames = yield from exit_frames_steps(embedding, goal, _last_frame(embedding, limit))
    group_of = tuple(embedding.network.exit_group_of)
    return ReachField(embedding, goal, False, np.inf if limit is None else limit, frames, group_of)


def exit_frames_steps(
    embedding: Embedding,
    goal: NodeSet,
    last: int | None = None,
    delayed: tuple[np.ndarray, np.ndarray] | None = None,
) -> Generator[Progress, None, np.ndarray]:
    """Find the least frames of ways by at least one link to ``goal``, for each exit group.

    Ways may also end at one of the ``delayed`` nodes (n, 4), and from there take as many frames (n,) more. Returns
    (n_exit_groups, n_headings, nx, ny) uint16; 65535 where there is none within ``last``.
    """
    network = embedding.network
    of_entries = yield from wave_steps(embedding, False, goal, last, delayed)
    # A node's time is the least that its segment's children say, and those differ by entry group.
    nx, ny, n_headings, _ = embedding.shape
    frames = np.empty((len(network.entry_groups_after), n_headings, nx, ny), dtype=np.uint16)
    least = np.empty(of_entries.shape[1:], dtype=np.uint16)
    for out, entry_groups in zip(frames, network.entry_groups_after, strict=True):
        least.fill(NEVER)
        for entry_group in entry_groups:
            np.minimum(least, of_entries[entry_group], out=least)
        out[...] = _ground(least, embedding)
    return frames


def time_from_steps(
    embedding: Embedding, start: NodeSet, limit: float | None = None
) -> Generator[Progress, None, ReachField]:
    """Find the exact shortest time from a set of nodes to every node; as :func:`time_to_reach_steps` does it back."""
    network = embedding.network
    start = _within(embedding, start)
    last = _last_frame(embedding, limit)
    seed = [
        union_of(start.planes[parent * network.n_headings + heading] for parent in parents)
        for parents in network.parents
        for heading in range(network.n_headings)
    ]
    frames = yield from wave_steps(embedding, True, NodeSet(tuple(seed)), last)
    frames = np.ascontiguousarray(_ground(frames, embedding))
    limit = np.inf if limit is None else limit
    return ReachField(embedding, start, True, limit, frames, tuple(range(network.n_segments)))


def _within(embedding: Embedding, nodes: NodeSet) -> NodeSet:
    if embedding.n_nodes == 0:
        raise EvaluationError(f"The embedding is empty: {NOTHING_FITS}")
    nodes = nodes & embedding.nodes
    if not nodes:
        raise EvaluationError(
            "No walk of the embedding ever stands at the goal; choose a place that the character can get to."
        )
    return nodes


def _last_frame(embedding: Embedding, limit: float | None) -> int | None:
    if limit is None or limit == np.inf:
        return None
    if not limit >= 0:
        raise EvaluationError(f"The time limit is {limit} s; it must be zero or more.")
    return int(np.floor(limit * embedding.graph.frame_rate + 1e-3))


def _ground(table: np.ndarray, embedding: Embedding) -> np.ndarray:
    """(..., n_headings, nx, ny): the ground part of (..., n_headings, n_bits)."""
    layout = embedding.network.layout
    rows = table.reshape(*table.shape[:-1], -1, layout.stride)
    return rows[..., layout.halo_x : layout.halo_x + layout.nx, layout.halo_y : layout.halo_y + layout.ny]
