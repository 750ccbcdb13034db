"""Loops, beside all cuts that there are; and what is said where nothing connects, followed to the letter."""

import re
from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import MotionGraphError
from core.motion.distance import PoseFeatures
from core.motion.frame_pairs import FrameSet
from core.motion.graph import MotionGraphSettings, build_motion_graph
from core.motion.loops import cheapest_loop, lowest_loop_cost_steps, once_each
from core.motion.repertoire import sample_repertoire
from core.motion.segmentation import segmentation, with_continuations
from core.progress import finish

from .test_graph import walk

GAP = 2


def random_frames(seed: int) -> FrameSet:
    rng = np.random.default_rng(seed)
    lengths = rng.integers(2, 7, rng.integers(1, 4))
    n_frames = int(lengths.sum())
    features = PoseFeatures(np.tile([1.0, 0, 0, 0], (n_frames, 1, 1)), np.ones(1), rng.normal(size=(n_frames, 2)))
    # With as many kinds of planted feet as make loops rare.
    contacts = rng.random((n_frames, 2)) < rng.choice([0.05, 0.5])
    return FrameSet(features, contacts, lengths, GAP)


def possible_pairs(frames: FrameSet) -> dict[tuple[int, int], float]:
    found = {}
    for i, j in combinations(range(frames.n_frames), 2):
        near = frames.owner[i] == frames.owner[j] and j - i < GAP
        if not near and (frames.contacts[i] == frames.contacts[j]).all():
            cost = float(((frames.features.vectors[i] - frames.features.vectors[j]) ** 2).sum())
            found[i, j] = found[j, i] = cost
    return found


def lowest_by_trying_all_cuts(frames: FrameSet) -> float:
    pairs, lowest = possible_pairs(frames), np.inf
    for cuts in product(*(all_cuts(first, n) for first, n in zip(frames.offsets, frames.lengths, strict=True))):
        segments = [pair for own in cuts for pair in pairwise(own)]
        links = {}
        for a, b in product(range(len(segments)), repeat=2):
            end, start = segments[a][1], segments[b][0]
            links[a, b] = 0.0 if end == start else pairs.get((end, start), np.inf)
        for cost in sorted({cost for cost in links.values() if cost < lowest}):
            if has_loop({link for link, of_link in links.items() if of_link <= cost}):
                lowest = cost
                break
    return lowest


def all_cuts(first: int, n_frames: int) -> list[tuple[int, ...]]:
    every = range(int(first), int(first + n_frames))
    chosen = [own for k in range(2, n_frames + 1) for own in combinations(every, k)]
    return [(), *(own for own in chosen if min(np.diff(own)) >= GAP)]


def has_loop(links: set[tuple[int, int]]) -> bool:
    """Whether something is left when segments that nothing leads on from are struck out, again and again."""
    while True:
        left = {(a, b) for a, b in links if any(b == c for c, _ in links)}
        if left == links:
            return bool(links)
        links = left


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_the_cheapest_loop_is_that_of_all_cuts(seed):
    frames = random_frames(seed)
    lowest = lowest_by_trying_all_cuts(frames)
    assert finish(lowest_loop_cost_steps(frames, 1e-3, np.inf)) == pytest.approx(lowest, rel=1e-5)
    pairs = finish(frames.pairs_steps(1e3))
    loop = cheapest_loop(pairs, frames)
    if loop is None:
        assert lowest == np.inf
        return
    assert loop.cost == pytest.approx(lowest, rel=1e-5)
    allowed = pairs.up_to(loop.cost)
    transitions = with_continuations(allowed.first, allowed.second, allowed.cost, frames.n_frames)
    assert segmentation(loop.cuts, frames.lengths, transitions).kept.any()


def test_some_of_these_have_no_loop_and_some_loops_go_through_several_clips():
    loops = []
    for seed in range(200):
        frames = random_frames(seed)
        loops.append(cheapest_loop(finish(frames.pairs_steps(1e3)), frames))
    n_clips = [sum(len(own) > 0 for own in loop.cuts) for loop in loops if loop is not None]
    assert 10 < loops.count(None) < 150 and n_clips.count(1) > 10 and n_clips.count(2) > 3


@cache
def sample_clips():
    return {clip.name: clip for clip in sample_repertoire()}


@pytest.mark.parametrize("max_cost", [0.02, 0.3, 0.5, 0.8])
@pytest.mark.parametrize("name", ["walk", "stop_left"])
def test_a_clip_that_leads_back_to_itself_connects(name, max_cost):
    graph = build_motion_graph([sample_clips()[name]], MotionGraphSettings(max_cost=max_cost))
    assert len(graph.links) > 0 and graph.link_costs.max() <= max_cost


def test_what_is_said_where_nothing_connects_helps():
    n_helped = 0
    for clip in (*list(sample_clips().values())[::2], walk(period=20.0, swing=1.0)):
        asked = MotionGraphSettings(max_cost=1e-3, n_starts=1)
        try:
            build_motion_graph([clip], asked)
        except MotionGraphError as error:
            said = str(error)
        else:
            continue
        if "Max Cost" not in said:
            assert "at whatever cost" in said
            with pytest.raises(MotionGraphError, match="at whatever cost"):
                build_motion_graph([clip], replace(asked, max_cost=50.0))
            continue
        lowest = float(re.search(r"leads back to where it begins is ([\d.]+)\.", said)[1])
        advice = float(re.search(r"Raise Max Cost to ([\d.]+),", said)[1])
        assert asked.max_cost < lowest < advice
        for cost, connects in ((0.99 * lowest, False), (1.01 * lowest, True), (advice, True)):
            try:
                assert connects == (len(build_motion_graph([clip], replace(asked, max_cost=cost)).links) > 0)
            except MotionGraphError:
                assert not connects
        n_helped += 1
    assert n_helped > 5


def test_no_cost_helps_where_feet_never_come_back():
    # It begins on the ground, and ends in the air before a segment is over.
    clip = walk("stand", 22, swing=0.0)
    still = clip.translations.copy()
    still[:, 0, :2] = 0
    clip, lifted = replace(clip, translations=still), still.copy()
    lifted[15:, 0, 2] += 1
    for max_cost in (0.01, 1000.0):
        settings = MotionGraphSettings(max_cost=max_cost, min_segment_duration=0.67)
        with pytest.raises(MotionGraphError, match=r"at whatever cost.*shorter Min Segment"):
            build_motion_graph([replace(clip, translations=lifted)], settings)
    assert len(build_motion_graph([clip], replace(settings, max_cost=0.01)).links) > 0


def test_frames_that_need_too_much_memory_are_refused_by_name():
    clips = [walk("short", 61), walk("long", 9001)]
    settings = MotionGraphSettings(frame_rate=1000.0, memory_limit=8e8)
    sentence = r"2 clips have 302,002 frames at 1,000 .*the longest is 'long'"
    with pytest.raises(MotionGraphError, match=sentence) as caught:
        build_motion_graph(clips, settings)
    assert "lower Frame Rate" in str(caught.value) and "846 MB" in str(caught.value)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 20), st.integers(GAP, 20)), min_size=1, max_size=8))
def test_a_loop_that_comes_twice_to_a_clip_is_shortened(stays):
    owner = np.repeat(np.arange(4), 50)
    visits = [(50 * clip + begin, 50 * clip + begin + length) for clip, begin, length in stays]
    transitions = {(a[1], b[0]) for a, b in zip(visits, [*visits[1:], visits[0]], strict=True)}
    shorter = once_each(visits, owner)
    assert len({owner[entered] for entered, _ in shorter}) == len(shorter) > 0
    for (entered, left), (onward, _) in zip(shorter, [*shorter[1:], shorter[0]], strict=True):
        assert owner[entered] == owner[left] and left - entered >= GAP and (left, onward) in transitions
