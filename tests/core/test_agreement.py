"""The same question has the same answer, whoever is asked: coverage, weak spots, reasons, extents, curves, metrics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.environment.regions import RegionMask, RegionRule
from core.evaluation.action_coverage import action_coverage
from core.evaluation.environment_coverage import environment_coverage
from core.evaluation.floor import floor_cells
from core.evaluation.metrics import metrics_steps
from core.evaluation.reach import round_times
from core.evaluation.size import embedding_size
from core.evaluation.variability import coverage_share
from core.evaluation.weak_spots import WeakSpotSettings, weak_spots_steps
from core.evaluation.why_not import Reason, why_not_steps
from core.progress import finish
from core.report.topics.metrics import actions_table, metrics_table
from core.tuning.pruning_curve import pruning_curve_steps

from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.booleans())
def test_all_speak_of_the_same_floor(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    floor, covered, reasons = floor_cells(embedding), embedding.covered().any(axis=2), finish(why_not_steps(embedding))
    apart = (Reason.BLOCKED, Reason.RULE, Reason.FORBIDDEN)
    assert np.array_equal(floor, (~np.isin(reasons, apart)).any(axis=2))
    assert np.array_equal(covered, (reasons == Reason.EMBEDDED).any(axis=2))
    ground, spots = environment_coverage(embedding), finish(weak_spots_steps(embedding, WeakSpotSettings(min_area=0)))
    assert ground.covered_area + spots.area == pytest.approx(ground.free_area)
    assert ground.position_share == coverage_share(embedding) == embedding_size(embedding).share <= 1
    assert embedding_size(embedding).floor == pytest.approx(ground.covered_area)
    assert not any(spot.reason in apart for spot in spots.spots)
    curve = finish(pruning_curve_steps(embedding))
    if len(curve.k):
        assert curve.floor_coverage[-1] == pytest.approx(ground.position_share)
        assert curve.coverage[-1] == pytest.approx(ground.task_share)
    assert np.all(action_coverage(embedding).shares <= ground.position_share + 1e-12)


def test_a_step_that_is_only_crossed_is_neither_reached_nor_missing():
    """A sill across an open room takes nothing from the coverage of a character that strides over it."""
    grid = Grid((20, 24, 12), 0.25)
    free, band = np.zeros((80, 96), dtype=bool), np.zeros((80, 96), dtype=bool)
    band[:, 41:55] = True
    sill = (RegionMask("Sill", RegionRule.REQUIRE, "step", band),)
    embedding = embed(sample_graph(), Environment(grid, free, sill))
    covered, ruled = embedding.covered().any(axis=2), band[2::4, 2::4]
    assert covered[:, :10].all() and covered[:, 14:].all() and not covered[ruled].all()
    assert not floor_cells(embedding)[ruled & ~covered].any()
    assert (finish(why_not_steps(embedding))[ruled & ~covered] == Reason.RULE).all()
    assert environment_coverage(embedding).position_share == 1.0
    # Where nobody can step, the far side is missing, and the sill is still a matter of its rule.
    band[:, 30:66] = True
    cut = embed(sample_graph(), Environment(grid, free, sill))
    assert (finish(why_not_steps(cut))[:, 9:15] == Reason.RULE).all() and not floor_cells(cut)[:, 9:15].any()
    assert finish(weak_spots_steps(cut)).area > 5


def test_metrics_are_those_of_their_parts():
    embedding = embed(sample_graph(), Environment(Grid((16, 16, 8), 0.25), np.zeros((64, 64), dtype=bool)))
    found = finish(metrics_steps(embedding, np.random.default_rng(3), 20))
    values = dict(zip(*list(zip(*metrics_table(found).rows, strict=True))[:2], strict=True))
    assert values["environment coverage by position"] == environment_coverage(embedding).position_share
    assert (values["path efficiency, pairs of places"], values["path efficiency, goals"]) == (20, 4)
    assert 0 < values["path efficiency, mean"] <= 1 and values["path efficiency, standard error of the mean"] > 0
    waits = [wait.mean for wait in found.prompt if np.isfinite(wait.mean)]
    assert values["local maneuverability, mean over clips"] == pytest.approx(np.mean(waits))
    assert values["clips that can begin nowhere"] == len(found.prompt) - len(waits) == found.n_never
    by_clip = {row[0]: row[1:] for row in actions_table(found).rows}
    for action, area, wait in zip(found.actions.actions, found.actions.areas, found.prompt, strict=True):
        assert by_clip[action.name][0] == area and by_clip[action.name][2] == wait.mean
    assert len(found.describe()) == 6


@given(st.integers(0, 10**6), st.floats(0.1, 500.0))
def test_round_times_are_round_ascend_and_tell_places_apart(seed, scale):
    seconds = np.random.default_rng(seed).gamma(2.0, scale, (12, 12))
    times = round_times(np.where(seconds > 3 * scale, np.inf, seconds))
    assert list(times) == sorted(set(times)) and 1 <= len(times) <= 4
    assert all(float(f"{time:.2g}") == time for time in times)
    if len(times) == 4:
        within = [np.mean(seconds[seconds <= 3 * scale] <= time) for time in times]
        assert within == sorted(within) and within[0] < 0.5 < within[-1]


def test_no_time_at_all_still_makes_a_scale():
    assert round_times(np.full((2, 2), np.inf)) == (1.0,)
    assert round_times(np.zeros((2, 2))) == (0.5,)
