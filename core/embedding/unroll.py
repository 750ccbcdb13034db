"""One-step unrolling: for every stencil, the plane of start cells from which its edited path is free."""

from collections.abc import Generator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION
from ..progress import Progress
from .bitplane import PlaneLayout
from .stencil import Stencils
from .sweep import Sweep

#: Paths between two reports of progress.
REPORTED_PATHS = 500


@dataclass(frozen=True)
class Unrolling:
    """All one-step links of the embedding, free of obstacles and allowed by the regions.

    Attributes
    ----------
    sweep : Sweep
    valid : tuple of K int
        For each stencil the bit-plane of the start cells from which it may be played.
    """

    sweep: Sweep
    valid: tuple[int, ...]

    @property
    def layout(self) -> PlaneLayout:
        return self.sweep.layout

    @property
    def stencils(self) -> Stencils:
        return self.sweep.stencils


def unroll_steps(sweep: Sweep, environment: Environment) -> Generator[Progress, None, Unrolling]:
    """Check every stencil against the environment; yields progress, returns the :class:`Unrolling`.

    One AND of a free-space plane for each cell on the way answers for all start cells at once.
    """
    layout = sweep.layout
    spaces = [_FreeSpace(environment.free_samples(tags), layout) for tags in sweep.classes]
    tag_class, part, shift, bounds = sweep.tag_class, sweep.part, sweep.shift, sweep.bounds
    free = []
    for path, (start, stop) in enumerate(pairwise(bounds)):
        if path % REPORTED_PATHS == 0:
            yield Progress(path / len(bounds), "Checking paths")
        plane = layout.ground
        for i in range(start, stop):
            space, moved = spaces[tag_class[i]].plane(part[i]), shift[i]
            plane &= space >> moved if moved >= 0 else space << -moved
            if not plane:
                break
        free.append(plane)
    return Unrolling(sweep, tuple(free[path] for path in sweep.path))


class _FreeSpace:
    """Planes of the cells in which a given part of the cell is free.

    A path passes through a cell in one of a few hundred ways, over and over again: each is looked up only once.
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
