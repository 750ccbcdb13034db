"""What would need more memory than there is gets refused by a sentence, before it is begun."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintRule, FootprintSettings
from core.embedding.stencil import build_stencils, fewest_stencils
from core.environment.grid import MOST_HEADINGS, Grid
from core.errors import EmbeddingError, EvaluationError, MotionGraphError, SceneError, WalkError
from core.evaluation.path_efficiency import path_efficiency_steps
from core.motion.distance import close_pairs_steps, expected_pairs, joined, pose_features
from core.motion.graph import MotionGraphSettings, build_motion_graph
from core.motion.repertoire import sample_repertoire
from core.playback.crowd import crowd_steps
from core.playback.styles import WalkRequest, walk_steps
from core.playback.walk import random_node
from core.progress import finish

from .reference import random_problem

BASES = st.sampled_from([0.0, 0.3, 2.0])
RATES = st.sampled_from([0.0, 0.08, 0.2])


@settings(max_examples=30)
@given(st.integers(0, 10**6), BASES, RATES, BASES, RATES, st.sampled_from(FootprintRule))
def test_stencils_are_no_fewer_than_foretold(seed, position_base, position_rate, heading_base, heading_rate, rule):
    graph, environment = random_problem(seed, False)
    footprint = FootprintSettings(position_base, position_rate, heading_base, heading_rate, rule)
    n_stencils = len(build_stencils(graph.segments, environment.grid, footprint))
    fewest = fewest_stencils(graph.segments, environment.grid, footprint)
    assert fewest <= n_stencils
    if position_base / environment.grid.cell_size >= 4:
        # Where it matters, it is nearly true.
        assert fewest >= 0.6 * n_stencils


@pytest.mark.parametrize("limit", [1e3, 1e9, 1e150, 1e308])
def test_limits_beyond_any_sense_are_refused_at_once(limit):
    graph, environment = random_problem(3, False)
    for footprint in (
        FootprintSettings(position_base=limit),
        FootprintSettings(position_rate=limit, heading_base=limit),
    ):
        with pytest.raises(EmbeddingError, match=r"would need about .* more than the limit of 4 GB"):
            embed(graph, environment, EmbeddingSettings(footprint))
    # Footprints without a heading hold nothing, however wide they are.
    nowhere = FootprintSettings(position_base=limit, heading_rate=0.0, rule=FootprintRule.CONSERVATIVE)
    turned = tuple(
        replace(s, path=s.path + [0, 0, 0.01] * (np.arange(s.n_frames)[:, None] > 0)) for s in graph.segments
    )
    assert embed(replace(graph, segments=turned), environment, EmbeddingSettings(nowhere)).n_nodes == 0


@pytest.mark.parametrize("max_cost", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("n_clips", [2, 12])
def test_pairs_are_about_as_many_as_foretold(n_clips, max_cost):
    features = joined([pose_features(clip.resampled(30.0)) for clip in sample_repertoire()[:n_clips]])
    classes = np.arange(features.n_frames) // 17 % 3
    for of_frames in (None, classes):
        n_pairs = len(finish(close_pairs_steps(features, max_cost, of_frames))[0])
        assert 0.8 * n_pairs - 30 <= expected_pairs(features, max_cost, of_frames) <= 1.3 * n_pairs + 30


def test_too_many_pairs_are_refused_with_what_they_would_need():
    clips = sample_repertoire()[:6]
    graph = build_motion_graph(clips, MotionGraphSettings(n_starts=1, memory_limit=1e8))
    assert len(graph.links)
    sentence = r"million pairs .* these 6 clips cost 3 or less\. .*lower Max Cost.*'walk"
    with pytest.raises(MotionGraphError, match=sentence):
        build_motion_graph(clips, MotionGraphSettings(max_cost=3.0, n_starts=1, memory_limit=6e6))


@pytest.mark.parametrize("duration", [1e7, 1e30, 1e300])
@pytest.mark.parametrize("style", ["WANDER", "RANDOM", "LOOP"])
def test_walks_that_need_too_much_are_refused_before_they_are_planned(duration, style):
    embedding = next(e for e in (embed(*random_problem(seed, False)) for seed in range(30)) if e.n_nodes)
    with pytest.raises(WalkError, match=r"would need about .* more than the limit of 4 GB; give a shorter Duration"):
        next(steps := walk_steps(embedding, WalkRequest(style, duration=duration)))
    steps.close()
    starts = [random_node(embedding, np.random.default_rng(0))] * 3
    with pytest.raises(WalkError, match=r"3 walks of .* would need about .* fewer Walkers"):
        finish(crowd_steps(embedding, starts, duration, np.random.default_rng(0)))
    # Short ones are planned with the same limit.
    assert len(finish(walk_steps(embedding, WalkRequest("RANDOM", duration=2.0))))


def test_numbers_beyond_any_sense_are_refused_at_once():
    embedding = next(e for e in (embed(*random_problem(seed, False)) for seed in range(30)) if e.n_nodes)
    with pytest.raises(EvaluationError, match=r"1,000,000,000 pairs .* ask for 100,000 or fewer"):
        finish(path_efficiency_steps(embedding, np.random.default_rng(0), 10**9))
    assert Grid((10, 10, MOST_HEADINGS), 0.1).n_headings == 3600
    for many in (3601, 10**5, 10**300):
        with pytest.raises(SceneError, match="use 3,600 or fewer"):
            Grid((10, 10, many), 0.1)
