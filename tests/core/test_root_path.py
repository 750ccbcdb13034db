"""The root path that is played: smooth, near the walk's own, and as far from obstacles as that one is."""

from functools import cache

import numpy as np
import pytest

from core.embedding.embedding import embed
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.playback.root_path import played_root_path
from core.playback.transitions import transition_gaps
from core.playback.walk import Walk, WalkSettings, random_walk_steps
from core.progress import finish

from .geometry import box_triangles
from .motion_graphs import sample_graph

TOLERANCE = 0.01


BOXES = np.random.default_rng(2).uniform(0.3, 4.7, (9, 2)).tolist()


@cache
def ground(boxes=(), tiled=False):
    grid = Grid.over_rectangle((0, 0), (5, 5), 0.125, 24, tiled)
    triangles = [box_triangles((x - 0.17, y - 0.21, 0.0), (x + 0.13, y + 0.19, 1.5)) for x, y in boxes]
    environment = build_environment(grid, np.concatenate([np.empty((0, 3, 3)), *triangles]))
    return embed(sample_graph(), environment)


def walks(embedding):
    for seed in range(8):
        yield finish(random_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(60.0)))


def played(walk, tolerance=TOLERANCE):
    gaps = transition_gaps(walk)
    half = np.diff(walk.node_frames) // 2
    return played_root_path(walk, gaps, np.column_stack([half[gaps.before], half[gaps.after]]), tolerance)


def samples(walk, path):
    grid = walk.embedding.environment.grid
    return np.floor((path[:, :2] - grid.origin) / grid.sample_size).astype(int)


@pytest.mark.parametrize("tiled", [False, True])
def test_what_was_checked_is_what_is_played(tiled):
    among, without = ground(tuple(map(tuple, BOXES)), tiled), ground((), tiled)
    blocked = among.environment.blocked
    size = np.array(blocked.shape)
    astray = 0
    for walk in walks(among):
        path = played(walk)
        places = samples(walk, path)
        if not tiled:
            assert np.all((places >= 0) & (places < size))
        assert not blocked[tuple((places % size).T)].any()
        # The same links where nothing stands in the way are smoothed everywhere.
        smooth = played(Walk(without, walk.states, walk.stencils))
        astray += blocked[tuple((samples(walk, smooth) % size).T)].sum()
        same = np.all(path == smooth, axis=1)
        assert same.mean() > 0.8 and np.all(same | np.all(path == walk.root_path, axis=1))
    assert astray > 0


def test_jolts_are_smoothed_near_the_path():
    walk = next(walks(ground()))
    path, seams = played(walk), walk.node_frames[1:-1]
    away = np.linalg.norm(path[:, :2] - walk.root_path[:, :2], axis=1)
    assert 0 < away.max() <= TOLERANCE + 1e-12
    assert away[walk.node_frames].max() == 0
    before, after = (
        np.linalg.norm(p[seams + 1, :2] - 2 * p[seams, :2] + p[seams - 1, :2], axis=1) for p in (walk.root_path, path)
    )
    assert np.median(after) < 0.7 * np.median(before)
    assert np.array_equal(played(walk, 0.0), walk.root_path)
