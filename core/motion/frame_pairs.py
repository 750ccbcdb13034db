"""The frames of all clips side by side, and the pairs of them that may be linked."""

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from .. import wording
from ..errors import MotionGraphError
from ..progress import Progress
from .distance import PoseFeatures, close_pairs_steps, expected_pairs

PAIR_BYTES = 200
"""What a pair takes at the most while cuts are chosen: measured, 130 to 190."""


@dataclass(frozen=True)
class FramePairs:
    """Pairs of frames i < j that may both be cuts and be linked.

    Attributes
    ----------
    first, second : (P,) int array
        Frames i and j; the frames of all clips are numbered through, clip after clip.
    cost : (P,) float array
        Transition cost D (rad^2).
    """

    first: np.ndarray
    second: np.ndarray
    cost: np.ndarray

    def up_to(self, threshold: float) -> "FramePairs":
        """Return the pairs that cost ``threshold`` or less."""
        chosen = self.cost <= threshold
        return self if chosen.all() else FramePairs(self.first[chosen], self.second[chosen], self.cost[chosen])

    def goodness(self, n_frames: int, width: float) -> csr_matrix:
        """Return the (N, N) sparse array with exp(-D / width) at both places of every pair."""
        # However narrow the width is, a possible link stays worth more than none.
        quality = np.maximum(np.exp(-self.cost / width), 1e-6)
        places = np.concatenate([self.first, self.second]), np.concatenate([self.second, self.first])
        return csr_matrix((np.tile(quality, 2), places), shape=(n_frames, n_frames))


@dataclass(frozen=True)
class FrameSet:
    """The frames of all clips, one clip after the other, as they are compared.

    Attributes
    ----------
    features : PoseFeatures
    contacts : (N, 2) bool array
        Left and right foot planted.
    lengths : (C,) int array
        Frames of each clip; their sum is N.
    min_gap : int
        Least number of frames from one cut of a clip to the next.
    names : (C,) sequence of str
        Of the clips, for people.
    """

    features: PoseFeatures
    contacts: np.ndarray
    lengths: np.ndarray
    min_gap: int
    names: Sequence[str] = ()

    @property
    def n_frames(self) -> int:
        return len(self.contacts)

    @cached_property
    def owner(self) -> np.ndarray:
        """(N,) int: the clip of each frame."""
        return np.repeat(np.arange(len(self.lengths)), self.lengths)

    @cached_property
    def offsets(self) -> np.ndarray:
        """(C,) int: the first frame of each clip."""
        return np.cumsum(self.lengths) - self.lengths

    def pairs_steps(self, max_cost: float, memory_limit: float = math.inf) -> Generator[Progress, None, FramePairs]:
        """Find all pairs that may be linked at a cost of ``max_cost`` or less.

        Raises MotionGraphError, before any are sought, if they would take more than ``memory_limit`` bytes.
        """
        planted = self.contacts @ [1, 2]
        n_pairs = self.n_frames**2 / 2
        if n_pairs * PAIR_BYTES > memory_limit:
            yield Progress(0.0, "Comparing frames")
            n_pairs = expected_pairs(self.features, max_cost, planted)
        if n_pairs * PAIR_BYTES > memory_limit:
            needed = wording.memory(n_pairs * PAIR_BYTES)
            raise MotionGraphError(
                f"About {wording.amount(n_pairs / 1e6)} million pairs of frames of these {len(self.lengths)} clips "
                f"cost {wording.exact(max_cost)} or less. To cut the clips by them would need about {needed}, more "
                f"than the limit of {wording.memory(memory_limit)}; lower Max Cost or Frame Rate, or use fewer clips"
                f"{longest_of(self.names, self.lengths.tolist())}."
            )
        first, second, costs = yield from close_pairs_steps(self.features, max_cost, planted)
        allowed = self._apart(first, second)
        return FramePairs(first[allowed], second[allowed], costs[allowed])

    def _apart(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return (self.owner[first] != self.owner[second]) | (np.abs(second - first) >= self.min_gap)


def longest_of(names: Sequence[str], lengths: Sequence[int]) -> str:
    """Name the longest clip: " (the longest is 'walk', of 9,000 frames)", or "" where clips have no names."""
    if len(names) == 0:
        return ""
    longest = int(np.argmax(lengths))
    return f" (the longest is '{names[longest]}', of {wording.number(lengths[longest])} frames)"
