"""Where to cut the clips so that the pieces connect as often and as well as possible."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix, identity

from .component import largest_component

CONTINUATION = 1.0
"""Goodness of playing on across a cut into the next segment of the same clip: a transition at no cost."""

_OWN_SHARES = (0.0, 0.5, 1.0)
"""Pairs of cuts within one clip make its total quadratic. They are counted as if the other cut of each pair
were where it is now, wholly, by half or not at all, and whichever cuts turn out best are taken."""

_MAX_ROUNDS = 100
"""Every round but the last improves the total, so that this only guards against endless rounding."""


def cut_solutions(
    goodness: csr_matrix, lengths: np.ndarray, min_gap: int, n_starts: int, rng: np.random.Generator
) -> Iterator[list[np.ndarray]]:
    """Locally best cuts of all clips, from ``n_starts`` different beginnings.

    Coordinate ascent on :func:`total_goodness`: clip by clip, the cuts become the best there are while the
    other clips' cuts stay; rounds repeat until none improves.

    Parameters
    ----------
    goodness : (N, N) sparse array
        Goodness of the transition from one frame to another, clips one after the other; symmetric, no
        entries on the diagonal or between frames of one clip less than ``min_gap`` apart.
    lengths : (C,) int array
        Frames of each clip; their sum is N.
    min_gap : int
        Least number of frames from one cut to the next.

    Yields
    ------
    list of (K,) int arrays
        For each clip its cut frames, ascending, counted from its first frame; none or at least two.
    """
    ascent = _Ascent(goodness, lengths, min_gap)
    # The first beginning expects a cut anywhere with the same probability; the others are random.
    for start in range(n_starts):
        expected = np.full(ascent.n_frames, 1 / min_gap)
        if start > 0:
            expected *= 2 * rng.random(ascent.n_frames) * np.repeat(rng.random(len(lengths)) < 0.8, lengths)
        yield ascent.climb(expected)


def total_goodness(goodness: csr_matrix, lengths: np.ndarray, cuts: list[np.ndarray]) -> float:
    """Goodness summed over all links between the segments that the cuts make.

    A segment ends at every cut but the clip's first and starts at every cut but the last; a link leads from
    every end to every start that ``goodness`` has an entry for, and across every cut in between to the next
    segment.
    """
    offsets = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    starts, ends = np.zeros(sum(lengths)), np.zeros(sum(lengths))
    for offset, frames in zip(offsets, cuts, strict=True):
        starts[offset + frames[:-1]] = 1
        ends[offset + frames[1:]] = 1
    return float(ends @ (goodness @ starts) + CONTINUATION * (ends @ starts))


def best_cuts(
    start_value: np.ndarray,
    end_value: np.ndarray,
    min_gap: int,
    may_open: np.ndarray | None = None,
    may_close: np.ndarray | None = None,
) -> np.ndarray:
    """The cuts of one clip that are worth most, exactly, by dynamic programming over its frames.

    Parameters
    ----------
    start_value, end_value : (F,) float array
        What it is worth that a segment starts (ends) at a frame. The first cut only starts a segment, the
        last one only ends one, those in between do both and are worth ``CONTINUATION`` besides.
    min_gap : int
        Least number of frames from one cut to the next.
    may_open, may_close : (F,) bool array, optional
        Which frames may be the first (last) cut; all if not given.

    Returns
    -------
    (K,) int array
        Ascending; empty if no pair of cuts is worth anything. The earliest of equally good ones.
    """
    n_frames = len(start_value)
    if n_frames <= min_gap:
        return np.empty(0, dtype=int)
    begin, end = start_value.tolist(), end_value.tolist()
    opening = begin if may_open is None else np.where(may_open, start_value, -np.inf).tolist()
    closing = end if may_close is None else np.where(may_close, end_value, -np.inf).tolist()
    # value[i]: the best worth of cuts up to i that has i start a segment; previous[i]: the cut before i.
    value, previous = [0.0] * n_frames, [-1] * n_frames
    best_before, before = -np.inf, -1  # the best of value[: i - min_gap + 1]
    best_total, last, last_before = 0.0, -1, -1
    for i in range(n_frames):
        value[i] = opening[i]
        j = i - min_gap
        if j >= 0:
            if value[j] > best_before:
                best_before, before = value[j], j
            through = best_before + end[i] + CONTINUATION + begin[i]
            if through > value[i]:
                value[i], previous[i] = through, before
            if best_before + closing[i] > best_total:
                best_total, last, last_before = best_before + closing[i], i, before
    if last < 0:
        return np.empty(0, dtype=int)
    cuts = [last]
    i = last_before
    while i >= 0:
        cuts.append(i)
        i = previous[i]
    return np.array(cuts[::-1])


def kept_goodness(goodness: csr_matrix, lengths: np.ndarray, cuts: list[np.ndarray]) -> float:
    """:func:`total_goodness` of the links within the largest strongly connected component only."""
    return _Kept(_with_continuation(goodness), lengths, cuts).total


def reconnected(
    goodness: csr_matrix, lengths: np.ndarray, min_gap: int, cuts: list[np.ndarray]
) -> Iterator[list[np.ndarray]]:
    """Cuts of which more is kept: coordinate ascent on :func:`kept_goodness`, beginning with ``cuts``.

    The cuts that are best in total waste some on segments that nothing leads to or back from. Here a clip's
    cuts count only for what links them to the component that the other clips make, and they must be entered
    from it and lead back to it; what is best then is adopted if the component, counted anew, gets better.
    Yields the cuts after each round, the last ones being the best.
    """
    cuts = list(cuts)
    closed = _with_continuation(goodness)
    ascent = _Ascent(goodness, lengths, min_gap)
    total = _Kept(closed, lengths, cuts).total
    for _ in range(_MAX_ROUNDS):
        changed = False
        for clip in range(len(lengths)):
            others = _Kept(closed, lengths, cuts, without=clip)
            for candidate in ascent.reconnecting(clip, cuts[clip], others):
                if np.array_equal(candidate, cuts[clip]):
                    continue
                attempt = [*cuts[:clip], candidate, *cuts[clip + 1 :]]
                attempted = _Kept(closed, lengths, attempt).total
                if attempted > total * (1 + 1e-9):
                    cuts, total, changed = attempt, attempted, True
        yield cuts
        if not changed:
            break


def _with_continuation(goodness: csr_matrix) -> csr_matrix:
    n_frames = len(goodness.indptr) - 1
    return (goodness + CONTINUATION * identity(n_frames, format="csr")).tocsr()


class _Kept:
    """What is kept of the segments that cuts make: first and last frames, and their links' total goodness."""

    def __init__(self, closed: csr_matrix, lengths: np.ndarray, cuts: list[np.ndarray], without: int = -1):
        offsets = np.concatenate([[0], np.cumsum(lengths)[:-1]])
        chosen = [offset + cut for offset, cut in zip(offsets, cuts, strict=True)]
        if without >= 0:
            del chosen[without]
        first = np.concatenate([np.empty(0, dtype=int), *(cut[:-1] for cut in chosen)])
        last = np.concatenate([np.empty(0, dtype=int), *(cut[1:] for cut in chosen)])
        leaving: csr_matrix = closed[last]
        between = leaving[:, first].tocoo()
        links = np.column_stack([between.row, between.col])
        kept = largest_component(len(first), links)
        self.first, self.last = first[kept], last[kept]
        self.total = float(between.data[kept[links].all(axis=1)].sum())


class _Ascent:
    """The goodness matrix taken apart by clip: what others contribute and what a clip does by itself."""

    def __init__(self, goodness: csr_matrix, lengths: np.ndarray, min_gap: int):
        self.min_gap = min_gap
        self.n_frames = int(np.sum(lengths))
        offsets = np.concatenate([[0], np.cumsum(lengths)])
        self.ranges = [slice(int(a), int(b)) for a, b in pairwise(offsets)]
        goodness = goodness.tocsr()
        self.rows = [goodness[clip] for clip in self.ranges]
        self.inside = [rows[:, clip] for rows, clip in zip(self.rows, self.ranges, strict=True)]

    def climb(self, expected: np.ndarray) -> list[np.ndarray]:
        """Cuts that no change of a single clip's cuts, found by dynamic programming, makes better.

        ``expected`` (N,) says with what weight each frame counts as a cut until its clip has been cut.
        """
        starts, ends = expected.copy(), expected.copy()
        cuts = [np.empty(0, dtype=int)] * len(self.ranges)
        for n_round in range(_MAX_ROUNDS):
            changed = False
            for clip, frames in enumerate(self.ranges):
                better = self._recut(clip, cuts[clip], starts, ends)
                if better is not None:
                    changed = True
                    cuts[clip] = better
                if better is not None or n_round == 0:
                    starts[frames], ends[frames] = _indicators(cuts[clip], frames.stop - frames.start)
            if not changed:
                break
        return cuts

    def reconnecting(self, clip: int, current: np.ndarray, others: _Kept) -> Iterator[np.ndarray]:
        """Cuts of the clip that are best linked with what is kept of the ``others``."""
        starts, ends = np.zeros(self.n_frames), np.zeros(self.n_frames)
        starts[others.first] = 1
        ends[others.last] = 1
        start_value, end_value = self.rows[clip] @ ends, self.rows[clip] @ starts
        own_starts, own_ends = _indicators(current, len(start_value))
        from_own = self.inside[clip] @ own_ends, self.inside[clip] @ own_starts
        for share in _OWN_SHARES if self.inside[clip].nnz else _OWN_SHARES[:1]:
            yield best_cuts(
                start_value + share * from_own[0],
                end_value + share * from_own[1],
                self.min_gap,
                may_open=start_value > 0,
                may_close=end_value > 0,
            )

    def _recut(self, clip: int, current: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray | None:
        """The clip's best cuts given everyone else's, or None if the current ones are as good."""
        frames, inside = self.ranges[clip], self.inside[clip]
        own_starts, own_ends = starts[frames], ends[frames]
        from_own = inside @ own_ends, inside @ own_starts
        start_value = self.rows[clip] @ ends - from_own[0]
        end_value = self.rows[clip] @ starts - from_own[1]
        best, best_worth = current, self._worth(clip, current, start_value, end_value)
        found = False
        for share in _OWN_SHARES if inside.nnz else _OWN_SHARES[:1]:
            candidate = best_cuts(start_value + share * from_own[0], end_value + share * from_own[1], self.min_gap)
            worth = self._worth(clip, candidate, start_value, end_value)
            if worth > best_worth + 1e-9 * max(1.0, abs(best_worth)):
                best, best_worth, found = candidate, worth, True
        return best if found else None

    def _worth(self, clip: int, cuts: np.ndarray, start_value: np.ndarray, end_value: np.ndarray) -> float:
        """Goodness of all links that touch the clip, given what its cuts are worth to the others."""
        if len(cuts) == 0:
            return 0.0
        starts, ends = _indicators(cuts, len(start_value))
        own = ends @ (self.inside[clip] @ starts)
        return float(starts @ start_value + ends @ end_value + own) + CONTINUATION * (len(cuts) - 2)


def _indicators(cuts: np.ndarray, n_frames: int) -> tuple[np.ndarray, np.ndarray]:
    """1 where a segment starts, 1 where one ends, as two (n_frames,) float arrays."""
    starts, ends = np.zeros(n_frames), np.zeros(n_frames)
    starts[cuts[:-1]] = 1
    ends[cuts[1:]] = 1
    return starts, ends
