"""Cuts chosen in different ways, side by side: what they are worth and what is kept of them."""

import time
from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_matrix

from core.motion.clip import MotionClip
from core.motion.connecting import kept_goodness, reconnect_steps
from core.motion.contacts import foot_contacts
from core.motion.cutting import cut_steps
from core.motion.distance import joined, pose_features
from core.motion.frame_pairs import FramePairs, FrameSet
from core.motion.graph_settings import MotionGraphSettings
from core.motion.segmentation import segmentation, with_continuations
from core.motion.threshold import choose_cuts_steps
from core.progress import finish
from tests.bench import problems
from tests.core.cuttings import exhaustive_best, greedy_cuts, total_goodness

Cuts = list[np.ndarray]


class CuttingProblem:
    """Clips ready to be cut: which frames could be linked, and how good that would be."""

    def __init__(self, clips: list[MotionClip], settings: MotionGraphSettings):
        clips = [clip.resampled(settings.frame_rate) for clip in clips]
        clips = [clip for clip in clips if clip.n_frames > settings.min_gap]
        self.settings, self.lengths = settings, np.array([clip.n_frames for clip in clips])
        features = joined([pose_features(clip, settings.cost) for clip in clips])
        contacts = np.concatenate([foot_contacts(clip, settings.contacts) for clip in clips])
        self.frames = FrameSet(features, contacts, self.lengths, settings.min_gap)
        self.pairs: FramePairs = finish(self.frames.pairs_steps(settings.max_cost))
        self.goodness = self.pairs.goodness(self.frames.n_frames, settings.goodness_width(settings.max_cost))

    def greedy(self) -> Cuts:
        return greedy_cuts(self.goodness, self.lengths, self.settings.min_gap)

    def in_total(self) -> Cuts:
        """Coordinate ascent on the goodness of all links, whether or not they end up in the graph."""
        arguments = self.goodness, self.lengths, self.settings.min_gap, self.settings.n_starts
        found = finish(cut_steps(*arguments, np.random.default_rng(self.settings.seed)))
        return max(found, key=lambda cuts: total_goodness(self.goodness, self.lengths, cuts))

    def reconnected(self) -> Cuts:
        """Coordinate ascent on the goodness of the links that are kept, from there."""
        steps = reconnect_steps(self.goodness, self.lengths, self.settings.min_gap, self.in_total())
        return finish(steps)[0]

    def best(self) -> Cuts:
        """The core's choice: the three most promising ascents in total, reconnected."""
        return finish(choose_cuts_steps(self.pairs, self.frames, self.settings, self.settings.max_cost))

    def outcome(self, cuts: Cuts) -> dict:
        transitions = with_continuations(self.pairs.first, self.pairs.second, self.pairs.cost, self.frames.n_frames)
        cut = segmentation(cuts, self.lengths, transitions)
        return {
            "objective": round(total_goodness(self.goodness, self.lengths, cuts), 1),
            "kept goodness": round(kept_goodness(self.goodness, self.lengths, cuts), 1),
            "segments": int(cut.kept.sum()),
            "links": int(cut.inner.sum()),
        }


def print_table() -> None:
    """Objective and what is kept of it, for different ways to choose cuts, on real clips and on tiny ones."""
    print(f"{'problem':34s}{'cuts':22s}{'objective':>10s}{'kept':>10s}{'segments':>10s}{'links':>8s}{'seconds':>9s}")
    rows: list[tuple[str, list[MotionClip], dict]] = [
        ("clips, cost up to 0.3", list(problems.clips()), {}),
        ("clips, cost up to 0.12", list(problems.clips()), {"max_cost": 0.12}),
        ("clips, 0.1, 0.5 s at least", list(problems.clips()), {"max_cost": 0.1, "min_segment_duration": 0.5}),
    ]
    if problems.large_clips():
        rows.append(("160 clips, cost up to 0.3", list(problems.large_clips()), {}))
    for name, clips, changes in rows:
        problem = CuttingProblem(clips, MotionGraphSettings(**changes))
        ways: list[tuple[str, Callable[[], Cuts]]] = [
            ("greedy, clip by clip", problem.greedy),
            ("ascent in total", problem.in_total),
            ("and reconnected", problem.reconnected),
            ("best of three such", problem.best),
        ]
        for way, cut in ways:
            start = time.process_time()
            cuts = cut()
            seconds = time.process_time() - start
            _print_row(name, way, problem.outcome(cuts), seconds)
    tiny = [_tiny_problem(seed) for seed in range(20)]
    lengths, gap = [7, 8], 3
    for label, score, kept in (("in total", total_goodness, False), ("kept", kept_goodness, True)):
        best = sum(exhaustive_best(goodness, lengths, gap, score) for goodness in tiny)
        ours = sum(_best_found(goodness, lengths, gap, kept) for goodness in tiny)
        greedy = sum(score(goodness, lengths, greedy_cuts(goodness, lengths, gap)) for goodness in tiny)
        print(
            f"20 tiny problems, goodness {label}: exhaustive {best:.2f}, ascent {ours:.2f} ({ours / best:.1%}), "
            f"greedy {greedy:.2f} ({greedy / best:.1%})"
        )


def _print_row(problem: str, way: str, outcome: dict, seconds: float) -> None:
    total, kept, segments, links = outcome.values()
    print(f"{problem:34s}{way:22s}{total:10.1f}{kept:10.1f}{segments:10d}{links:8d}{seconds:9.2f}", flush=True)


def _tiny_problem(seed: int) -> csr_matrix:
    """Two clips of seven and eight frames, small enough to try all their cuts."""
    rng = np.random.default_rng(seed)
    values = np.triu(rng.random((15, 15)) * (rng.random((15, 15)) < 0.3), 1)
    frame = np.arange(15)
    values[(np.abs(frame[:, None] - frame) < 3) & ((frame[:, None] < 7) == (frame < 7))] = 0
    return csr_matrix(values + values.T)


def _best_found(goodness: csr_matrix, lengths: list[int], gap: int, kept: bool) -> float:
    found = finish(cut_steps(goodness, np.array(lengths), gap, 8, np.random.default_rng(0)))
    if not kept:
        return max(total_goodness(goodness, np.array(lengths), cuts) for cuts in found)
    return max(finish(reconnect_steps(goodness, np.array(lengths), gap, cuts))[1] for cuts in found)
