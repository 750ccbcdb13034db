"""What obstacles leave on the samples of a ground, remembered, so that only what has moved is looked at again.

The samples that polygons touch add up by "or", and the faces over and under a sample add up as numbers: what single
parts of the scene leave, put together, is to the bit what all of it leaves at once.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from ..progress import Progress
from .grid import SUBDIVISION, Grid
from .obstacles import (
    clip_to_heights,
    faces_over_and_under,
    grown,
    margin_for,
    occupied_samples,
    solid_where,
)
from .pieces import Piece, all_triangles

#: Pieces that follow each other are looked at together until they have so many triangles.
_TRIANGLES_TOGETHER = 5_000

#: Triangles of one piece that are looked at in one step: a tenth of a second.
_TRIANGLES_AT_ONCE = 40_000

#: Samples of a ground up to which traces are kept; beyond, the memory would take more than the work is worth.
_MAX_SAMPLES = 2_000_000

#: Bytes that all traces may take.
_MAX_BYTES = 300_000_000


@dataclass(frozen=True)
class _Trace:
    """What some pieces leave.

    Attributes
    ----------
    occupied : (width + 2 margin, depth + 2 margin) bool array, or None if nothing is
    over, under : (width, depth) int array, or None if there are no such faces
        Faces over the head height and under the step height, up minus down.
    """

    occupied: np.ndarray | None
    over: np.ndarray | None
    under: np.ndarray | None

    @property
    def n_bytes(self) -> int:
        return sum(part.nbytes for part in (self.occupied, self.over, self.under) if part is not None)


class TraceMemory:
    """The traces that the pieces of a scene left when its obstacles were last rasterised."""

    def __init__(self):
        self._ground: tuple = ()
        self._traces: dict[tuple, _Trace] = {}

    def serves(self, grid: Grid) -> bool:
        """Whether traces on this ground are kept: not where they are large, nor where everything repeats."""
        return not grid.tiled and grid.shape[0] * grid.shape[1] * SUBDIVISION**2 <= _MAX_SAMPLES

    def blocked_steps(
        self, grid: Grid, pieces: Sequence[Piece], radius: float, low: float, high: float
    ) -> Generator[Progress, None, np.ndarray]:
        """(4 nx, 4 ny) bool: samples nearer than ``radius`` (m) to what the pieces have between the heights ``low`` and
        ``high`` (m), or inside of them.

        Raises SceneError for what :func:`.obstacles.clip_to_heights` and :func:`.obstacles.margin_for` do not accept.
        """
        margin = margin_for(grid, radius)
        ground = grid.shape[:2], grid.cell_size, grid.origin, margin, low, high
        # Whoever gives up on the way loses nothing: what is no longer there is forgotten at the end.
        known, used = (self._traces if ground == self._ground else {}), {}
        self._ground, self._traces = ground, known
        groups = _gathered(pieces)
        for number, together in enumerate(groups):
            key = tuple(piece.key for piece in together)
            if key not in known:
                known[key] = yield from _trace_steps(grid, together, margin, low, high, number / len(groups))
            used[key] = used.get(key, 0) + 1
        traces = [known[key] for key, n in used.items() for _ in range(n)]
        # Once more, because somebody else may have asked in the meantime.
        self._ground, self._traces, n_bytes = ground, {}, 0
        for key in used:
            n_bytes += known[key].n_bytes
            if n_bytes <= _MAX_BYTES:
                self._traces[key] = known[key]
        size = np.array(grid.shape[:2]) * SUBDIVISION
        total = _sum(traces)
        blocked = np.zeros(size, dtype=bool)
        if total.occupied is not None:
            blocked = grown(grid, total.occupied, margin, radius)
        if total.over is not None and total.under is not None:
            blocked |= solid_where(total.over, total.under)
        return blocked


def _gathered(pieces: Sequence[Piece]) -> list[list[Piece]]:
    """The pieces in groups that are large enough to be worth a trace."""
    groups, n_triangles = [], _TRIANGLES_TOGETHER
    for piece in pieces:
        n_here = len(piece.shape.triangles)
        if n_triangles + n_here > _TRIANGLES_TOGETHER:
            groups.append([])
            n_triangles = 0
        groups[-1].append(piece)
        n_triangles += n_here
    return groups


def _trace_steps(
    grid: Grid, pieces: Sequence[Piece], margin: int, low: float, high: float, done: float
) -> Generator[Progress, None, _Trace]:
    """The trace of some pieces, a bearable number of triangles at a time; ``done`` is the share of all work before."""
    triangles, total = all_triangles(pieces), _Trace(None, None, None)
    for start in range(0, len(triangles), _TRIANGLES_AT_ONCE):
        yield Progress(done, "Looking at the obstacles")
        part = triangles[start : start + _TRIANGLES_AT_ONCE]
        occupied = occupied_samples(grid, clip_to_heights(part, low, high), margin)
        over, under = faces_over_and_under(grid, part, low, high)
        total = _sum([total, _Trace(occupied if occupied.any() else None, _small(over), _small(under))])
    return _Trace(total.occupied, _small(total.over), _small(total.under))


def _sum(traces: Sequence[_Trace]) -> _Trace:
    """What all of them leave."""
    occupied = [trace.occupied for trace in traces if trace.occupied is not None]
    return _Trace(
        reduce(np.logical_or, occupied) if occupied else None,
        _total([trace.over for trace in traces]),
        _total([trace.under for trace in traces]),
    )


def _small(counts: np.ndarray | None) -> np.ndarray | None:
    """The same numbers in as few bytes as they need."""
    if counts is None or not counts.any():
        return None
    return counts.astype(np.min_scalar_type(-1 - max(int(counts.max()), -int(counts.min()))))


def _total(parts: Sequence[np.ndarray | None]) -> np.ndarray | None:
    present = [part for part in parts if part is not None]
    if not present:
        return None
    total = np.zeros(present[0].shape, dtype=np.int32)
    for part in present:
        total += part
    return total
