"""The reach of a repeated segment, as it grows in theory and on the grid (the paper's Fig. 4).

A footprint says where one step may end. After several steps the ends spread: in theory over a region that grows with
every edit; on the grid over whole cells and headings. If the grid is too coarse for the footprints, the second grows
faster or slower than the first, and the embedding promises too much or too little.
"""

import numpy as np

from ..environment.grid import Grid
from ..motion.graph import MotionSegment
from .footprint import FootprintSettings, footprints, path_length


def gridded_growth(segment: MotionSegment, grid: Grid, settings: FootprintSettings, n_steps: int) -> list[np.ndarray]:
    """Return the grid elements where 1, 2, ... ``n_steps`` repetitions of ``segment`` may end on open ground.

    Starts from cell (0, 0) with heading 0. Each entry is an (n, 3) int array of x, y (cells) and heading (index, not
    wrapped), sorted.
    """
    ends = footprints(segment, grid, settings)
    by_heading = [np.flatnonzero(ends.heading == k) for k in range(grid.n_headings)]
    here = np.zeros((1, 3), dtype=int)
    growth = []
    for _ in range(n_steps):
        there = []
        for k, chosen in enumerate(by_heading):
            standing = here[here[:, 2] % grid.n_headings == k]
            step = np.column_stack([ends.dx[chosen], ends.dy[chosen], ends.turn[chosen]])
            there.append((standing[:, None] + step[None]).reshape(-1, 3))
        here = np.unique(np.concatenate(there), axis=0)
        growth.append(here)
    return growth


def theoretical_growth(
    segment: MotionSegment, settings: FootprintSettings, n_steps: int, rng: np.random.Generator, n_samples: int
) -> np.ndarray:
    """Sample where 1, 2, ... ``n_steps`` repetitions of ``segment`` may end without a grid.

    Every step is edited at random, half of the samples to the limit, within the same footprint. Starts from the origin
    with heading 0.

    Returns
    -------
    (n_steps, n_samples, 3) float array of x, y (m) and heading (rad, not wrapped)
    """
    length = path_length(segment)
    radius = settings.position_base + settings.position_rate * length
    tolerance = settings.heading_base + settings.heading_rate * length
    here = np.zeros((n_samples, 3))
    growth = np.empty((n_steps, n_samples, 3))
    x, y, turn = segment.path[-1]
    extreme = rng.random(n_samples) < 0.5
    # Farthest goes who is always edited the same way and turns to the limit, to one side first and then to the other.
    habit_angle, habit_turn = rng.uniform(0, 2 * np.pi, n_samples), rng.choice([-1.0, 1.0], n_samples)
    turns_back = rng.integers(0, n_steps + 1, n_samples)
    for step in range(n_steps):
        size = np.where(extreme, 1.0, np.sqrt(rng.random(n_samples))) * radius
        angle = np.where(extreme, habit_angle, rng.uniform(0, 2 * np.pi, n_samples))
        habit = np.where(step < turns_back, habit_turn, -habit_turn)
        edit = np.where(extreme, habit, rng.uniform(-1, 1, n_samples)) * tolerance
        cosine, sine = np.cos(here[:, 2]), np.sin(here[:, 2])
        here = here + np.column_stack(
            [
                cosine * x - sine * y + size * np.cos(angle),
                sine * x + cosine * y + size * np.sin(angle),
                turn + edit,
            ]
        )
        growth[step] = here
    return growth
