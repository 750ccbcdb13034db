"""Choosing cuts of the clips so that the pieces link as often and as well as possible."""

from collections.abc import Generator, Iterator
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix

from ..progress import Progress, portion

CONTINUATION = 1.0
"""Goodness of playing on across a cut into the next segment of the same clip: a transition at no cost."""

OWN_SHARES = (0.0, 0.5, 1.0)
"""Pairs of cuts within one clip make its total quadratic. They are counted as if the other cut of each pair
were where it is now, wholly, by half or not at all, and whichever cuts turn out best are taken."""

MAX_ROUNDS = 100
"""Every round but the last improves the total, so that this only guards against endless rounding."""


def cut_steps(
    goodness: csr_matrix, lengths: np.ndarray, min_gap: int, n_starts: int, rng: np.random.Generator
) -> Generator[Progress, None, list[list[np.ndarray]]]:
    """Find locally best cuts of all clips, from ``n_starts`` different beginnings.

    Coordinate ascent on the goodness summed over all links between the segments that the cuts make: clip by clip,
    the cuts become the best there are while the other clips' cuts stay; rounds repeat until none improves.

    Parameters
    ----------
    goodness : (N, N) sparse array
        Goodness of the transition from one frame to another, clips one after the other; symmetric, no
        entries on the diagonal or between frames of one clip less than ``min_gap`` apart.
    lengths : (C,) int array
        Frames of each clip; their sum is N.
    min_gap : int
        Least number of frames from one cut to the next.

    Returns
    -------
    list of lists of (K,) int arrays
        Of every beginning, for each clip its cut frames, ascending, counted from its first frame; none or at
        least two.
    """
    ascent = Ascent(goodness, lengths, min_gap)
    solutions = []
    # The first beginning expects a cut anywhere with the same probability; the others are random.
    for start in range(n_starts):
        expected = np.full(ascent.n_frames, 1 / min_gap)
        if start > 0:
            expected *= 2 * rng.random(ascent.n_frames) * np.repeat(rng.random(len(lengths)) < 0.8, lengths)
        yield Progress(start / n_starts, "Choosing cuts")
        solutions.append((yield from portion(ascent.climb(expected), start / n_starts, (start + 1) / n_starts)))
    return solutions


def best_cuts(
    start_value: np.ndarray,
    end_value: np.ndarray,
    min_gap: int,
    may_open: np.ndarray | None = None,
    may_close: np.ndarray | None = None,
) -> np.ndarray:
    """Find the cuts of one clip that are worth most, exactly, by dynamic programming over its frames.

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

    Examples
    --------
    >>> best_cuts(np.array([3.0, 1, 0, 0, 0, 0]), np.array([0.0, 0, 0, 2, 0, 3]), min_gap=2)
    array([0, 3, 5])
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


class Ascent:
    """The goodness matrix taken apart by clip: what others contribute and what a clip does by itself."""

    def __init__(self, goodness: csr_matrix, lengths: np.ndarray, min_gap: int):
        self.min_gap = min_gap
        self.n_frames = int(np.sum(lengths))
        offsets = np.concatenate([[0], np.cumsum(lengths)])
        self.ranges = [slice(int(a), int(b)) for a, b in pairwise(offsets)]
        goodness = goodness.tocsr()
        self.rows = [goodness[clip] for clip in self.ranges]
        self.inside = [rows[:, clip] for rows, clip in zip(self.rows, self.ranges, strict=True)]

    def climb(self, expected: np.ndarray) -> Generator[Progress, None, list[np.ndarray]]:
        """Find cuts that no change of a single clip's cuts, found by dynamic programming, makes better.

        ``expected`` (N,) says with what weight each frame counts as a cut until its clip has been cut. Pauses
        after every clip.
        """
        starts, ends = expected.copy(), expected.copy()
        cuts = [np.empty(0, dtype=int)] * len(self.ranges)
        unchanged = 0
        for visit in range(MAX_ROUNDS * len(self.ranges)):
            clip = visit % len(self.ranges)
            frames = self.ranges[clip]
            better = self._recut(clip, cuts[clip], starts, ends)
            unchanged += 1
            if better is not None:
                cuts[clip] = better
            if better is not None or visit < len(self.ranges):
                starts[frames], ends[frames] = indicators(cuts[clip], frames.stop - frames.start)
                unchanged = 0
            if unchanged == len(self.ranges):
                break
            yield Progress(0.0, "Choosing cuts")
        return cuts

    def reconnecting(self, clip: int, current: np.ndarray, first: np.ndarray, last: np.ndarray) -> Iterator[np.ndarray]:
        """Yield cuts of the clip that are best linked with other clips' segments, each different from ``current``.

        ``first`` and ``last`` are the frames that those segments start and end at. The clip's first segment
        is entered from one of them, and its last one leads back to one.
        """
        starts, ends = np.zeros(self.n_frames), np.zeros(self.n_frames)
        starts[first] = 1
        ends[last] = 1
        start_value, end_value = self.rows[clip] @ ends, self.rows[clip] @ starts
        own_starts, own_ends = indicators(current, len(start_value))
        from_own = self.inside[clip] @ own_ends, self.inside[clip] @ own_starts
        seen = {current.tobytes()}
        for share in OWN_SHARES if self.inside[clip].nnz else OWN_SHARES[:1]:
            candidate = best_cuts(
                start_value + share * from_own[0],
                end_value + share * from_own[1],
                self.min_gap,
                may_open=start_value > 0,
                may_close=end_value > 0,
            )
            if candidate.tobytes() not in seen:
                seen.add(candidate.tobytes())
                yield candidate

    def _recut(self, clip: int, current: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray | None:
        """The clip's best cuts given everyone else's, or None if the current ones are as good."""
        frames, inside = self.ranges[clip], self.inside[clip]
        own_starts, own_ends = starts[frames], ends[frames]
        from_own = inside @ own_ends, inside @ own_starts
        start_value = self.rows[clip] @ ends - from_own[0]
        end_value = self.rows[clip] @ starts - from_own[1]
        best, best_worth = current, self._worth(clip, current, start_value, end_value)
        found = False
        for share in OWN_SHARES if inside.nnz else OWN_SHARES[:1]:
            candidate = best_cuts(start_value + share * from_own[0], end_value + share * from_own[1], self.min_gap)
            worth = self._worth(clip, candidate, start_value, end_value)
            if worth > best_worth + 1e-9 * max(1.0, abs(best_worth)):
                best, best_worth, found = candidate, worth, True
        return best if found else None

    def _worth(self, clip: int, cuts: np.ndarray, start_value: np.ndarray, end_value: np.ndarray) -> float:
        """Goodness of all links that touch the clip, given what its cuts are worth to the others."""
        if len(cuts) == 0:
            return 0.0
        starts, ends = indicators(cuts, len(start_value))
        own = ends @ (self.inside[clip] @ starts)
        return float(starts @ start_value + ends @ end_value + own) + CONTINUATION * (len(cuts) - 2)


def indicators(cuts: np.ndarray, n_frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Mark where segments start and where they end by 1, in two (n_frames,) float arrays."""
    starts, ends = np.zeros(n_frames), np.zeros(n_frames)
    starts[cuts[:-1]] = 1
    ends[cuts[1:]] = 1
    return starts, ends
