"""Directed walks through some goals: the quickest way, exactly, or a smoother one."""

import math
from collections.abc import Generator, Sequence

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node
from ..embedding.node_set import NodeSet
from ..errors import WalkError
from ..evaluation.wavefront import NEVER
from ..progress import Progress, portion
from .cheapest import cheapest_way_steps
from .prices import LinkPrices, PriceSettings, link_edits
from .time_to_go import TimeToGo, rows_of, time_to_go_steps
from .walk import NOT_A_START, Trail, Walk, refuse_empty

#: Weight of a second for the smoothest ways: nobody walks about for nothing.
LEAST_TIME = 0.05


def walk_through_steps(
    embedding: Embedding,
    start: Node | NodeSet,
    goals: Sequence[NodeSet],
    limit: float | None = None,
    smoothness: float = 0.0,
) -> Generator[Progress, None, Walk]:
    """Find a walk that stands at a node of each goal, one goal after the other: the quickest one, or a smoother one.

    The least time, or price, of the whole, not of each leg: where and how a goal is passed depends on all that follow.
    One node may pass several goals that follow one another.

    Parameters
    ----------
    start : node (x, y, heading, segment), or NodeSet to start from the best of
    goals : sequence of NodeSet
        Sets of ``embedding.network``; what of them is not in the embedding does not count.
    limit : float, optional
        Seconds that the walk may last at most.
    smoothness : float
        0 to 1: see :func:`trail_steps`.

    Raises
    ------
    WalkError
        The start or a goal has no node in the embedding, no walk is quick enough, or the start passes all goals.
    EmbeddingError
        The times would take more memory than the embedding's settings allow.
    """
    refuse_empty(embedding)
    reader = LinkReader(embedding)
    starts = start_nodes(reader, start)
    time_to_go = yield from portion(time_to_go_steps(embedding, goals, last_frame(embedding, limit)), 0.0, 0.8)
    trail = yield from portion(trail_steps(reader, time_to_go, starts, limit, smoothness), 0.8, 1.0)
    if not trail.stencils:
        raise WalkError("The character stands at the goal already; choose another goal, or another start.")
    return trail.walk()


def trail_steps(
    reader: LinkReader, time_to_go: TimeToGo, starts: np.ndarray, limit: float | None, smoothness: float
) -> Generator[Progress, None, Trail]:
    """Find the way from the best of (n, 4) ``starts``: the quickest one, or a smoother one.

    ``smoothness`` s, 0 to 1, trades time for what an onlooker notices: a second of walking weighs 1 - s, all other
    prices of links (:mod:`.prices`) s. At 0 it is the quickest way (:func:`quickest_trail_steps`); never does it take
    more than 1 + s times as long.
    """
    if not 0 <= smoothness <= 1:
        raise WalkError(f"A Smoothness of {smoothness} is no weight; give a number between 0 and 1.")
    embedding = time_to_go.embedding
    frames = time_to_go.frames_at(0, starts)
    least, last = int(frames.min()), last_frame(embedding, limit)
    if smoothness == 0 or least == 0 or least >= NEVER or (last is not None and least > last):
        return (yield from quickest_trail_steps(reader, time_to_go, starts, limit))
    longest = min(int(least * (1 + smoothness)), NEVER - 1 if last is None else last)
    prices = LinkPrices(embedding, PriceSettings().times(smoothness / max(1 - smoothness, LEAST_TIME)))
    guide, starts = TimeGuide(time_to_go, prices), starts[frames <= longest]
    stage = guide.passed(np.zeros(len(starts), dtype=np.int64), starts)
    starts, stage = starts[stage < guide.n_goals], stage[stage < guide.n_goals]
    row, way, _ = yield from cheapest_way_steps(reader, prices, guide, starts, longest, stage)
    trail = Trail(reader, tuple(starts[row].tolist()))
    for stencil in way:
        trail.take(stencil)
    return trail


class TimeGuide:
    """The least frames from everywhere through some goals."""

    def __init__(self, time_to_go: TimeToGo, prices: LinkPrices):
        graph = time_to_go.embedding.graph
        self.spends = np.array([segment.n_frames - 1 for segment in graph.segments])
        self.unit_price = round(prices.usual)
        self.n_goals = time_to_go.n_goals
        self._time_to_go = time_to_go

    def passed(self, stage: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        # Whatever can follow before a goal is passed, can follow after it, too.
        stage = stage.copy()
        for goal in range(self.n_goals):
            here = np.flatnonzero(stage == goal)
            stage[here[self._time_to_go.passes(goal, nodes[here])]] += 1
        return stage

    def left(self, stage: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        left = np.zeros(len(nodes), dtype=np.int64)
        for goal in np.unique(stage).tolist():
            left[stage == goal] = self._time_to_go.frames_at(goal, nodes[stage == goal])
        return left


def start_nodes(reader: LinkReader, start: Node | NodeSet) -> np.ndarray:
    """Return (n, 4) nodes of the embedding to start from; WalkError if there are none."""
    if isinstance(start, tuple):
        nodes = np.array([start])
        nodes = nodes[reader.are_nodes(nodes)]
    else:
        nodes = rows_of(reader.embedding, start)
    if not len(nodes):
        raise WalkError(NOT_A_START)
    return nodes


def last_frame(embedding: Embedding, limit: float | None) -> int | None:
    """Return the last frame within ``limit`` seconds; None for no limit."""
    if limit is None or limit == np.inf:
        return None
    if not limit > 0:
        raise WalkError(f"A walk cannot last {limit} s at most; give a positive time.")
    return int(np.floor(limit * embedding.graph.frame_rate + 1e-3))


def quickest_trail_steps(
    reader: LinkReader, time_to_go: TimeToGo, starts: np.ndarray, limit: float | None = None
) -> Generator[Progress, None, Trail]:
    """Find the quickest walk from the (n, 4) ``starts``, exactly, and of all such the one with the least root edit.

    The edit is :func:`.prices.link_edits`, summed; WalkError if the walk takes longer than ``limit`` seconds.

    Waves of nodes go out from the starts, along all links that are on a quickest way; then the least edit is summed
    up from the last wave back to the first.
    """
    embedding = time_to_go.embedding
    durations = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
    destination = embedding.unrolling.stencils.segment
    edits = link_edits(embedding)

    frames = time_to_go.frames_at(0, starts)
    least, last = int(frames.min()), last_frame(embedding, limit)
    if limit is not None and last is not None and least > last:
        # Rounded up: less than that is too little.
        seconds = math.ceil(100 * least / embedding.graph.frame_rate) / 100
        takes = "" if least >= NEVER else f"; the quickest takes {wording.exact(seconds)} s"
        raise WalkError(f"No walk gets there within {wording.exact(limit)} s{takes}. Allow more time.")
    starts, frames = starts[frames == least], frames[frames == least]
    buckets = _Buckets(embedding, time_to_go.n_goals)
    layer, wrapped = np.zeros(len(starts), dtype=int), reader.wrapped(starts)
    first_keys = buckets.add(time_to_go.advanced(layer, wrapped, frames), wrapped, frames)
    waves = []
    while buckets.frames_left:
        yield Progress(0.9 * (1 - buckets.frames_left / max(least, 1)), "Laying out the quickest ways")
        # No link is shorter than a window, so that none joins two nodes of one wave.
        keys, layer, nodes, frames = buckets.take(durations.min())
        rows, stencils = reader.links_from(nodes)
        ends = reader.wrapped(reader.ends(nodes[rows], stencils))
        left = frames[rows] - durations[destination[stencils]]
        quickest = np.zeros(len(rows), dtype=bool)
        for goal in range(time_to_go.n_goals):
            here = np.flatnonzero((layer[rows] == goal) & (left >= 0))
            quickest[here] = time_to_go.frames_at(goal, ends[here]) == left[here]
        rows, stencils, ends, left = rows[quickest], stencils[quickest], ends[quickest], left[quickest]
        end_keys = buckets.add(time_to_go.advanced(layer[rows], ends, left), ends, left)
        waves.append((keys, rows, stencils, end_keys))

    cost = np.zeros(buckets.n_keys)
    best = np.full((buckets.n_keys, 2), -1)
    for keys, rows, stencils, end_keys in reversed(waves):
        total = edits[stencils] + cost[end_keys]
        order = np.lexsort((stencils, total, rows))
        chosen = order[np.flatnonzero(np.diff(rows[order], prepend=-1))]
        cost[keys] = total[chosen]
        best[keys] = np.column_stack([stencils[chosen], end_keys[chosen]])
    start = int(np.argmin(cost[first_keys]))
    trail, key = Trail(reader, tuple(starts[start].tolist())), int(first_keys[start])
    while best[key, 0] >= 0:
        stencil, key = best[key].tolist()
        trail.take(stencil)
    return trail


class _Buckets:
    """Nodes of the layers by the frames that they have left, and a running number for every one ever added.

    Each waits once, in the manner of Dial's buckets.
    """

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
        """Return numbers of nodes; those that are new wait, except at the last goal."""
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
        """Return numbers, layers, nodes and frames to go of the nodes within ``window`` frames of the farthest."""
        farthest = self.frames_left
        taken = [left for left in self._waiting if left > farthest - window]
        rows = [(number, code, left) for left in taken for number, code in self._waiting.pop(left)]
        number, code, left = np.array(rows).T
        layer, *node = np.unravel_index(code, self._shape)
        return number, layer, np.column_stack(node), left
