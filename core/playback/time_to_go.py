"""Courses: the least time from everywhere through some goals, in their order; and the walk that keeps to it."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, PlaneBits
from ..embedding.network import Nodes
from ..progress import Progress
from .walk import Trail

#: In uint16 frames: never.
NEVER = 65535

#: Metres by which an edit of the heading by one radian counts, beside an edit of the place.
HEADING_LEVER = 0.5


class TimeToGo:
    """Goals to pass in order. Layer i means: goals 0 to i - 1 are passed, goal i is next.

    Parameters
    ----------
    goals : sequence of Nodes
    tables : sequence of (n_merges, n_headings, nx, ny) uint16 arrays
        For each goal, the least frames of the ways by at least one link that pass this goal and all later ones.
    """

    def __init__(self, embedding: Embedding, goals: Sequence[Nodes], tables: Sequence[np.ndarray]):
        network = embedding.network
        self.embedding = embedding
        self.n_goals = len(goals)
        self._tables = tables
        self._goals = [
            PlaneBits([plane for bundle in goal for plane in network.planes(bundle)], network.plane_bytes)
            for goal in goals
        ]
        self._merge_of = np.array(network.merge_of)

    def passes(self, goal: int, nodes: np.ndarray) -> np.ndarray:
        """(n,) bool: which of (n, 4) nodes are in a goal; places may be unwrapped."""
        nx, ny, n_headings, _ = self.embedding.shape
        bit = self.embedding.unrolling.layout.bit(nodes[:, 0] % nx, nodes[:, 1] % ny)
        return self._goals[goal].at(nodes[:, 3] * n_headings + nodes[:, 2], bit)

    def frames_at(self, layer: int, nodes: np.ndarray) -> np.ndarray:
        """(n,) int: least frames from (n, 4) nodes through all goals from ``layer`` on; NEVER if there is no way."""
        if layer == self.n_goals:
            return np.zeros(len(nodes), dtype=int)
        nx, ny = self.embedding.shape[:2]
        x, y, heading, segment = nodes.T
        frames = self._tables[layer][self._merge_of[segment], heading, x % nx, y % ny].astype(int)
        here = np.flatnonzero(self.passes(layer, nodes))
        if len(here):
            frames[here] = np.minimum(frames[here], self.frames_at(layer + 1, nodes[here]))
        return frames

    def advanced(self, layer: np.ndarray, nodes: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(n,) layers of nodes in ``layer``, with their least ``frames``, after passing the goals that they are in.

        A goal is passed as soon as that costs no time: whatever can follow then could follow before, too.
        """
        layer = layer.copy()
        for goal in range(self.n_goals):
            here = np.flatnonzero(layer == goal)
            here = here[self.passes(goal, nodes[here])]
            layer[here[self.frames_at(goal + 1, nodes[here]) == frames[here]]] += 1
        return layer


def link_edits(embedding: Embedding) -> np.ndarray:
    """(K,) metres by which each stencil edits its segment's end: place and heading together."""
    stencils = embedding.unrolling.stencils
    return np.hypot(np.hypot(*stencils.position_error.T), HEADING_LEVER * stencils.heading_error)


@dataclass
class _Wave:
    """Nodes with nearly the same time to go, and the quickest links that lead on from them."""

    keys: np.ndarray
    rows: np.ndarray
    stencils: np.ndarray
    end_keys: np.ndarray


def quickest_trail_steps(
    reader: LinkReader, time_to_go: TimeToGo, starts: np.ndarray
) -> Generator[Progress, None, Trail]:
    """Find the quickest walk from the (n, 4) ``starts``, exactly, and of all such the one with the least root edit.

    It is :func:`link_edits`, summed. The walk begins at the quickest of the starts.

    Waves of nodes go out from the starts, along all links that are on a quickest way; then the least edit is summed
    up from the last wave back to the first.
    """
    embedding = time_to_go.embedding
    durations = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
    destination = embedding.unrolling.stencils.segment
    edits = link_edits(embedding)

    frames = time_to_go.frames_at(0, starts)
    least = int(frames.min())
    starts, frames = starts[frames == least], frames[frames == least]
    pool = _Pool(embedding, time_to_go.n_goals)
    layer, wrapped = np.zeros(len(starts), dtype=int), reader.wrapped(starts)
    first_keys = pool.add(time_to_go.advanced(layer, wrapped, frames), wrapped, frames)
    waves: list[_Wave] = []
    while pool.frames_left:
        yield Progress(0.9 * (1 - pool.frames_left / max(least, 1)), "Laying out the quickest ways")
        # No link is shorter than a window, so that none joins two nodes of one wave.
        keys, layer, nodes, frames = pool.take(durations.min())
        rows, stencils = reader.links_from(nodes)
        ends = reader.wrapped(reader.ends(nodes[rows], stencils))
        left = frames[rows] - durations[destination[stencils]]
        quickest = np.zeros(len(rows), dtype=bool)
        for goal in range(time_to_go.n_goals):
            here = np.flatnonzero((layer[rows] == goal) & (left >= 0))
            quickest[here] = time_to_go.frames_at(goal, ends[here]) == left[here]
        rows, stencils, ends, left = rows[quickest], stencils[quickest], ends[quickest], left[quickest]
        end_keys = pool.add(time_to_go.advanced(layer[rows], ends, left), ends, left)
        waves.append(_Wave(keys, rows, stencils, end_keys))

    cost = np.zeros(pool.n_keys)
    best = np.full((pool.n_keys, 2), -1)
    for wave in reversed(waves):
        total = edits[wave.stencils] + cost[wave.end_keys]
        order = np.lexsort((wave.stencils, total, wave.rows))
        chosen = order[np.flatnonzero(np.diff(wave.rows[order], prepend=-1))]
        cost[wave.keys] = total[chosen]
        best[wave.keys] = np.column_stack([wave.stencils[chosen], wave.end_keys[chosen]])
    start = int(np.argmin(cost[first_keys]))
    trail, key = Trail(reader, tuple(starts[start].tolist())), int(first_keys[start])
    while best[key, 0] >= 0:
        stencil, key = best[key].tolist()
        trail.take(stencil)
    return trail


class _Pool:
    """Nodes of the layers that wait for their wave, each once, and a running number for every one ever added."""

    def __init__(self, embedding: Embedding, n_goals: int):
        self._shape = (n_goals + 1, *embedding.shape)
        self._number: dict[int, int] = {}
        self._waiting: dict[int, list[tuple[int, int]]] = {}

    @property
    def n_keys(self) -> int:
        return len(self._number)

    @property
    def frames_left(self) -> int:
        """Frames to go from the farthest node that waits; 0 if all have arrived."""
        return max(self._waiting, default=0)

    def add(self, layer: np.ndarray, nodes: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Numbers of nodes; those that are new wait, except at the end of the time_to_go."""
        codes = np.ravel_multi_index((layer, *nodes.T), self._shape)
        distinct, first, inverse = np.unique(codes, return_index=True, return_inverse=True)
        numbers = []
        for code, left in zip(distinct.tolist(), frames[first].tolist(), strict=True):
            number = self._number.get(code)
            if number is None:
                number = self._number[code] = len(self._number)
                if left:
                    self._waiting.setdefault(left, []).append((number, code))
            numbers.append(number)
        return np.array(numbers, dtype=int)[inverse.ravel()]

    def take(self, window: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Numbers, layers, nodes and frames to go of the nodes within ``window`` frames of the farthest."""
        farthest = self.frames_left
        taken = [left for left in self._waiting if left > farthest - window]
        rows = [(number, code, left) for left in taken for number, code in self._waiting.pop(left)]
        number, code, left = np.array(rows).T
        layer, *node = np.unravel_index(code, self._shape)
        return number, layer, np.column_stack(node), left
