"""Masks of obstacles on the samples of a ground, cached, so that only what has moved is rasterised again.

The samples that polygons touch add up by "or", and the faces over and under a sample add up as numbers: what single
parts of the scene leave, put together, is to the bit what all of it leaves at once.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

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
from .pieces import Piece, solid_triangles
from .regions import samples_inside

#: Pieces that follow each other are looked at together until they have so many triangles.
_TRIANGLES_TOGETHER = 5_000

#: Triangles of one piece that are looked at in one step: a tenth of a second.
_TRIANGLES_AT_ONCE = 40_000

#: Samples of a ground up to which masks are kept; beyond, the memory would take more than the work is worth.
_MAX_SAMPLES = 2_000_000

#: Bytes that all masks may take.
_MAX_BYTES = 300_000_000


@dataclass(frozen=True)
class ObstacleMask:
    """The mask of some pieces.

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


class ObstacleCache:
    """The masks that the pieces of a scene, and its ground, left when they were last rasterised."""

    def __init__(self):
        self._ground: tuple = ()
        self._known = _Masks()
        self._outline: tuple[tuple, np.ndarray] | None = None

    def serves(self, grid: Grid) -> bool:
        """Test whether masks on this ground are kept: not where they are large, nor where everything repeats."""
        return not grid.tiled and grid.shape[0] * grid.shape[1] * SUBDIVISION**2 <= _MAX_SAMPLES

    def ground(self, grid: Grid, piece: Piece) -> np.ndarray:
        """(4 nx, 4 ny) bool: samples wholly inside what the ground covers, see :func:`.regions.samples_inside`."""
        key = grid.shape[:2], grid.cell_size, grid.origin, piece.key
        if self._outline is None or self._outline[0] != key:
            self._outline = key, samples_inside(piece.triangles(), grid)
        return self._outline[1]

    def blocked_steps(
        self, grid: Grid, pieces: Sequence[Piece], radius: float, low: float, high: float
    ) -> Generator[Progress, None, np.ndarray]:
        """(4 nx, 4 ny) bool: samples nearer than ``radius`` (m) to what the pieces have between the heights ``low`` and
        ``high`` (m), or inside of them.

        Raises SceneError for what :func:`.obstacles.clip_to_heights` and :func:`.obstacles.margin_for` do not accept.
        """
        margin = margin_for(grid, radius)
        ground = grid.shape[:2], grid.cell_size, grid.origin, margin, low, high
        # Somebody else may ask for another ground in the meantime: these stay ours.
        known = self._known if ground == self._ground else _Masks()
        self._ground, self._known = ground, known
        groups, total = _gathered(pieces), _Sum()
        keys = [tuple(piece.key for piece in together) for together in groups]
        # Whoever gives up on the way loses nothing that there is room for: what is no longer there is forgotten when
        # its place is needed, or at the end.
        gone = known.others(keys)
        for number, (key, together) in enumerate(zip(keys, groups, strict=True)):
            mask = known.get(key)
            if mask is None:
                mask = yield from _mask_steps(grid, together, margin, low, high, number / len(groups))
                known.keep(key, mask, gone)
            total.add(mask)
        known.forget(known.others(keys))
        self._ground, self._known = ground, known
        size = np.array(grid.shape[:2]) * SUBDIVISION
        blocked = np.zeros(size, dtype=bool)
        if total.occupied is not None:
            blocked = grown(grid, total.occupied, margin, radius)
        if total.over is not None and total.under is not None:
            blocked |= solid_where(total.over, total.under)
        return blocked


class _Masks:
    """Masks by the keys of the pieces that left them, never more than ``_MAX_BYTES`` of them."""

    def __init__(self):
        self._masks: dict[tuple, ObstacleMask] = {}
        self._n_bytes = 0

    def get(self, key: tuple) -> ObstacleMask | None:
        return self._masks.get(key)

    def others(self, keys: Sequence[tuple]) -> list[tuple]:
        """Return the keys of all masks but these."""
        return list(self._masks.keys() - set(keys))

    def keep(self, key: tuple, mask: ObstacleMask, gone: list[tuple]) -> None:
        """Keep a mask if there is room, for which as many of those that are ``gone`` as it needs are forgotten."""
        self.forget([key])
        while gone and self._n_bytes + mask.n_bytes > _MAX_BYTES:
            self.forget([gone.pop()])
        if self._n_bytes + mask.n_bytes <= _MAX_BYTES:
            self._masks[key] = mask
            self._n_bytes += mask.n_bytes

    def forget(self, keys: Sequence[tuple]) -> None:
        for key in keys:
            if key in self._masks:
                self._n_bytes -= self._masks.pop(key).n_bytes


class _Sum:
    """The sum of the masks of pieces: the attributes are those of a mask."""

    def __init__(self):
        self.occupied: np.ndarray | None = None
        self.over: np.ndarray | None = None
        self.under: np.ndarray | None = None

    def add(self, mask: ObstacleMask) -> None:
        if mask.occupied is not None:
            self.occupied = np.zeros_like(mask.occupied) if self.occupied is None else self.occupied
            self.occupied |= mask.occupied
        self.over, self.under = _added(self.over, mask.over), _added(self.under, mask.under)


def _added(total: np.ndarray | None, counts: np.ndarray | None) -> np.ndarray | None:
    """Add the counts to ``total`` in place; None is zero."""
    if counts is None:
        return total
    if total is None:
        total = np.zeros(counts.shape, dtype=np.int32)
    total += counts
    return total


def _gathered(pieces: Sequence[Piece]) -> list[list[Piece]]:
    """Return the pieces in groups that are large enough to be worth a mask."""
    groups, n_triangles = [], 0
    for piece in pieces:
        n_here = len(piece.shape.triangles)
        if not groups or n_triangles + n_here > _TRIANGLES_TOGETHER:
            groups.append([])
            n_triangles = 0
        groups[-1].append(piece)
        n_triangles += n_here
    return groups


def _mask_steps(
    grid: Grid, pieces: Sequence[Piece], margin: int, low: float, high: float, done: float
) -> Generator[Progress, None, ObstacleMask]:
    """The mask of some pieces, a bearable number of triangles at a time; ``done`` is the share of all work before."""
    triangles, total = solid_triangles(pieces, grid.corners, (low, high)), _Sum()
    for start in range(0, len(triangles), _TRIANGLES_AT_ONCE):
        yield Progress(done, "Looking at the obstacles")
        part = triangles[start : start + _TRIANGLES_AT_ONCE]
        occupied = occupied_samples(grid, clip_to_heights(part, low, high), margin)
        over, under = faces_over_and_under(grid, part, low, high)
        total.add(ObstacleMask(occupied if occupied.any() else None, _small(over), _small(under)))
    return ObstacleMask(total.occupied, _small(total.over), _small(total.under))


def _small(counts: np.ndarray | None) -> np.ndarray | None:
    """Return the same numbers in as few bytes as they need."""
    if counts is None or not counts.any():
        return None
    return counts.astype(np.min_scalar_type(-1 - max(int(counts.max()), -int(counts.min()))))
