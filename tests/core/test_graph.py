"""Motion graphs of recorded and made-up clips: every property a graph promises, the obvious way."""

import time
import tracemalloc
import weakref
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.errors import ClipError, MotionGraphError
from core.motion.clip import MotionClip
from core.motion.contacts import foot_contacts
from core.motion.distance import pose_features
from core.motion.graph import (
    MotionGraphSettings,
    build_motion_graph,
    build_motion_graph_steps,
    segment_name,
)
from core.motion.skeleton import Skeleton
from core.progress import finish

from .bvh import read_bvh
from .dense_costs import transition_costs
from .motion_graphs import SHORT, recorded_clips, sample_graph

NAMES = ("hips", "thigh.L", "shin.L", "foot.L", "thigh.R", "shin.R", "foot.R")


def walk(name="walk", n_frames=151, period=1.0, frame_rate=30.0, phase=0.0, turn=0.0, names=NAMES, swing=0.5):
    """A stick figure with legs like scissors, walking from where it faces; ``turn`` rad per second."""
    n_joints = len(names)
    parents = np.array([-1, 0, 1, 2, 0, 4, 5])[:n_joints]
    below = (0, 0, -0.4)
    rest = np.array([(0, 0, 0.9), (0, 0.1, 0), below, below, (0, -0.1, 0), below, below])
    skeleton = Skeleton(
        tuple(names), parents, np.tile([1.0, 0, 0, 0], (n_joints, 1)), rest[:n_joints], np.array([1.0, 0, 0])
    )
    seconds = np.arange(n_frames) / frame_rate
    angle = swing * np.sin(2 * np.pi * seconds / period + phase)
    rotations = np.tile([1.0, 0, 0, 0], (n_frames, n_joints, 1))
    for joint, sign in ((1, 1), (4, -1)):
        rotations[:, joint] = Rotation.from_euler("Y", sign * angle[:, None]).as_quat(scalar_first=True)
    rotations[:, 0] = Rotation.from_euler("Z", (turn * seconds)[:, None]).as_quat(scalar_first=True)
    translations = np.tile(rest[:n_joints], (n_frames, 1, 1))
    step = np.column_stack([np.cos(turn * seconds), np.sin(turn * seconds)]) / frame_rate
    translations[:, 0, :2] = np.cumsum(step, axis=0)
    return MotionClip(name, skeleton, frame_rate, rotations, translations)


GRAPHS = ("loose", "tight", "sample")


@pytest.fixture(params=GRAPHS)
def graph_and_settings(request):
    if request.param == "sample":
        return sample_graph(), SHORT
    clips = recorded_clips(request.getfixturevalue("data_folder"))
    loose = MotionGraphSettings()
    tight = MotionGraphSettings(max_cost=0.1, min_segment_duration=0.5)
    settings = loose if request.param == "loose" else tight
    return build_motion_graph(clips, settings), settings


def test_links_are_those_of_an_obvious_double_loop(graph_and_settings):
    graph, settings = graph_and_settings
    features = [pose_features(clip, settings.cost) for clip in graph.clips]
    contacts = [foot_contacts(clip) for clip in graph.clips]
    costs = {
        (a, b): transition_costs(features[a], features[b])
        for a in {s.clip for s in graph.segments}
        for b in {s.clip for s in graph.segments}
    }
    cost_of_link = dict(zip(map(tuple, graph.links.tolist()), graph.link_costs, strict=True))
    for i, one in enumerate(graph.segments):
        for j, two in enumerate(graph.segments):
            if (one.clip, one.last) == (two.clip, two.first):
                assert cost_of_link[i, j] == 0
                continue
            cost = costs[one.clip, two.clip][one.last, two.first]
            same_feet = (contacts[one.clip][one.last] == contacts[two.clip][two.first]).all()
            if (i, j) in cost_of_link:
                assert same_feet
                assert cost_of_link[i, j] == pytest.approx(cost, abs=1e-4)
                assert cost <= settings.max_cost + 1e-5
            else:
                assert not same_feet or cost > settings.max_cost - 1e-5


def test_links_are_sorted_and_unique_and_connect_everything(graph_and_settings):
    graph, _ = graph_and_settings
    links = [tuple(link) for link in graph.links.tolist()]
    assert links == sorted(set(links))
    assert len(graph.link_costs) == len(links)
    for direction in (links, [(b, a) for a, b in links]):
        assert reached_from_first(direction) == set(range(len(graph.segments)))


def reached_from_first(links):
    found, waiting = {0}, [0]
    while waiting:
        at = waiting.pop()
        new = {b for a, b in links if a == at} - found
        found |= new
        waiting.extend(new)
    return found


def test_segments_are_pieces_of_their_clips(graph_and_settings):
    graph, settings = graph_and_settings
    for segment in graph.segments:
        clip = graph.clips[segment.clip]
        assert clip.frame_rate == graph.frame_rate == settings.frame_rate
        assert 0 <= segment.first < segment.last < clip.n_frames
        assert segment.n_frames == len(segment.path)
        assert segment.last - segment.first >= settings.min_gap
        assert segment.duration == pytest.approx((segment.last - segment.first) / 30)
        assert segment.duration >= settings.min_segment_duration - 0.5 / 30
        ground = clip.ground_path[segment.first : segment.last + 1]
        np.testing.assert_array_equal(segment.path[0], 0)
        np.testing.assert_allclose(segment.path[:, 2], ground[:, 2] - ground[0, 2], atol=1e-12)
        turned = Rotation.from_rotvec([0, 0, ground[0, 2]]).apply(segment.path * [1, 1, 0])
        np.testing.assert_allclose(turned[:, :2], ground[:, :2] - ground[0, :2], atol=1e-12)
        for tag, mask in segment.tags.items():
            np.testing.assert_array_equal(mask, clip.tags[tag][segment.first : segment.last + 1])
            assert mask.any()
    by_clip = {}
    for segment in graph.segments:
        by_clip.setdefault(segment.clip, []).append((segment.first, segment.last))
    for pieces in by_clip.values():
        # One after the other, without a gap: what lies between two kept segments joins them.
        assert all(last == first for (_, last), (first, _) in pairwise(pieces))


def test_every_second_is_kept_or_accounted_for(graph_and_settings):
    graph, _ = graph_and_settings
    kept = {clip.name: 0.0 for clip in graph.clips}
    for segment in graph.segments:
        kept[graph.clips[segment.clip].name] += segment.duration
    for dropped in graph.dropped:
        assert dropped.seconds > 0 and dropped.reason
        kept[dropped.clip] += dropped.seconds
    for clip in graph.clips:
        assert kept[clip.name] == pytest.approx(clip.duration, abs=1e-6)


@pytest.mark.parametrize(
    ("max_cost", "min_segment_duration", "segments", "links"),
    [(0.12, 0.67, 33, 203), (0.3, 0.67, 59, 1040), (0.1, 0.5, 55, 277)],
)
def test_recorded_clips_make_a_rich_graph(data_folder, max_cost, min_segment_duration, segments, links):
    settings = MotionGraphSettings(max_cost=max_cost, min_segment_duration=min_segment_duration)
    graph = build_motion_graph(recorded_clips(data_folder), settings)
    assert len(graph.segments) >= segments
    assert len(graph.links) >= links


def test_jumps_take_part_in_the_graph_of_recorded_clips(data_folder):
    graph = build_motion_graph(recorded_clips(data_folder))
    flights = 0
    for segment in graph.segments:
        contacts = foot_contacts(graph.clips[segment.clip])[segment.first : segment.last + 1]
        flights += (~contacts.any(axis=1)).sum() > 8
    assert flights >= 1


def test_steps_take_part_in_the_graph_of_the_sample():
    assert sum("step" in segment.tags for segment in sample_graph().segments) >= 3


def test_the_same_clips_make_the_same_graph():
    clips = [walk("a"), walk("b", period=1.1), walk("c", turn=0.3)]
    one, two = build_motion_graph(clips), build_motion_graph(clips)
    np.testing.assert_array_equal(one.links, two.links)
    np.testing.assert_array_equal(one.link_costs, two.link_costs)
    assert [s.name for s in one.segments] == [s.name for s in two.segments]


def test_progress_rises_and_the_steps_return_the_graph():
    fractions = []
    graph = finish(build_motion_graph_steps([walk("a"), walk("b")]), lambda p: fractions.append(p.fraction))
    assert len(graph.links) > 0
    assert fractions == sorted(fractions)
    assert fractions[0] >= 0 and fractions[-1] <= 1


def test_work_pauses_often_and_can_be_given_up(data_folder):
    files = sorted((data_folder / "cmu_locomotion").glob("*.bvh"))
    steps = build_motion_graph_steps([read_bvh(file) for file in files])
    pauses = []
    before = time.process_time()
    for progress in steps:
        pauses.append(time.process_time() - before)
        if progress.fraction > 0.6:
            break
        before = time.process_time()
    # Far less than the third of a second that an artist notices, but machines are busy.
    assert max(pauses) < 1.0 and np.median(pauses) < 0.05
    assert progress.message == "Choosing cuts"
    held = weakref.ref(steps)
    steps.close()
    del steps
    assert held() is None


def test_giving_up_frees_the_clips_features():
    tracemalloc.start()
    try:
        clips = [walk("a", 1500), walk("b", 1500, turn=0.1)]
        start = tracemalloc.get_traced_memory()[0]
        steps = build_motion_graph_steps(clips)
        while next(steps).message != "Choosing cuts":
            pass
        busy = tracemalloc.get_traced_memory()[0] - start
        steps.close()
        left = tracemalloc.get_traced_memory()[0] - start
    finally:
        tracemalloc.stop()
    # What the clips themselves remember (world positions, headings) stays theirs.
    remembered = sum(sum(a.nbytes for a in clip.world) + clip.root_heading.nbytes for clip in clips)
    assert busy > remembered + 1e6
    assert left < 1.5 * remembered + 1e6


def test_one_walk_links_to_itself():
    graph = build_motion_graph([walk()])
    assert len(graph.links) > len(graph.segments)


def test_any_frame_rate_goes_in():
    graph = build_motion_graph([walk("a", 481, frame_rate=120.0), walk("b", 97, frame_rate=24.0)])
    assert {clip.frame_rate for clip in graph.clips} == {30.0}
    assert {segment.clip for segment in graph.segments} == {0, 1}


def test_links_need_the_same_feet_on_the_ground():
    settings = SHORT
    ungrounded = replace(settings, contacts=replace(settings.contacts, height=1e-9, release_height=1e-9))
    clips = [walk("a", swing=0.2), walk("b", phase=1.0, swing=0.2)]
    strict = build_motion_graph(clips, settings)
    loose = build_motion_graph(clips, ungrounded)
    for graph, checked in ((strict, True), (loose, False)):
        contacts = [foot_contacts(clip) for clip in graph.clips]
        ends = [contacts[graph.segments[a].clip][graph.segments[a].last] for a, _ in graph.links]
        starts = [contacts[graph.segments[b].clip][graph.segments[b].first] for _, b in graph.links]
        assert np.array_equal(ends, starts) == checked


def test_clips_of_the_same_name_get_numbers():
    graph = build_motion_graph([walk("walk"), walk("walk"), walk("walk (2)"), walk("walk")])
    assert [clip.name for clip in graph.clips] == ["walk", "walk (3)", "walk (2)", "walk (4)"]
    names = [segment.name for segment in graph.segments]
    assert len(set(names)) == len(names)


def test_segments_are_named_by_the_frames_of_their_source():
    clip = replace(walk("16_11"), first_frame=10.0)
    assert segment_name(clip, 24, 47) == "16_11 [34-57]"
    for segment in build_motion_graph([clip]).segments:
        assert segment.name == f"16_11 [{segment.first + 10}-{segment.last + 10}]"


def test_tags_follow_the_frames():
    tags = np.zeros(151, dtype=bool)
    tags[70:75] = True
    graph = build_motion_graph([replace(walk(), tags={"step": tags})])
    tagged = [segment for segment in graph.segments if "step" in segment.tags]
    assert 0 < len(tagged) < len(graph.segments)
    assert sum(segment.tags["step"][:-1].sum() for segment in tagged) == 5


def test_short_clips_are_dropped_and_said_so():
    graph = build_motion_graph([walk("a"), walk("blink", 10), walk("tick", 3, frame_rate=240.0)])
    assert [clip.name for clip in graph.clips] == ["a"]
    short = [d for d in graph.dropped if "shorter" in d.reason]
    assert [(d.clip, round(d.seconds, 3)) for d in short] == [("blink", 0.3), ("tick", 0.008)]


@pytest.mark.parametrize(
    ("n_frames", "reason"),
    [
        (22, "no transitions at a cost of 0.3 or less"),
        (
            91,
            "its transitions lead only to motion that was dropped",
        ),  # a loop of its own, but the smaller one
    ],
)
def test_clips_that_do_not_fit_are_dropped_and_said_so(n_frames, reason):
    high = walk("high", n_frames)
    raised = high.translations + np.eye(len(NAMES))[0][:, None] * [0, 0, 5]
    graph = build_motion_graph([walk("a"), walk("b"), replace(high, translations=raised)], SHORT)
    (lost,) = [d for d in graph.dropped if d.clip == "high"]
    assert lost.reason == reason


@pytest.mark.parametrize(
    ("clips", "message"),
    [
        ([], "no clips"),
        ([walk("blink", 10), walk("wink", 15)], "shorter than one segment of 0.9 s .*'wink'"),
        ([walk("a"), walk("b", names=(*NAMES[:6], "Fuss.R"))], r"'b' is of another skeleton.*'Fuss\.R'"),
        ([walk("a"), walk("b", names=NAMES[:6])], r"'b' is of another skeleton.*no bone 'foot\.R'"),
        (
            [walk("a"), walk("b", names=(*NAMES[:5], "foot.R", "shin.R"))],
            r"'b' is of another.*'foot\.R' at an",
        ),
    ],
)
def test_unusable_clips_are_refused_by_name(clips, message):
    with pytest.raises(ClipError, match=message):
        build_motion_graph(clips)


def test_nothing_connects_names_a_cost_that_does():
    # Once through half a swing, never the same pose twice, at any speed: it cannot link to itself.
    clip = walk(period=20.0, swing=1.0)
    with pytest.raises(MotionGraphError, match=r"Nothing connects at a cost of 0\.0001 .*lowest cost") as caught:
        build_motion_graph([clip], MotionGraphSettings(max_cost=1e-4))
    advice = float(str(caught.value).split("Max Cost to ")[1].split(",")[0])
    assert advice > 1e-4
    assert len(build_motion_graph([clip], MotionGraphSettings(max_cost=advice)).links) > 0


@pytest.mark.parametrize(
    "wrong",
    [
        {"frame_rate": 0},
        {"frame_rate": 1e9},
        {"min_segment_duration": -1},
        {"max_cost": np.nan},
        {"sigma": 0},
        {"n_starts": 0},
    ],
)
def test_senseless_settings_are_refused(wrong):
    with pytest.raises(MotionGraphError):
        MotionGraphSettings(**wrong)


def test_a_narrow_sigma_still_counts_every_link():
    # Room for one segment only: without the link from its end to its start there is nothing to gain.
    loop = walk("loop", 38)
    for sigma in (None, 1e-9):
        graph = build_motion_graph([loop], MotionGraphSettings(sigma=sigma, min_segment_duration=0.67))
        assert graph.links.tolist() == [[0, 0]]
        assert graph.link_costs[0] > 1e-6
