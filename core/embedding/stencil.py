"""Stencils: the translation-invariant form of the embedding's links.

A link from (p, c) to (p', c') depends on where it starts only through what stands in its way. The whole embedding has
one stencil for each segment, start heading and element of the footprint: thousands, not millions.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..environment.grid import Grid
from ..motion.graph import MotionSegment
from .footprint import FootprintSettings, fewest_ends, footprints


@dataclass(frozen=True)
class Stencils:
    """All stencils of a motion graph on a grid, ordered by segment, heading, dx, dy, turn; all arrays have length K.

    Attributes
    ----------
    segment, heading : int arrays
        What is played, and the heading index that it starts from.
    dx, dy : int arrays
        Cells from the start to the destination.
    turn : int array
        Headings from the start to the destination, not wrapped.
    position_error : (K, 2) float array
        Metres, world frame: what the edit adds to the segment's own end position.
    heading_error : (K,) float array
        Radians: what the edit adds to the segment's own final heading.
    n_headings : int
    """

    segment: np.ndarray
    heading: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    turn: np.ndarray
    position_error: np.ndarray
    heading_error: np.ndarray
    n_headings: int

    def __len__(self) -> int:
        return len(self.segment)

    @property
    def destination_heading(self) -> np.ndarray:
        """(K,) heading index of the destination."""
        return (self.heading + self.turn) % self.n_headings


def build_stencils(segments: Sequence[MotionSegment], grid: Grid, settings: FootprintSettings) -> Stencils:
    """Return the stencils of all segments from all headings."""
    parts = [footprints(segment, grid, settings) for segment in segments]
    return Stencils(
        segment=np.repeat(np.arange(len(parts)), [len(part.dx) for part in parts]),
        heading=np.concatenate([part.heading for part in parts]),
        dx=np.concatenate([part.dx for part in parts]),
        dy=np.concatenate([part.dy for part in parts]),
        turn=np.concatenate([part.turn for part in parts]),
        position_error=np.concatenate([part.position_error for part in parts]),
        heading_error=np.concatenate([part.heading_error for part in parts]),
        n_headings=grid.n_headings,
    )


def fewest_stencils(segments: Sequence[MotionSegment], grid: Grid, settings: FootprintSettings) -> float:
    """Return a lower bound on the stencils that :func:`build_stencils` lays out; close where footprints are wide.

    Known without laying them out: limits far beyond any sense ask for more than there is room for.
    """
    return float(sum(fewest_ends(segment, grid, settings) for segment in segments))
