"""Footprints: where a segment, played from a grid element, may end after an acceptable edit (paper, section 3)."""

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..environment.grid import Grid
from ..errors import EmbeddingError
from ..motion.graph import MotionSegment

#: A segment that travels less than this (m) counts as standing: its edits are spread over time, not distance.
STANDING_LENGTH = 0.05


class FootprintRule(Enum):
    """The grid elements that a footprint holds."""

    SNAP = "snap"
    CONSERVATIVE = "conservative"


@dataclass(frozen=True)
class FootprintSettings:
    """Limits of acceptable edits: they grow linearly with the length of the path.

    Attributes
    ----------
    position_base, position_rate : float
        A segment of path length s (m) may end within ``position_base + position_rate * s`` metres of its own end.
    heading_base, heading_rate : float
        Likewise its final heading may change by ``heading_base + heading_rate * s`` radians.
    rule : FootprintRule
        SNAP always adds the nearest cell and the nearest heading (the paper's choice); CONSERVATIVE does not.
    """

    position_base: float = 0.0
    position_rate: float = 0.08
    heading_base: float = 0.0
    heading_rate: float = 0.08
    rule: FootprintRule = FootprintRule.SNAP

    def __post_init__(self):
        limits = (self.position_base, self.position_rate, self.heading_base, self.heading_rate)
        if not all(np.isfinite(limit) and limit >= 0 for limit in limits):
            raise EmbeddingError(f"The limits of a footprint are {limits}; all must be zero or more.")


@dataclass(frozen=True)
class Footprints:
    """The footprints of one segment from every heading, relative to the start cell; all arrays have length n.

    Ordered by heading, dx, dy, turn.

    Attributes
    ----------
    heading : int array
        Heading index at the start.
    dx, dy : int arrays
        Cells from the start to the destination.
    turn : int array
        Headings from the start to the destination, not wrapped: a full turn counts n_headings.
    position_error : (n, 2) float array
        Metres, world frame: destination minus the segment's own end.
    heading_error : (n,) float array
        Radians: destination heading minus the segment's own final heading.
    """

    heading: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    turn: np.ndarray
    position_error: np.ndarray
    heading_error: np.ndarray


def path_length(segment: MotionSegment) -> float:
    """Return the metres that the root travels on the ground during the segment."""
    return float(np.linalg.norm(np.diff(segment.path[:, :2], axis=0), axis=1).sum())


def edit_profile(segment: MotionSegment) -> np.ndarray:
    """Return (F,) share of the edit that is done by each frame, from 0 to 1.

    In proportion to the distance travelled, so that a standing character does not slide; in proportion to time
    where the segment does not travel.
    """
    steps = np.linalg.norm(np.diff(segment.path[:, :2], axis=0), axis=1)
    if steps.sum() < STANDING_LENGTH:
        return np.linspace(0.0, 1.0, len(segment.path))
    profile = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    profile[-1] = 1.0
    return profile


def rotated_path(segment: MotionSegment, angle) -> np.ndarray:
    """x, y in metres of the segment's own path, started at the origin with heading ``angle`` (rad).

    (F, 2) for one angle, (n, F, 2) for an array of n.
    """
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    x, y = segment.path[:, 0], segment.path[:, 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def fewest_ends(segment: MotionSegment, grid: Grid, settings: FootprintSettings) -> float:
    """Return a lower bound on the ends of a segment's footprints, over all headings; close where they are wide."""
    n_turns = len(_turns(segment, grid, settings)[0])
    if n_turns == 0:
        return 0.0
    # Around their centres, cells cover a disc that is smaller than the footprint by half their diagonal.
    radius = float((settings.position_base + settings.position_rate * path_length(segment)) / grid.cell_size)
    covered = max(radius - 0.5**0.5, 0.0)
    return grid.n_headings * n_turns * math.pi * covered * covered


def footprints(segment: MotionSegment, grid: Grid, settings: FootprintSettings) -> Footprints:
    """Return the footprints of ``segment`` from all headings.

    Under SNAP each holds the nearest cell and the nearest heading, whatever the limits.
    """
    turns, turn_error = _turns(segment, grid, settings)
    radius = settings.position_base + settings.position_rate * path_length(segment)
    ends = rotated_path(segment, np.arange(grid.n_headings) * grid.heading_step)[:, -1]
    nearest = np.floor(ends / grid.cell_size + 0.5).astype(int)
    span = int(np.ceil(radius / grid.cell_size)) if len(turns) else 0
    around = np.arange(-span, span + 1)
    cells = nearest[:, None] + np.stack(np.meshgrid(around, around, indexing="ij"), axis=-1).reshape(-1, 2)
    error = cells * grid.cell_size - ends[:, None]
    kept = np.hypot(error[..., 0], error[..., 1]) <= radius
    if settings.rule is FootprintRule.SNAP:
        kept[:, len(around) * span + span] = True
    heading, cell = (np.repeat(index, len(turns)) for index in np.nonzero(kept))
    which = np.tile(np.arange(len(turns)), np.count_nonzero(kept))
    return Footprints(
        heading=heading,
        dx=cells[heading, cell, 0],
        dy=cells[heading, cell, 1],
        turn=turns[which],
        position_error=error[heading, cell],
        heading_error=turn_error[which],
    )


def _turns(segment: MotionSegment, grid: Grid, settings: FootprintSettings) -> tuple[np.ndarray, np.ndarray]:
    """Return (n,) turns, in headings from start to destination, that the limits allow, and their errors in radians."""
    turn = float(segment.path[-1, 2])
    tolerance = settings.heading_base + settings.heading_rate * path_length(segment)
    nearest_turn = int(np.floor(turn / grid.heading_step + 0.5))
    span = int(min(np.ceil(tolerance / grid.heading_step), grid.n_headings // 2))
    turns = np.arange(nearest_turn - span, nearest_turn + span + 1)
    turn_error = turns * grid.heading_step - turn
    close = np.abs(turn_error) <= tolerance
    if settings.rule is FootprintRule.SNAP:
        close[span] = True
    if len(turns) > grid.n_headings and close[0] and close[-1]:
        # Half a turn to either side is the same heading: the smaller edit leads there.
        close[0 if abs(turn_error[0]) > abs(turn_error[-1]) else -1] = False
    return turns[close], turn_error[close]


def edited_path(
    segment: MotionSegment, heading: int, grid: Grid, position_error: np.ndarray, heading_error: float
) -> np.ndarray:
    """(F, 3) x, y (m) and heading (rad): the segment edited to reach its destination, relative to the start position.

    The heading is absolute and not wrapped: it starts at heading * heading_step.
    """
    angle = heading * grid.heading_step
    profile = edit_profile(segment)
    positions = rotated_path(segment, angle) + profile[:, None] * position_error
    return np.column_stack([positions, angle + segment.path[:, 2] + profile * heading_error])
