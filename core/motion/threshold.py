"""The cost up to which frames are linked: given, or found so that the graph gets the size that is asked for.

How large the graph of a threshold is does not simply rise with the threshold, because at every threshold the
clips are cut anew and not always equally well. Thus nothing here is concluded from one threshold about another:
the search only decides what to try, what is promised is counted on the graph that is returned, and that is the
best one of all that were tried.
"""

from collections.abc import Callable, Generator

import numpy as np
from scipy.sparse import csr_matrix

from .. import wording
from ..errors import MotionGraphError
from ..progress import Progress, portion
from .connecting import kept_goodness, reconnect_steps
from .cutting import Ascent, cut_steps, indicators
from .frame_pairs import FramePairs, FrameSet
from .graph_settings import MotionGraphSettings, ThresholdMode
from .loops import Loop, cheapest_loop
from .segmentation import Segmentation, segmentation, with_continuations

_N_REFINED = 3
"""Of the cuts found from different starts, how many are refined."""

_MAX_PROBES = 8
"""How many thresholds are tried; the interval is halved each time at worst, mostly the end comes sooner."""

_CLOSE_ENOUGH = 0.01
"""The search ends when the interval is this part of its upper end."""

Outcome = tuple[float, Segmentation]
"""A threshold and the segments linked at it."""


def segmentation_steps(
    pairs: FramePairs, frames: FrameSet, settings: MotionGraphSettings, n_given: float
) -> Generator[Progress, None, Outcome]:
    """Cut the clips, at the threshold that ``settings.threshold_mode`` asks for.

    ``pairs`` are all pairs of frames up to ``settings.max_cost``; ``n_given`` is the number of frames of the
    motion that coverage is a share of. Returns the threshold (rad^2) and the segments with the links up to it;
    nothing is kept of them if nothing connects at ``settings.max_cost``. MotionGraphError if things connect, but
    no graph that was tried is as asked for.
    """
    if settings.threshold_mode is ThresholdMode.COST:
        cuts = yield from choose_cuts_steps(pairs, frames, settings, settings.max_cost)
        return settings.max_cost, _linked(cuts, frames, pairs)
    if settings.threshold_mode is ThresholdMode.LINKS:
        goal = _AtMostLinks(settings.max_links)
    else:
        goal = _AtLeastCoverage(settings.min_coverage, n_given)
    tried: list[Outcome] = []
    candidates = np.unique(pairs.cost)
    low, high, threshold = 0.0, settings.max_cost, settings.max_cost
    for probe in range(_MAX_PROBES):
        steps = choose_cuts_steps(pairs, frames, settings, threshold)
        cuts = yield from portion(steps, probe / _MAX_PROBES, (probe + 1) / _MAX_PROBES)
        widest = _linked(cuts, frames, pairs)
        if not widest.kept.any():
            if probe == 0:
                return settings.max_cost, widest
        else:
            tried.append(goal.best_of(widest))
        at_threshold = widest.limited(threshold)
        if goal.is_above(at_threshold):
            high = threshold
        elif threshold == settings.max_cost:
            # All that is allowed is not too much; or not enough, and then less of it could do only by luck.
            break
        else:
            low = threshold
        between = candidates[(candidates > low) & (candidates < high)]
        if len(between) == 0 or high - low <= _CLOSE_ENOUGH * high:
            break
        # These cuts would be as large as asked for at another threshold: other cuts probably nearly so, too.
        wanted = tried[-1][0] if tried else high
        if not low < wanted < high or wanted in (low, high):
            wanted = (low + high) / 2
        threshold = float(between[max(np.searchsorted(between, wanted, side="right") - 1, 0)])
    return goal.choice(tried)


def choose_cuts_steps(
    pairs: FramePairs, frames: FrameSet, settings: MotionGraphSettings, threshold: float
) -> Generator[Progress, None, list[np.ndarray]]:
    """Find the cuts of each clip that keep the most goodness at a threshold (rad^2), of those found from all starts.

    Something is kept wherever the pairs up to the threshold close a loop (:mod:`.loops`).
    """
    yield Progress(0.0, "Choosing cuts")
    goodness = pairs.up_to(threshold).goodness(frames.n_frames, settings.goodness_width(threshold))
    rng = np.random.default_rng(settings.seed)
    steps = cut_steps(goodness, frames.lengths, settings.min_gap, settings.n_starts, rng)
    found = yield from portion(steps, 0.0, 0.5)
    # Not all are worth refining: only the most promising.
    scores = [kept_goodness(goodness, frames.lengths, cuts) for cuts in found]
    refined = []
    for rank, index in enumerate(np.argsort(scores, kind="stable")[::-1][:_N_REFINED]):
        steps = reconnect_steps(goodness, frames.lengths, settings.min_gap, found[index])
        refined.append((yield from portion(steps, 0.5 + 0.5 * rank / _N_REFINED, 0.5 + 0.5 * (rank + 1) / _N_REFINED)))
    best, kept = max(refined, key=lambda scored: scored[1])
    if kept == 0:
        # Where loops are few, the cuts that promise most may all miss them.
        loop = cheapest_loop(pairs.up_to(threshold), frames)
        if loop is not None:
            best = yield from _cuts_around_steps(loop, goodness, frames)
    return best


def _cuts_around_steps(
    loop: Loop, goodness: csr_matrix, frames: FrameSet
) -> Generator[Progress, None, list[np.ndarray]]:
    """Cuts that keep as much goodness as those of a loop, or more: found from those, and by refining them."""
    expected = np.concatenate(
        [sum(indicators(own, length)) for own, length in zip(loop.cuts, frames.lengths, strict=True)]
    )
    climbed = yield from portion(Ascent(goodness, frames.lengths, frames.min_gap).climb(expected), 1.0, 1.0)
    refined = []
    for cuts in (climbed, loop.cuts):
        steps = reconnect_steps(goodness, frames.lengths, frames.min_gap, cuts)
        refined.append((yield from portion(steps, 1.0, 1.0)))
    return max(refined, key=lambda scored: scored[1])[0]


class _AtMostLinks:
    """As many links as possible, at most ``max_links``."""

    def __init__(self, max_links: int):
        self.max_links = max_links

    def is_above(self, cut: Segmentation) -> bool:
        return np.count_nonzero(cut.inner) > self.max_links

    def best_of(self, cut: Segmentation) -> Outcome:
        """Find the largest threshold at which these segments have few enough links, or the lowest that links any."""
        costs = np.unique(cut.costs)
        connected = _first(costs, lambda cost: bool(cut.limited(cost).kept.any()))
        too_many = _first(costs, lambda cost: self.is_above(cut.limited(cost)))
        threshold = float(costs[max(too_many - 1, connected)])
        return threshold, cut.limited(threshold)

    def choice(self, tried: list[Outcome]) -> Outcome:
        allowed = [outcome for outcome in tried if not self.is_above(outcome[1])]
        if not allowed:
            threshold, fewest = min(tried, key=lambda outcome: np.count_nonzero(outcome[1].inner))
            raise MotionGraphError(
                f"No motion graph of at most {wording.number(self.max_links)} links was found: the smallest has "
                f"{wording.number(np.count_nonzero(fewest.inner))}, at a cost of {wording.short(threshold)}. Raise Max "
                "Links."
            )
        return max(allowed, key=lambda outcome: (np.count_nonzero(outcome[1].inner), -outcome[0]))


class _AtLeastCoverage:
    """The lowest threshold at which at least ``share`` of ``n_given`` frames are kept."""

    def __init__(self, share: float, n_given: float):
        self.share, self.n_given = share, n_given

    def coverage(self, cut: Segmentation) -> float:
        return float((cut.last - cut.first)[cut.kept].sum() / self.n_given)

    def is_above(self, cut: Segmentation) -> bool:
        return self.coverage(cut) >= self.share

    def best_of(self, cut: Segmentation) -> Outcome:
        """Find the lowest threshold at which enough of these segments is kept, or as much as ever."""
        costs = np.unique(cut.costs)
        goal = min(self.share, self.coverage(cut))
        enough = _first(costs, lambda cost: self.coverage(cut.limited(cost)) >= goal)
        threshold = float(costs[enough])
        return threshold, cut.limited(threshold)

    def choice(self, tried: list[Outcome]) -> Outcome:
        allowed = [outcome for outcome in tried if self.is_above(outcome[1])]
        if not allowed:
            threshold, most = max(tried, key=lambda outcome: (self.coverage(outcome[1]), -outcome[0]))
            raise MotionGraphError(
                f"At most {wording.exact_share(self.coverage(most), 4)} of the motion can be kept, at a cost of "
                f"{wording.short(threshold)}; {wording.exact_share(self.share)} were asked for. Lower Motion "
                "Kept, raise Max Cost, shorten Min Segment, or add clips."
            )
        return min(allowed, key=lambda outcome: (outcome[0], -self.coverage(outcome[1])))


def _linked(cuts: list[np.ndarray], frames: FrameSet, pairs: FramePairs) -> Segmentation:
    # Most pairs have no cut at either frame: they are left out before they are turned both ways.
    is_cut = np.zeros(frames.n_frames, dtype=bool)
    is_cut[np.concatenate([offset + own for offset, own in zip(frames.offsets, cuts, strict=True)])] = True
    joined = is_cut[pairs.first] & is_cut[pairs.second]
    transitions = with_continuations(pairs.first[joined], pairs.second[joined], pairs.cost[joined], frames.n_frames)
    return segmentation(cuts, frames.lengths, transitions)


def _first(costs: np.ndarray, holds: Callable[[float], bool]) -> int:
    """Find the index of the first of ascending ``costs`` for which ``holds``, if it holds for all after it, too.

    Whether or not it does: it holds there, and not for the one before. The number of costs if it holds for none
    that were looked at.
    """
    low, high = -1, len(costs)
    while high - low > 1:
        middle = (low + high) // 2
        if holds(float(costs[middle])):
            high = middle
        else:
            low = middle
    return high
