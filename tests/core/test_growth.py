"""Growth of repeated footprints, in theory and on the grid."""

import numpy as np
import pytest

from core.embedding.footprint import FootprintRule, FootprintSettings, footprints
from core.embedding.growth import gridded_growth, theoretical_growth
from core.environment.grid import Grid
from core.motion.graph import MotionSegment

N_STEPS = 4


def segment(turn):
    t = np.linspace(0, 1, 25)
    heading = turn * t
    xy = np.concatenate([[[0, 0]], np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)])[:-1], axis=0) / 24])
    return MotionSegment("arc", 0, 0, 24, np.column_stack([xy, heading]), 0.8, {})


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_growth_is_the_footprint_applied_again_and_again(turn):
    """Against sets of tuples, one by one."""
    grid, settings = Grid((1, 1, 24), 0.125), FootprintSettings(0.02, 0.1, 0.05, 0.1)
    ends = footprints(segment(turn), grid, settings)
    steps = list(zip(*(a.tolist() for a in (ends.heading, ends.dx, ends.dy, ends.turn)), strict=True))
    here = {(0, 0, 0)}
    for grown in gridded_growth(segment(turn), grid, settings, N_STEPS):
        here = {(x + dx, y + dy, h + t) for x, y, h in here for k, dx, dy, t in steps if h % 24 == k}
        assert set(map(tuple, grown.tolist())) == here


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_a_conservative_grid_stays_within_the_theory(turn):
    """Every element that conservative footprints reach has theoretical ends within a cell and a heading of it."""
    grid = Grid((1, 1, 48), 0.05)
    settings = FootprintSettings(0.02, 0.15, 0.05, 0.15, FootprintRule.CONSERVATIVE)
    theory = theoretical_growth(segment(turn), settings, N_STEPS, np.random.default_rng(0), 40_000)
    for step, grown in enumerate(gridded_growth(segment(turn), grid, settings, N_STEPS)):
        assert len(grown) > 10
        low, high = theory[step].min(axis=0), theory[step].max(axis=0)
        ends = grown * [grid.cell_size, grid.cell_size, grid.heading_step]
        slack = [grid.cell_size, grid.cell_size, grid.heading_step]
        assert np.all(ends >= low - slack)
        assert np.all(ends <= high + slack)


def test_theory_keeps_to_the_limits_of_one_step():
    settings = FootprintSettings(0.02, 0.1, 0.05, 0.1)
    ends = theoretical_growth(segment(0.6), settings, 1, np.random.default_rng(0), 5000)[0]
    away = np.linalg.norm(ends[:, :2] - segment(0.6).path[-1, :2], axis=1)
    assert away.max() <= 0.12 + 1e-6
    assert away.max() > 0.115
    assert np.abs(ends[:, 2] - 0.6).max() == pytest.approx(0.15, abs=1e-3)
