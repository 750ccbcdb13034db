"""Stencils: the translation-invariant form of the embedding's links.

A link from (p, c) to (p', c') depends on where it starts only through what stands in its way. The whole embedding has
one stencil for each segment, start heading and element of the footprint: thousands, not millions.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..environment.grid import SUBDIVISION, Grid
from ..motion.graph import MotionSegment
from .footprint import FootprintSettings, edit_profile, footprints, rotated_path


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
    """The stencils of all segments from all headings."""
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


@dataclass(frozen=True)
class SweptSamples:
    """Samples that the edited paths of some stencils pass through, relative to the start cell; all of length n.

    Attributes
    ----------
    stencil : int array
        Index into the stencils; ascending.
    tag_class : int array
        Index of the set of tags that the frames carry that are played there.
    x, y : int arrays
        Samples from the start cell's corner: (0, 0) to (3, 3) is the start cell itself.
    """

    stencil: np.ndarray
    tag_class: np.ndarray
    x: np.ndarray
    y: np.ndarray


def tag_classes(
    segments: Sequence[MotionSegment], tags: frozenset[str]
) -> tuple[list[frozenset[str]], list[np.ndarray]]:
    """The different sets of ``tags`` that frames carry, and for each segment the (F,) class of its frames."""
    classes: dict[frozenset[str], int] = {frozenset(): 0}
    of_frames = []
    for segment in segments:
        spoken = [tag for tag in sorted(segment.tags) if tag in tags]
        frames = np.zeros(segment.n_frames, dtype=int)
        if spoken:
            masks = np.array([segment.tags[tag] for tag in spoken])
            for column in np.unique(masks, axis=1).T:
                members = frozenset(tag for tag, on in zip(spoken, column, strict=True) if on)
                index = classes.setdefault(members, len(classes))
                frames[np.all(masks == column[:, None], axis=0)] = index
        of_frames.append(frames)
    return list(classes), of_frames


def swept_samples(
    stencils: Stencils, chosen: np.ndarray, segment: MotionSegment, frame_class: np.ndarray, grid: Grid
) -> SweptSamples:
    """Every sample that the edited paths of the ``chosen`` stencils, all of ``segment``, pass through.

    A path is the polyline through the root's positions. Each of its pieces is cut where it crosses a border between
    samples, so that none is missed however fast the character moves; a piece counts for the classes of both frames.
    """
    profile = edit_profile(segment)
    headings, which = np.unique(stencils.heading[chosen], return_inverse=True)
    paths = np.stack([rotated_path(segment, k * grid.heading_step) for k in headings])[which]
    paths = paths + profile[:, None] * stencils.position_error[chosen][:, None, :]
    middle = SUBDIVISION / 2
    points = paths / grid.sample_size + middle
    points[:, -1] = np.column_stack([stencils.dx[chosen], stencils.dy[chosen]]) * SUBDIVISION + middle

    a, b = points[:, :-1], points[:, 1:]
    crossings = [np.zeros(a.shape[:2])[..., None]]
    for axis in (0, 1):
        low = np.floor(np.minimum(a[..., axis], b[..., axis]))
        n_lines = (np.floor(np.maximum(a[..., axis], b[..., axis])) - low).astype(int)
        line = np.arange(n_lines.max(initial=0))
        run = b[..., axis] - a[..., axis]
        at = np.divide(
            (low - a[..., axis])[..., None] + 1 + line,
            run[..., None],
            out=np.ones((*run.shape, len(line))),
            where=line < n_lines[..., None],
        )
        crossings.append(at)
    crossings.append(np.ones(a.shape[:2])[..., None])
    cuts = np.sort(np.concatenate(crossings, axis=-1), axis=-1)
    between = (cuts[..., :-1] + cuts[..., 1:]) / 2
    inside = np.floor(a[..., None, :] + between[..., None] * (b - a)[..., None, :]).astype(int)

    crossed = cuts[..., 1:] > cuts[..., :-1]
    stencil, piece, _ = np.nonzero(crossed)
    inside = inside[crossed]
    found = [
        np.column_stack([stencil, classes[piece], inside])
        for classes in ([frame_class] if np.all(frame_class == frame_class[0]) else [frame_class, frame_class[1:]])
    ]
    # The ends lie on the corner of four samples; naming one of them makes "the centre is free" part of the check.
    for frame in (0, -1):
        corner = np.floor(points[:, frame]).astype(int)
        ends = np.column_stack([np.arange(len(chosen)), np.full(len(chosen), frame_class[frame]), corner])
        found.append(ends)
    rows = np.concatenate(found)

    low = rows.min(axis=0)
    span = rows.max(axis=0) - low + 1
    keys = np.unique(np.ravel_multi_index((rows - low).T, span))
    stencil, tag_class, x, y = np.array(np.unravel_index(keys, span)) + low[:, None]
    return SweptSamples(chosen[stencil], tag_class, x, y)
