"""Segments and links that a choice of cuts makes, as arrays of frame numbers.

Frames of all clips are numbered through, clip after clip.
"""

from dataclasses import dataclass

import numpy as np

from .component import largest_component


@dataclass(frozen=True)
class Transitions:
    """Pairs of frames that motion may pass between.

    Attributes
    ----------
    end, start : (T,) int array
        A segment that ends at frame end[t] may be followed by one that starts at frame start[t].
    cost : (T,) float array
        Transition cost D (rad^2).
    """

    end: np.ndarray
    start: np.ndarray
    cost: np.ndarray


def with_continuations(first: np.ndarray, second: np.ndarray, cost: np.ndarray, n_frames: int) -> Transitions:
    """Return the transitions both ways between pairs of frames, and from every frame to itself at no cost."""
    every = np.arange(n_frames)
    return Transitions(
        np.concatenate([first, second, every]),
        np.concatenate([second, first, every]),
        np.concatenate([cost, cost, np.zeros(n_frames)]),
    )


@dataclass(frozen=True)
class Segmentation:
    """Segments between neighbouring cuts of a clip, with their links.

    Attributes
    ----------
    first, last : (S,) int array
        First and last frame of each segment, both played; ascending.
    links : (L, 2) int array
        Sorted, no duplicates.
    costs : (L,) float array
        Transition cost of each link.
    kept : (S,) bool array
        The largest strongly connected component.
    """

    first: np.ndarray
    last: np.ndarray
    links: np.ndarray
    costs: np.ndarray
    kept: np.ndarray

    @property
    def inner(self) -> np.ndarray:
        """(L,) bool: the links between kept segments."""
        return self.kept[self.links[:, 0]] & self.kept[self.links[:, 1]]

    def limited(self, threshold: float) -> "Segmentation":
        """Return the segments with the links that cost ``threshold`` or less, and the component that they make."""
        cheap = self.costs <= threshold
        if cheap.all():
            return self
        links = self.links[cheap]
        kept = largest_component(len(self.first), links)
        return Segmentation(self.first, self.last, links, self.costs[cheap], kept)


def segmentation(cuts: list[np.ndarray], lengths: np.ndarray, transitions: Transitions) -> Segmentation:
    """Return the segments that ``cuts`` (of each clip, counted from its first frame) make, and their links.

    >>> back = with_continuations(np.array([0]), np.array([5]), np.array([0.1]), n_frames=6)
    >>> made = segmentation([np.array([0, 3, 5])], np.array([6]), back)
    >>> made.links.tolist(), made.kept
    ([[0, 1], [1, 0]], array([ True,  True]))
    """
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    first = np.concatenate([offset + frames[:-1] for offset, frames in zip(offsets, cuts, strict=False)])
    last = np.concatenate([offset + frames[1:] for offset, frames in zip(offsets, cuts, strict=False)])
    # At most one segment ends at a frame, and at most one starts there.
    ending, starting = np.full(offsets[-1], -1), np.full(offsets[-1], -1)
    ending[last] = starting[first] = np.arange(len(first))
    links = np.column_stack([ending[transitions.end], starting[transitions.start]])
    real = (links >= 0).all(axis=1)
    links, costs = links[real], transitions.cost[real]
    order = np.lexsort((links[:, 1], links[:, 0]))
    links = links[order]
    return Segmentation(first, last, links, costs[order], largest_component(len(first), links))
