"""Thresholds that are found: what each mode promises, counted on the graphs that come out."""

import numpy as np
import pytest

from core.errors import MotionGraphError
from core.motion.graph import MotionGraphSettings, ThresholdMode, build_motion_graph, build_motion_graph_steps
from core.progress import finish

from .motion_graphs import recorded_clips
from .test_graph import walk


def strolls(seed, n_clips=5):
    """Clips of stick figures that walk differently, so that links cost anything from nothing up."""
    rng = np.random.default_rng(seed)
    return [
        walk(
            f"stroll {number}",
            int(rng.integers(60, 140)),
            period=rng.uniform(0.9, 1.3),
            phase=rng.uniform(0, 6),
            turn=rng.uniform(-0.4, 0.4),
            swing=rng.uniform(0.3, 0.6),
        )
        for number in range(n_clips)
    ]


def at_most(max_links, **changes):
    return MotionGraphSettings(threshold_mode=ThresholdMode.LINKS, max_links=max_links, **changes)


def at_least(share, **changes):
    return MotionGraphSettings(threshold_mode=ThresholdMode.COVERAGE, min_coverage=share, **changes)


def coverage(graph, clips):
    return sum(segment.duration for segment in graph.segments) / sum(clip.duration for clip in clips)


@pytest.fixture(scope="module", params=["recorded", 0, 1, 2])
def clips(request):
    if request.param == "recorded":
        return recorded_clips(request.getfixturevalue("data_folder"))
    return strolls(request.param)


@pytest.fixture(scope="module")
def everything(clips):
    """The motion graph of the highest cost."""
    return build_motion_graph(clips)


def test_never_more_links_than_allowed_and_nearly_as_many(clips, everything):
    for share in (0.9, 0.3, 0.1):
        allowed = int(share * len(everything.links))
        graph = build_motion_graph(clips, at_most(allowed))
        assert 0.8 * allowed <= len(graph.links) <= allowed
        assert graph.link_costs.max() <= graph.max_cost < everything.max_cost
        assert graph.link_costs.mean() < everything.link_costs.mean()


def test_where_all_links_are_allowed_the_graph_is_that_of_the_highest_cost(clips, everything):
    graph = build_motion_graph(clips, at_most(len(everything.links)))
    np.testing.assert_array_equal(graph.links, everything.links)
    assert graph.max_cost <= everything.max_cost == 0.3


def test_enough_motion_is_kept_at_a_lower_cost(clips, everything):
    for share in (0.3, 0.6, 0.95):
        asked = share * coverage(everything, clips)
        graph = build_motion_graph(clips, at_least(asked))
        assert coverage(graph, clips) >= asked - 1e-9
        # The dearest link is needed: without it these cuts would keep less.
        assert graph.link_costs.max() == graph.max_cost <= everything.max_cost
        cheaper = build_motion_graph(clips, MotionGraphSettings(max_cost=0.8 * graph.max_cost))
        assert coverage(cheaper, clips) < asked


def test_progress_rises_through_all_thresholds_that_are_tried():
    seen = []
    finish(build_motion_graph_steps(strolls(0), at_most(10)), seen.append)
    fractions = [progress.fraction for progress in seen]
    assert fractions == sorted(fractions)
    assert 0 <= fractions[0] < 0.1 and 0.6 < fractions[-1] <= 1
    # More than one threshold was tried.
    messages = [progress.message for progress in seen]
    assert messages.index("Connecting segments") < len(messages) - 1 - messages[::-1].index("Choosing cuts")


def test_what_cannot_be_kept_is_said_with_the_most_that_can(clips):
    share = 0.999999
    with pytest.raises(MotionGraphError, match=r"At most [\d.]+% of the motion can be kept, at a cost of") as caught:
        build_motion_graph(clips, at_least(share))
    said, cost = str(caught.value).split("At most ")[1].split("% of the motion can be kept, at a cost of ")
    most = float(said) / 100
    found = build_motion_graph(clips, MotionGraphSettings(max_cost=0.3))
    assert coverage(found, clips) == pytest.approx(most, abs=1e-3)
    assert 0 < float(cost.split(";")[0]) <= 0.3
    # What is said to be possible is possible.
    assert coverage(build_motion_graph(clips, at_least(most - 1e-3)), clips) >= most - 1e-3


def test_a_higher_ceiling_allows_more():
    clips = strolls(0)
    low, high = (build_motion_graph(clips, at_most(100_000, max_cost=cost)) for cost in (0.1, 0.5))
    assert len(low.links) < len(high.links)
    assert low.max_cost <= 0.1 < high.max_cost <= 0.5


def test_too_few_links_for_any_graph_are_refused():
    # Two stretches of walking that only lead to each other: neither makes a loop by itself.
    one = walk("one", 22, swing=0.5, phase=0.0, period=2 * 21 / 30)
    two = walk("two", 22, swing=0.5, phase=np.pi, period=2 * 21 / 30)
    graph = build_motion_graph([one, two], MotionGraphSettings(min_segment_duration=0.7))
    assert len(graph.links) == 2
    settings = at_most(1, min_segment_duration=0.7)
    with pytest.raises(MotionGraphError, match="at most 1 links was found: the smallest has 2"):
        build_motion_graph([one, two], settings)


def test_nothing_connects_is_said_in_every_mode():
    clip = walk(period=20.0, swing=1.0)
    for settings in (at_most(10, max_cost=1e-4), at_least(0.1, max_cost=1e-4)):
        with pytest.raises(MotionGraphError, match="Nothing connects at a cost of"):
            build_motion_graph([clip], settings)


@pytest.mark.parametrize("wrong", [{"max_links": 0}, {"min_coverage": 0.0}, {"min_coverage": 1.5}])
def test_senseless_wishes_are_refused(wrong):
    with pytest.raises(MotionGraphError):
        MotionGraphSettings(**wrong)
