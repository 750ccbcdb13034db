"""Footprints: where a segment, played from a grid element, may end after an acceptable edit (paper, section 3)."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..environment.grid import Grid
from ..motion.graph import MotionSegment

#: A segment that travels less than this (m) counts as standing: its edits are spread over time, not distance.
STANDING_LENGTH = 0.05


class FootprintRule(Enum):
    """Which grid elements a footprint holds."""

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


@dataclass(frozen=True)
class Footprint:
    """The footprint of one segment from one heading, relative to the start cell; all arrays have length n.

    Attributes
    ----------
    dx, dy : int arrays
        Cells from the start to the destination.
    turn : int array
        Headings from the start to the destination, not wrapped: a full turn counts n_headings.
    position_error : (n, 2) float array
        Metres, world frame: destination minus the segment's own end.
    heading_error : (n,) float array
        Radians: destination heading minus the segment's own final heading.
    """

    dx: np.ndarray
    dy: np.ndarray
    turn: np.ndarray
    position_error: np.ndarray
    heading_error: np.ndarray


def path_length(segment: MotionSegment) -> float:
    """Metres that the root travels on the ground during the segment."""
    return float(np.linalg.norm(np.diff(segment.path[:, :2], axis=0), axis=1).sum())


def edit_profile(segment: MotionSegment) -> np.ndarray:
    """(F,) share of the edit that is done by each frame, from 0 to 1.

    In proportion to the distance travelled, so that a standing character does not slide; in proportion to time
    where the segment does not travel.
    """
    steps = np.linalg.norm(np.diff(segment.path[:, :2], axis=0), axis=1)
    if steps.sum() < STANDING_LENGTH:
        return np.linspace(0.0, 1.0, len(segment.path))
    profile = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    profile[-1] = 1.0
    return profile


def rotated_path(segment: MotionSegment, angle: float) -> np.ndarray:
    """(F, 2) x, y in metres of the segment's own path, started at the origin with heading ``angle``."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return segment.path[:, :2] @ np.array([[cosine, sine], [-sine, cosine]])


def footprint(segment: MotionSegment, heading: int, grid: Grid, settings: FootprintSettings) -> Footprint:
    """The footprint of ``segment`` played from heading index ``heading``.

    Destinations are ordered by dx, dy, turn. Under SNAP the nearest cell and heading are always among them.
    """
    length = path_length(segment)
    end = rotated_path(segment, heading * grid.heading_step)[-1]
    snap = settings.rule is FootprintRule.SNAP

    radius = settings.position_base + settings.position_rate * length
    nearest = np.floor(end / grid.cell_size + 0.5).astype(int)
    span = int(np.ceil(radius / grid.cell_size))
    around = np.arange(-span, span + 1)
    cells = nearest + np.stack(np.meshgrid(around, around, indexing="ij"), axis=-1).reshape(-1, 2)
    error = cells * grid.cell_size - end
    kept = np.hypot(error[:, 0], error[:, 1]) <= radius
    if snap:
        kept |= np.all(cells == nearest, axis=1)
    cells, error = cells[kept], error[kept]

    turn = float(segment.path[-1, 2])
    tolerance = settings.heading_base + settings.heading_rate * length
    nearest_turn = int(np.floor(turn / grid.heading_step + 0.5))
    span = int(np.ceil(tolerance / grid.heading_step))
    # More than all headings would hold some of them twice.
    below, above = min(span, (grid.n_headings - 1) // 2), min(span, grid.n_headings // 2)
    turns = np.arange(nearest_turn - below, nearest_turn + above + 1)
    turn_error = turns * grid.heading_step - turn
    kept = np.abs(turn_error) <= tolerance
    if snap:
        kept |= turns == nearest_turn
    turns, turn_error = turns[kept], turn_error[kept]

    return Footprint(
        dx=np.repeat(cells[:, 0], len(turns)),
        dy=np.repeat(cells[:, 1], len(turns)),
        turn=np.tile(turns, len(cells)),
        position_error=np.repeat(error, len(turns), axis=0),
        heading_error=np.tile(turn_error, len(cells)),
    )


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
