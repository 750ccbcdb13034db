"""One-step unrolling: for every stencil, the plane of start cells from which its edited path is free."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION
from ..motion.graph import MotionSegment
from ..progress import Progress
from .bitplane import PlaneLayout
from .stencil import Stencils, SweptSamples, swept_samples, tag_classes


@dataclass(frozen=True)
class Unrolling:
    """All one-step links of the embedding, free of obstacles and allowed by the regions.

    Attributes
    ----------
    layout : PlaneLayout
    stencils : Stencils
    valid : tuple of K int
        For each stencil the bit-plane of the start cells from which it may be played.
    """

    layout: PlaneLayout
    stencils: Stencils
    valid: tuple[int, ...]


def unroll_steps(
    segments: Sequence[MotionSegment], stencils: Stencils, environment: Environment
) -> Generator[Progress, None, Unrolling]:
    """Check every stencil against the environment; yields progress, returns the :class:`Unrolling`."""
    grid = environment.grid
    classes, frame_classes = tag_classes(segments, environment.tags)
    first = np.searchsorted(stencils.segment, np.arange(len(segments) + 1))
    swept = []
    for index, segment in enumerate(segments):
        yield Progress(0.4 * index / len(segments), "Sweeping paths")
        chosen = np.arange(first[index], first[index + 1])
        if len(chosen):
            swept.append(swept_samples(stencils, chosen, segment, frame_classes[index], grid))

    layout = PlaneLayout(
        grid.shape[0],
        grid.shape[1],
        max((int(np.abs(s.x // SUBDIVISION).max()) for s in swept), default=0),
        max((int(np.abs(s.y // SUBDIVISION).max()) for s in swept), default=0),
        grid.tiled,
    )
    spaces = [_FreeSpace(environment.free_samples(tags), layout) for tags in classes]
    valid = [0] * len(stencils)
    for done, samples in enumerate(swept):
        yield Progress(0.4 + 0.6 * done / len(swept), "Checking paths")
        _check(samples, spaces, layout, valid)
    return Unrolling(layout, stencils, tuple(valid))


class _FreeSpace:
    """Planes of the cells in which a given part of the cell is free.

    A part is a set of samples, as bits of an integer: a path passes through a cell in one of a few hundred ways, over
    and over again, and each needs to be looked up only once.
    """

    def __init__(self, free: np.ndarray, layout: PlaneLayout):
        self._sample = [
            layout.extend(layout.pack(free[x::SUBDIVISION, y::SUBDIVISION]))
            for x in range(SUBDIVISION)
            for y in range(SUBDIVISION)
        ]
        self._part: dict[int, int] = {}

    def plane(self, part: int) -> int:
        plane = self._part.get(part)
        if plane is None:
            plane = -1
            for sample, space in enumerate(self._sample):
                if part >> sample & 1:
                    plane &= space
            self._part[part] = plane
        return plane


def _check(samples: SweptSamples, spaces: list[_FreeSpace], layout: PlaneLayout, valid: list[int]) -> None:
    """Set ``valid`` for the stencils of ``samples``: an AND of free-space planes, one for each cell on the way."""
    keys = np.stack([samples.stencil, samples.tag_class, samples.x // SUBDIVISION, samples.y // SUBDIVISION])
    bit = 1 << ((samples.x % SUBDIVISION) * SUBDIVISION + samples.y % SUBDIVISION)
    order = np.lexsort(keys[::-1])
    keys = keys[:, order]
    first = np.flatnonzero(np.append(True, np.any(np.diff(keys, axis=1) != 0, axis=0)))
    part = np.bitwise_or.reduceat(bit[order], first).tolist()
    stencil, tag_class, cell_x, cell_y = keys[:, first]
    shift = layout.shift(cell_x, cell_y).tolist()
    bounds = [*np.flatnonzero(np.diff(stencil, prepend=-1)).tolist(), len(stencil)]
    space_of = [spaces[c] for c in tag_class.tolist()]
    for start, stop in pairwise(bounds):
        plane = layout.ground
        for i in range(start, stop):
            space, moved = space_of[i].plane(part[i]), shift[i]
            plane &= space >> moved if moved >= 0 else space << -moved
            if not plane:
                break
        valid[stencil[start]] = plane
