"""Sweeping: the samples that each stencil's edited path passes through, whatever stands in the scene.

A sweep depends on the motion graph, the grid and the footprints, but on no obstacle: it is kept when obstacles move.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from ..environment.grid import SUBDIVISION, Grid
from ..motion.graph import MotionSegment
from ..progress import Progress
from .bitplane import PlaneLayout
from .footprint import edit_profile, rotated_path
from .stencil import Stencils

#: Pieces of paths (from one frame to the next) that are swept together: some 50 MB.
PIECES_AT_ONCE = 200_000


@dataclass(frozen=True)
class Sweep:
    """The samples that must be free for each stencil, cell by cell along its path.

    Stencils that differ only in their final heading share a path, ``path[k]``. Check i, for ``bounds[p] <= i <
    bounds[p + 1]``, belongs to path p: of the cell that lies ``shift[i]`` bits after the start cell, the samples of
    ``part[i]`` must be free for frames of class ``tag_class[i]``.

    Attributes
    ----------
    stencils : Stencils
    layout : PlaneLayout
    classes : tuple of frozenset of str
        The different sets of tags that frames carry, of those that the regions speak of.
    path : (K,) list of int
    bounds : list of int, one more than there are paths
    tag_class, part, shift : lists of int
        A part is a set of samples of a cell: bit SUBDIVISION * x + y stands for the sample (x, y) of the cell.
    """

    stencils: Stencils
    layout: PlaneLayout
    classes: tuple[frozenset[str], ...]
    path: list[int]
    bounds: list[int]
    tag_class: list[int]
    part: list[int]
    shift: list[int]


def sweep_steps(
    segments: Sequence[MotionSegment], stencils: Stencils, grid: Grid, tags: frozenset[str]
) -> Generator[Progress, None, Sweep]:
    """Sweep all stencils of ``segments``; ``tags`` are those that make a difference. Yields progress."""
    classes, frame_classes = tag_classes(segments, tags)
    # Stencils of one path follow one another: they are ordered by segment, heading, dx, dy, and only then by turn.
    place = np.stack([stencils.segment, stencils.heading, stencils.dx, stencils.dy])
    new = np.append(True, np.any(np.diff(place, axis=1) != 0, axis=0))[: len(stencils)]
    leaders = np.flatnonzero(new)
    lengths = np.array([segment.n_frames for segment in segments])
    batch = np.cumsum(lengths[stencils.segment[leaders]]) // PIECES_AT_ONCE
    batches = np.split(leaders, np.flatnonzero(np.diff(batch)) + 1) if len(leaders) else []
    parts = []
    for index, chosen in enumerate(batches):
        yield Progress(index / len(batches), "Sweeping paths")
        parts.append(_by_cell(swept_samples(stencils, chosen, segments, frame_classes, grid)))
    stencil, tag_class, cell_x, cell_y, part = np.concatenate([np.empty((5, 0), dtype=int), *parts], axis=1)
    layout = PlaneLayout(
        grid.shape[0],
        grid.shape[1],
        int(np.abs(cell_x).max(initial=0)),
        int(np.abs(cell_y).max(initial=0)),
        grid.tiled,
    )
    return Sweep(
        stencils=stencils,
        layout=layout,
        classes=tuple(classes),
        path=(np.cumsum(new) - 1).tolist(),
        bounds=np.searchsorted(stencil, np.append(leaders, len(stencils))).tolist(),
        tag_class=tag_class.tolist(),
        part=part.tolist(),
        shift=layout.shift(cell_x, cell_y).tolist(),
    )


@dataclass(frozen=True)
class SweptSamples:
    """Samples that the edited paths of some stencils pass through, relative to the start cell; all of length n.

    In no order; what a path passes through more than once, it may name more than once.

    Attributes
    ----------
    stencil : int array
        Index into the stencils.
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
    """Return the different sets of ``tags`` that frames carry, and for each segment the (F,) class of its frames."""
    classes: dict[frozenset[str], int] = {}
    of_frames = []
    for segment in segments:
        spoken = [tag for tag in sorted(segment.tags) if tag in tags]
        masks = np.array([segment.tags[tag] for tag in spoken], dtype=bool).reshape(len(spoken), segment.n_frames)
        frames = np.zeros(segment.n_frames, dtype=int)
        for column in np.unique(masks, axis=1).T if spoken else np.zeros((1, 0), dtype=bool):
            members = frozenset(tag for tag, on in zip(spoken, column, strict=True) if on)
            frames[np.all(masks == column[:, None], axis=0)] = classes.setdefault(members, len(classes))
        of_frames.append(frames)
    return list(classes), of_frames


def swept_samples(
    stencils: Stencils,
    chosen: np.ndarray,
    segments: Sequence[MotionSegment],
    frame_classes: Sequence[np.ndarray],
    grid: Grid,
) -> SweptSamples:
    """Return every sample that the edited paths of the ``chosen`` stencils, in ascending order, pass through.

    A path is the polyline through the root's positions. None of the samples that it crosses is missed, however fast
    the character moves. A piece counts for the classes of the frames at both of its ends.
    """
    named, crossing = [], []
    bounds = np.searchsorted(stencils.segment[chosen], np.arange(len(segments) + 1))
    for segment, frame_class, start, stop in zip(segments, frame_classes, bounds[:-1], bounds[1:], strict=True):
        if start == stop:
            continue
        stencil = chosen[start:stop]
        points = _edited_paths(stencils, stencil, segment, grid)
        sample = np.floor(points).astype(int)
        # Most pieces are far shorter than a sample: between points inside of the same sample, or of two that share a
        # side, a piece passes through no other.
        inside = (points[..., 0] != sample[..., 0]) & (points[..., 1] != sample[..., 1])
        steps = np.abs(sample[:, 1:] - sample[:, :-1])
        steps = steps[..., 0] + steps[..., 1]
        k, piece = np.nonzero((steps > 1) | ~(inside[:, :-1] & inside[:, 1:]))
        pieces = stencil[k], points[k, piece], points[k, piece + 1]
        # The ends lie on the corner of four samples; naming one of them makes "the centre is free" part of the check.
        named += [(stencil, np.full(len(stencil), frame_class[end]), sample[:, end]) for end in (0, -1)]
        if np.all(frame_class == frame_class[0]):
            crossing.append((*pieces, frame_class[piece]))
            # A path names the samples that it enters.
            inside[:, 1:] &= (steps > 0) | ~inside[:, :-1]
            k, frame = np.nonzero(inside)
            named.append((stencil[k], frame_class[frame], sample[k, frame]))
        else:
            crossing += [(*pieces, frame_class[piece + end]) for end in (0, 1)]
            k, frame = np.nonzero(inside)
            for neighbour in (-1, 0, 1):
                near = np.clip(frame + neighbour, 0, segment.n_frames - 1)
                named.append((stencil[k], frame_class[near], sample[k, frame]))
    stencil, a, b, tag_class = (np.concatenate(column) for column in zip(*crossing, strict=True))
    piece, crossed = _crossed_samples(a, b)
    named.append((stencil[piece], tag_class[piece], crossed))
    stencil, tag_class, sample = (np.concatenate(column) for column in zip(*named, strict=True))
    return SweptSamples(stencil, tag_class, sample[:, 0], sample[:, 1])


def _edited_paths(stencils: Stencils, chosen: np.ndarray, segment: MotionSegment, grid: Grid) -> np.ndarray:
    """(n, F, 2) in samples from the start cell's corner: the root's paths of ``chosen`` stencils of one segment."""
    paths = rotated_path(segment, np.arange(grid.n_headings) * grid.heading_step)[stencils.heading[chosen]]
    paths = paths + edit_profile(segment)[:, None] * stencils.position_error[chosen][:, None, :]
    middle = SUBDIVISION / 2
    points = paths / grid.sample_size + middle
    points[:, -1, 0] = stencils.dx[chosen] * SUBDIVISION + middle
    points[:, -1, 1] = stencils.dy[chosen] * SUBDIVISION + middle
    return points


def _crossed_samples(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The samples that straight pieces from ``a`` to ``b``, (n, 2) in samples, pass through: (m,) piece, (m, 2) sample.

    Each piece is cut where it crosses a border between samples, so that none is missed however long it is.
    """
    cuts = [np.zeros((len(a), 1))]
    for axis in (0, 1):
        low = np.floor(np.minimum(a[:, axis], b[:, axis]))
        n_lines = (np.floor(np.maximum(a[:, axis], b[:, axis])) - low).astype(int)
        line = np.arange(n_lines.max(initial=0))
        run = b[:, axis] - a[:, axis]
        at = np.divide(
            (low - a[:, axis])[:, None] + 1 + line,
            run[:, None],
            out=np.ones((len(run), len(line))),
            where=line < n_lines[:, None],
        )
        cuts.append(at)
    cuts.append(np.ones((len(a), 1)))
    cut = np.sort(np.concatenate(cuts, axis=1), axis=1)
    piece, gap = np.nonzero(cut[:, 1:] > cut[:, :-1])
    middle = (cut[piece, gap] + cut[piece, gap + 1]) / 2
    return piece, np.floor(a[piece] + middle[:, None] * (b - a)[piece]).astype(int)


def _by_cell(samples: SweptSamples) -> np.ndarray:
    """Return (5, n) rows: stencil, tag class, cell x, cell y and the part of that cell; ordered by the first four."""
    cells = np.stack([samples.stencil, samples.tag_class, samples.x // SUBDIVISION, samples.y // SUBDIVISION])
    bit = 1 << ((samples.x % SUBDIVISION) * SUBDIVISION + samples.y % SUBDIVISION)
    low = cells.min(axis=1, keepdims=True)
    # One number for a cell, in the order of the rows: numbers sort faster than rows.
    key = np.asarray(np.ravel_multi_index(tuple(cells - low), tuple(np.ptp(cells, axis=1) + 1)))
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    return np.vstack([cells[:, order[first]], np.bitwise_or.reduceat(bit[order], first)])
