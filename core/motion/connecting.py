"""Cuts of which as much as possible belongs to one strongly connected component."""

from collections.abc import Generator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from ..progress import Progress
from .component import largest_component
from .cutting import CONTINUATION, MAX_ROUNDS, Ascent


def kept_goodness(goodness: csr_matrix, lengths: np.ndarray, cuts: list[np.ndarray]) -> float:
    """Sum the goodness of the links within the largest strongly connected component."""
    return _NOTHING.joined_by(_FrameLinks(goodness, lengths), dict(enumerate(cuts))).kept_goodness


def reconnect_steps(
    goodness: csr_matrix, lengths: np.ndarray, min_gap: int, cuts: list[np.ndarray]
) -> Generator[Progress, None, tuple[list[np.ndarray], float]]:
    """Find cuts of which more is kept: coordinate ascent on :func:`kept_goodness`, beginning with ``cuts``.

    The cuts that are best in total waste some on segments that nothing leads to or back from. Here a clip's
    cuts count only for what links them to the component that the other clips make, and they must be entered
    from it and lead back to it; what is best then is adopted if the component, counted anew, gets better.
    Returns the cuts and their kept goodness, never less than that of ``cuts``; ``goodness`` as for
    :func:`.cutting.cut_steps`.
    """
    cuts = list(cuts)
    links = _FrameLinks(goodness, lengths)
    ascent = Ascent(goodness, lengths, min_gap)
    state = _NOTHING.joined_by(links, dict(enumerate(cuts)))
    n_clips, unchanged = len(lengths), 0
    for visit in range(MAX_ROUNDS * n_clips):
        yield Progress(1 - 0.6 ** (visit / n_clips), "Connecting segments")
        clip = visit % n_clips
        others = state.without(clip)
        kept = others.kept
        unchanged += 1
        for candidate in ascent.reconnecting(clip, cuts[clip], others.first[kept], others.last[kept]):
            attempt = others.joined_by(links, {clip: candidate})
            if attempt.kept_goodness > state.kept_goodness * (1 + 1e-9):
                cuts[clip], state, unchanged = candidate, attempt, 0
        if unchanged == n_clips:
            break
    return cuts, state.kept_goodness


class _FrameLinks:
    """The links between frames, by row."""

    def __init__(self, goodness: csr_matrix, lengths: np.ndarray):
        self.indptr, self.indices, self.data = goodness.indptr, goodness.indices, goodness.data
        self.offsets = np.concatenate([[0], np.cumsum(lengths)])

    def of(self, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return all entries of some rows: (index into ``frames``, the frame linked to, goodness), (L,) each."""
        begin = self.indptr[frames]
        counts = self.indptr[frames + 1] - begin
        which = np.repeat(np.arange(len(frames)), counts)
        places = np.arange(len(which)) + (begin - np.cumsum(counts) + counts)[which]
        return which, self.indices[places], self.data[places]


@dataclass(frozen=True)
class _CutClips:
    """Segments that cuts make, and all links between them, clip after clip in the order in which they joined.

    ``first``, ``last``, ``clip`` are (S,) frame numbers and owners; link l leads from segment ``source[l]`` to
    segment ``target[l]`` and is worth ``value[l]``.
    """

    first: np.ndarray
    last: np.ndarray
    clip: np.ndarray
    source: np.ndarray
    target: np.ndarray
    value: np.ndarray

    @cached_property
    def kept(self) -> np.ndarray:
        """(S,) bool: the largest strongly connected component."""
        return largest_component(len(self.first), np.column_stack([self.source, self.target]))

    @cached_property
    def kept_goodness(self) -> float:
        """Goodness of the links within the component."""
        return float(self.value[self.kept[self.source] & self.kept[self.target]].sum())

    def without(self, clip: int) -> "_CutClips":
        """Return the rest without a clip's segments and their links."""
        stay = self.clip != clip
        if stay.all():
            return self
        number = np.cumsum(stay) - 1
        inner = stay[self.source] & stay[self.target]
        return _CutClips(
            self.first[stay],
            self.last[stay],
            self.clip[stay],
            number[self.source[inner]],
            number[self.target[inner]],
            self.value[inner],
        )

    def joined_by(self, links: _FrameLinks, cuts: Mapping[int, np.ndarray]) -> "_CutClips":
        """Return these and the segments that ``cuts`` make of some clips that have none yet."""
        frames = [links.offsets[clip] + own for clip, own in cuts.items()]
        first = np.concatenate([_NONE, *(own[:-1] for own in frames)])
        if len(first) == 0:
            return self
        last = np.concatenate([own[1:] for own in frames])
        owner = np.repeat(list(cuts), [max(len(own) - 1, 0) for own in frames])
        n_before = len(self.first)
        number = n_before + np.arange(len(first))
        # At most one segment starts at a frame, and at most one ends there.
        starting, ending = np.full((2, links.offsets[-1]), -1)
        starting[self.first] = ending[self.last] = np.arange(n_before)
        # Goodness is symmetric: the row of a segment's first frame holds from where it can be entered.
        entered, enter_from, enter_value = links.of(first)
        enter_from = ending[enter_from]
        entry = enter_from >= 0
        starting[first] = number
        left, leave_to, leave_value = links.of(last)
        leave_to = starting[leave_to]
        leaving = leave_to >= 0
        onward = number[:-1][last[:-1] == first[1:]]
        return _CutClips(
            np.concatenate([self.first, first]),
            np.concatenate([self.last, last]),
            np.concatenate([self.clip, owner]),
            np.concatenate([self.source, enter_from[entry], number[left[leaving]], onward]),
            np.concatenate([self.target, number[entered[entry]], leave_to[leaving], onward + 1]),
            np.concatenate([self.value, enter_value[entry], leave_value[leaving], np.full(len(onward), CONTINUATION)]),
        )


_NONE = np.empty(0, dtype=int)
_NOTHING = _CutClips(_NONE, _NONE, _NONE, _NONE, _NONE, np.empty(0))
