"""Other ways to cut clips, to compare with: trying everything, and each clip greedily by itself."""

from collections.abc import Callable, Iterator
from itertools import combinations, pairwise, product

import numpy as np
from scipy.sparse import csr_matrix

from core.motion.cutting import CONTINUATION


def spaced(n_frames: int, min_gap: int) -> Iterator[tuple[int, ...]]:
    """All choices of cuts: none, or at least two, far enough apart."""
    yield ()
    for n_cuts in range(2, n_frames // min_gap + 2):
        for cuts in combinations(range(n_frames), n_cuts):
            if all(b - a >= min_gap for a, b in pairwise(cuts)):
                yield cuts


def exhaustive_best(
    goodness: csr_matrix, lengths: list[int], min_gap: int, score: Callable[[csr_matrix, list[int], list], float]
) -> float:
    """The highest score of any choice of cuts."""
    choices = product(*([np.array(cuts, dtype=int) for cuts in spaced(length, min_gap)] for length in lengths))
    return max(score(goodness, lengths, list(choice)) for choice in choices)


def greedy_cuts(goodness: csr_matrix, lengths, min_gap: int) -> list[np.ndarray]:
    """Cuts of each clip by itself: again and again the frame that goes best with all frames of all clips.

    At least ``min_gap`` frames apart, until no frame is left that goes with any.
    """
    worth = np.asarray(goodness.sum(axis=1)).ravel()
    chosen = []
    for of_clip in np.split(worth, np.cumsum(lengths)[:-1]):
        left = of_clip.copy()
        cuts = []
        while left.size and left.max() > 0:
            cuts.append(int(left.argmax()))
            left[max(cuts[-1] - min_gap + 1, 0) : cuts[-1] + min_gap] = 0
        chosen.append(np.array(sorted(cuts) if len(cuts) > 1 else [], dtype=int))
    return chosen


def total_goodness(goodness: csr_matrix, lengths: np.ndarray, cuts: list[np.ndarray]) -> float:
    """Sum the goodness of all links between the segments that the cuts make.

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
