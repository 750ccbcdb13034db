"""Degrees, hubs and the use of clips, counted the obvious way."""

import numpy as np
import pytest

from core.motion.graph import build_motion_graph
from core.motion.graph_summary import summarize

from .motion_graphs import sample_graph
from .test_graph import reached_from_first, walk


def test_degrees_and_hubs_are_counted_from_the_links():
    graph = sample_graph()
    summary = summarize(graph)
    links = graph.links.tolist()
    connections = []
    for i in range(len(graph.segments)):
        assert summary.out_degree[i] == sum(a == i for a, _ in links)
        assert summary.in_degree[i] == sum(b == i for _, b in links)
        connections.append(summary.in_degree[i] * summary.out_degree[i])
    hubs = summary.hubs(5)
    assert [connections[i] for i in hubs] == sorted(connections, reverse=True)[:5]
    assert sorted(summary.by_connection.tolist()) == list(range(len(graph.segments)))
    assert connections[hubs[0]] > np.median(connections)


def test_every_clip_is_there_once_and_its_seconds_add_up():
    clips = [walk("a"), walk("blink", 10), walk("b", period=1.2), walk("far", 40, swing=1.2)]
    graph = build_motion_graph(clips)
    summary = summarize(graph)
    assert sorted(clip.name for clip in summary.clips) == sorted(clip.name for clip in clips)
    for clip in clips:
        (use,) = [use for use in summary.clips if use.name == clip.name]
        assert use.seconds == pytest.approx(clip.duration)
        assert use.kept_seconds + sum(seconds for seconds, _ in use.losses) == pytest.approx(use.seconds)
        assert (use.kept_seconds > 0) == (use.n_segments > 0)
    assert summary.seconds == pytest.approx(sum(clip.duration for clip in clips))
    assert 0 < summary.kept_seconds < summary.seconds
    assert len(summary.dropped) == len(graph.dropped)
    assert ("blink", pytest.approx(0.3), "shorter than a segment of 0.9 s") in summary.dropped


def test_what_was_cut_and_dropped_lies_outside_the_component():
    graph = sample_graph()
    n_kept, n_all = len(graph.segments), len(graph.segments) + len(graph.dropped_segments)
    assert n_all > n_kept
    links = graph.dropped_links.tolist()
    assert links == sorted(links) and len(links) > 0
    assert all(0 <= a < n_all and 0 <= b < n_all and max(a, b) >= n_kept for a, b in links)
    every = [*graph.links.tolist(), *links]
    there, back = reached_from_first(every), reached_from_first([(b, a) for a, b in every])
    assert there & back == set(range(n_kept))
    # The numbers mean what they say: across a cut, a segment is linked to the next of its clip.
    segments = [*graph.segments, *graph.dropped_segments]
    for i, one in enumerate(segments):
        for j, two in enumerate(segments):
            if (one.clip, one.last) == (two.clip, two.first):
                assert [i, j] in every
