"""Motion that leads back to where it begins: without any, a motion graph cannot be walked in for ever.

A loop enters a clip at some frame, plays it for at least ``min_gap`` frames, leaves it for a frame that may be linked
with the one that it has come to, and so on, until it is back. One that enters a clip twice can always be shortened to
one that enters it once: thus a loop's segments never stand in each other's way, and a loop is a cycle in a
graph of frames, each of which may be arrived at or left.
"""

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from ..errors import MotionGraphError
from ..progress import Progress
from .frame_pairs import FramePairs, FrameSet

_WIDER = 3.0
"""How many times as dear the transitions are that are looked at next, as long as those so far close no loop."""


@dataclass(frozen=True)
class Loop:
    """The cheapest loop: the dearest of its transitions costs less than that of any other.

    Attributes
    ----------
    cost : float
        The cost of its dearest transition (rad^2).
    cuts : list of (0,) or (2,) int arrays
        For each clip the frames that the loop enters and leaves it at, counted from its first frame.
    """

    cost: float
    cuts: list[np.ndarray]


def cheapest_loop(pairs: FramePairs, frames: FrameSet) -> Loop | None:
    """Find the cheapest of the loops that ``pairs`` close, or None if they close none."""
    order = np.argsort(pairs.cost, kind="stable")
    first, second = pairs.first[order], pairs.second[order]
    needed = _fewest(len(order), lambda count: _has_cycle(_steps(first[:count], second[:count], frames)))
    if needed is None:
        return None
    # No loop does without the dearest pair.
    steps, dearest = _steps(first[:needed], second[:needed], frames), (first[needed - 1], second[needed - 1])
    visits = _way(steps, frames.n_frames, *dearest) or _way(steps, frames.n_frames, *dearest[::-1])
    cuts = [np.empty(0, dtype=int)] * len(frames.lengths)
    for entered, left in once_each(visits, frames.owner):
        clip = frames.owner[entered]
        cuts[clip] = np.array([entered, left]) - frames.offsets[clip]
    return Loop(float(pairs.cost[order[needed - 1]]), cuts)


def lowest_loop_cost_steps(
    frames: FrameSet, above: float, memory_limit: float
) -> Generator[Progress, None, float | None]:
    """Find the cost of the cheapest loop, where no transitions of cost ``above`` or less close one.

    Infinite if there is none at any cost, None if its pairs would take more than ``memory_limit`` bytes.
    """
    if not _has_cycle(_steps_at_any_cost(frames)):
        return math.inf
    max_cost, loop = above, None
    while loop is None:
        max_cost *= _WIDER
        try:
            pairs = yield from frames.pairs_steps(max_cost, memory_limit)
        except MotionGraphError:
            return None
        loop = cheapest_loop(pairs, frames)
    return loop.cost


def _steps(first: np.ndarray, second: np.ndarray, frames: FrameSet) -> csr_matrix:
    """(2 N, 2 N): who has arrived at frame f (row f) may, after the least gap, leave from there on (row N + f)."""
    source, target = _playing_on(frames)
    return _adjacency(
        np.concatenate([source, frames.n_frames + first, frames.n_frames + second]),
        np.concatenate([target, second, first]),
        2 * frames.n_frames,
    )


def _steps_at_any_cost(frames: FrameSet) -> csr_matrix:
    """The steps if all frames with the same feet planted have transitions, by way of four more rows.

    They also lead to frames of the same clip that are too near. These are always later ones than those that it was
    entered at, so that such a transition closes no loop and opens no way that there is not without it.
    """
    source, target = _playing_on(frames)
    every = np.arange(frames.n_frames)
    planted = 2 * frames.n_frames + frames.contacts @ [1, 2]
    return _adjacency(
        np.concatenate([source, frames.n_frames + every, planted]),
        np.concatenate([target, planted, every]),
        2 * frames.n_frames + 4,
    )


def _playing_on(frames: FrameSet) -> tuple[np.ndarray, np.ndarray]:
    """The steps within a clip: from arriving at a frame to leaving after the least gap, and from there to later."""
    every = np.arange(frames.n_frames)
    ends = (frames.offsets + frames.lengths)[frames.owner]
    long, more = every[every + frames.min_gap < ends], every[every + 1 < ends]
    return (
        np.concatenate([long, frames.n_frames + more]),
        np.concatenate([frames.n_frames + long + frames.min_gap, frames.n_frames + more + 1]),
    )


def _adjacency(source: np.ndarray, target: np.ndarray, size: int) -> csr_matrix:
    return csr_matrix((np.ones(len(source), dtype=np.int8), (source, target)), shape=(size, size))


def _has_cycle(steps: csr_matrix) -> bool:
    # No row leads to itself.
    return connected_components(steps, directed=True, connection="strong", return_labels=False) < len(steps.indptr) - 1


def _fewest(n_pairs: int, closes: Callable[[int], bool]) -> int | None:
    """The least number of pairs that closes a loop; None if all do not."""
    low, high = 0, min(1, n_pairs)
    while not closes(high):
        if high == n_pairs:
            return None
        low, high = high, min(4 * high, n_pairs)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if closes(middle) else (middle, high)
    return high


def _way(steps: csr_matrix, n_frames: int, left: int, entered: int) -> list[tuple[int, int]]:
    """Frames that clips are (entered, left) at on a way that begins at one and leaves another; empty if none leads."""
    _, before = breadth_first_order(steps, entered, return_predecessors=True)
    row, rows = n_frames + left, []
    while row >= 0:
        rows.append(int(row))
        row = before[row]
    if rows[-1] != entered:
        return []
    rows.reverse()
    arrived = [place for place, row in enumerate(rows) if row < n_frames]
    return [(rows[a], rows[b - 1] - n_frames) for a, b in zip(arrived, [*arrived[1:], len(rows)], strict=True)]


def once_each(visits: list[tuple[int, int]], owner: np.ndarray) -> list[tuple[int, int]]:
    """Shorten a loop until it enters no clip twice.

    >>> once_each([(0, 9), (20, 29), (5, 14)], owner=np.repeat([0, 1], [15, 15]))
    [(0, 14)]
    """
    while True:
        place: dict[int, int] = {}
        for now, (entered, left) in enumerate(visits):
            then = place.setdefault(int(owner[entered]), now)
            if then < now:
                entered_then, left_then = visits[then]
                if entered_then <= entered:
                    visits = [*visits[:then], (entered_then, left), *visits[now + 1 :]]
                else:
                    visits = [(entered, left_then), *visits[then + 1 : now]]
                break
        else:
            return visits
