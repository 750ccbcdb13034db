"""Obstacles: triangles rasterised on the sample mask, and grown by the character's radius.

Rounding is on the safe side everywhere: a sample counts as occupied when any part of a triangle touches its
square, and as free only when every point of it keeps the radius from every point of every occupied sample.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from .. import wording
from ..errors import SceneError
from ..motion.kinematics import FARTHEST, are_positions
from .dilation import samples_near
from .grid import SUBDIVISION, Grid

#: Pairs of a polygon and a strip of samples that are looked at together: some 100 MB.
STRIPS_AT_ONCE = 500_000

#: Samples that are rasterised together, in as many whole rows as that makes: some 30 MB. Nothing but the masks
#: themselves grows with the ground.
SAMPLES_AT_ONCE = 4_000_000

#: Bytes that a sample takes while obstacles are grown (measured), and how many may be looked at: 2 GB.
SAMPLE_BYTES = 5
MAX_SAMPLES = 400_000_000

#: First and last row of a strip of samples, the last one not included.
Rows = tuple[int, int]


def clip_to_heights(triangles: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the parts of (T, 3, 3) triangles with low <= z <= high, seen from above.

    Returns (n, 5, 2) corners of convex polygons; those with fewer than five corners repeat the last one. Most
    triangles lie wholly inside the range or outside it and pass as they are; only the rest are cut.
    """
    if not np.isfinite(triangles).all():
        raise SceneError("An obstacle has a vertex whose position is not a number; repair that mesh.")
    if not are_positions(triangles).all():
        raise SceneError(
            f"An obstacle or region reaches farther than {wording.amount(FARTHEST / 1000)} km from the origin; shrink "
            "it, or leave it out."
        )
    z = triangles[:, :, 2]
    inside = np.all((z >= low) & (z <= high), axis=1)
    apart = np.all(z > high, axis=1) | np.all(z < low, axis=1)
    cut = triangles[~inside & ~apart]
    if np.isfinite(low):
        cut = _cut(cut, cut[:, :, 2] - low)
    if np.isfinite(high):
        cut = _cut(cut, high - cut[:, :, 2])
    return np.concatenate([_with_corners(part, 5)[:, :, :2] for part in (triangles[inside], cut)])


def _cut(polygons: np.ndarray, height: np.ndarray) -> np.ndarray:
    """The parts of convex polygons (n, k, 3) where the height (n, k) of the corners over a plane is not negative.

    Sutherland and Hodgman's walk around each polygon, for all at once: every side gives the point where it crosses
    the plane, if it does, and then its end, if that is kept. A plane adds at most one corner: (m, k + 1, 3).
    """
    n, k = height.shape
    before, under = np.roll(polygons, 1, axis=1), np.roll(height, 1, axis=1)
    crosses = (under < 0) != (height < 0)
    share = np.divide(under, under - height, out=np.zeros_like(height), where=crosses)
    points = np.stack([before + share[..., None] * (polygons - before), polygons], axis=2).reshape(n, 2 * k, 3)
    kept = np.stack([crosses, height >= 0], axis=2).reshape(n, 2 * k)
    points, kept = points[kept.any(axis=1)], kept[kept.any(axis=1)]
    order = np.argsort(~kept, axis=1, kind="stable")
    last = kept.sum(axis=1, keepdims=True) - 1
    order = np.take_along_axis(order, np.minimum(np.arange(k + 1), last), axis=1)
    return np.take_along_axis(points, order[..., None], axis=1)


def _with_corners(polygons: np.ndarray, n: int) -> np.ndarray:
    """Return polygons (m, k, 3) as (m, n, 3), the last corner repeated."""
    return polygons[:, np.minimum(np.arange(n), polygons.shape[1] - 1)]


def strips(width: int, depth: int) -> Iterator[Rows]:
    """Return the rows 0 ... width - 1 of a mask in strips that are small enough to be worked on at once."""
    step = max(SAMPLES_AT_ONCE // max(depth, 1), 1)
    for first in range(0, width, step):
        yield first, min(first + step, width)


def rasterise(
    polygons: np.ndarray, shape: tuple[int, int], tolerance: float = 0.0, rows: Rows | None = None
) -> np.ndarray:
    """Return the samples touched by convex polygons.

    Parameters
    ----------
    polygons : (n, k, 2) float array
        Corners in sample units: sample (i, j) is the closed square [i, i + 1] x [j, j + 1].
    shape : (width, depth) of the mask
    tolerance : float
        What comes this close to a square (in samples) touches it.
    rows : (first, end), optional
        Only these rows of the mask.

    Returns
    -------
    (width, depth) bool array, or the rows asked for: exact - a sample is set if and only if a polygon touches its
    square (a polygon that only touches its border may set either neighbour).
    """
    width, depth = shape
    low, high = rows or (0, width)
    x, y = polygons[:, :, 0], polygons[:, :, 1]
    near = (x.max(axis=1) >= 0) & (x.min(axis=1) <= width) & (y.max(axis=1) >= 0) & (y.min(axis=1) <= depth)
    polygons = polygons[near]
    first = np.clip(np.floor(polygons[:, :, 0].min(axis=1) - tolerance), low, high).astype(int)
    last = np.clip(np.floor(polygons[:, :, 0].max(axis=1) + tolerance), low - 1, high - 1).astype(int)
    n_strips = np.maximum(last - first + 1, 0)
    if not n_strips.any():
        return np.zeros((high - low, depth), dtype=bool)
    edges = np.zeros((high - low) * (depth + 1), dtype=np.int32)
    # So many at a time that memory does not depend on the size of the mesh.
    block = (np.cumsum(n_strips) - n_strips) // STRIPS_AT_ONCE
    for start, stop in pairwise([*np.flatnonzero(np.diff(block, prepend=-1)), len(polygons)]):
        _fill(edges, polygons[start:stop], first[start:stop], n_strips[start:stop], low, depth, tolerance)
    return _running_sums(edges, (high - low, depth)) > 0


def _fill(edges, polygons, first, n_strips, low_row: int, depth: int, tolerance: float) -> None:
    """Count the polygons into ``edges``: +1 where one begins in a strip, -1 after it ends; ``low_row`` is the first.

    Each polygon meets the strip i <= x <= i + 1 in one convex piece, and so in one interval of y: the intervals are
    found for all (polygon, strip) pairs at once, to be filled by a running sum.
    """
    which = np.repeat(np.arange(len(polygons)), n_strips)
    strip = np.arange(len(which)) - np.repeat(np.cumsum(n_strips) - n_strips, n_strips) + first[which]
    low = np.full(len(which), np.inf)
    high = np.full(len(which), -np.inf)
    for corner in range(polygons.shape[1]):
        a, b = polygons[which, corner - 1], polygons[which, corner]
        swap = a[:, :1] > b[:, :1]
        a, b = np.where(swap, b, a), np.where(swap, a, b)
        run = b[:, 0] - a[:, 0]
        slope = np.divide(b[:, 1] - a[:, 1], run, out=np.zeros_like(run), where=run > 0)
        from_x, to_x = np.maximum(a[:, 0], strip - tolerance), np.minimum(b[:, 0], strip + 1 + tolerance)
        y0 = a[:, 1] + slope * (from_x - a[:, 0])
        y1 = np.where(run > 0, a[:, 1] + slope * (to_x - a[:, 0]), b[:, 1])
        met = from_x <= to_x
        low = np.where(met, np.minimum(low, np.minimum(y0, y1)), low)
        high = np.where(met, np.maximum(high, np.maximum(y0, y1)), high)
    low, high = low - tolerance, high + tolerance
    met = (low <= high) & (high >= 0) & (low < depth)
    bottom = np.clip(np.floor(low[met]), 0, depth).astype(int)
    top = np.clip(np.floor(high[met]), -1, depth - 1).astype(int)
    start = (strip[met] - low_row) * (depth + 1)
    np.add.at(edges, start + bottom, 1)
    np.subtract.at(edges, start + top + 1, 1)


def _running_sums(edges: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return (width, depth) sums along each column of samples up to each of them; overwrites ``edges``."""
    width, depth = shape
    columns = edges.reshape(width, depth + 1)
    return np.cumsum(columns, axis=1, out=columns)[:, :depth]


def solid_columns(above: np.ndarray, below: np.ndarray, shape: tuple[int, int], rows: Rows) -> np.ndarray:
    """Return (rows, depth) bool: samples whose centre lies inside a closed mesh all the way between two heights.

    ``above`` and ``below`` (n, 4, 3) are the faces over the upper height and under the lower one, see :func:`_beyond`,
    x and y in sample units. A ray upwards from inside a solid leaves it through one face
    more than it enters by, a ray downwards likewise; a ceiling, a floor or a room seen from within passes one of the
    two tests at most. Only meaningful where no triangle passes through the column between the two heights.
    """
    return solid_where(_crossings(above, shape, rows), _crossings(below, shape, rows))


def solid_where(over: np.ndarray, under: np.ndarray) -> np.ndarray:
    """Test which samples are solid, from how many faces over and under each of them face up more than down."""
    return (over > 0) & (under < 0)


def _beyond(triangles: np.ndarray, height: np.ndarray) -> np.ndarray:
    """(n, 4, 3) corners of the parts of triangles where the height (T, 3) of the corners over a plane is not negative.

    Only those that the plane passes through need cutting.
    """
    low, high = height.min(axis=1), height.max(axis=1)
    cut = (low < 0) & (high >= 0)
    return np.concatenate([_with_corners(triangles[low >= 0], 4), _cut(triangles[cut], height[cut])])


def _crossings(polygons: np.ndarray, shape: tuple[int, int], rows: Rows) -> np.ndarray:
    """(rows, depth) int: polygons (n, k, 3) over or under each sample's centre, +1 facing up and -1 facing down."""
    depth, (low_row, high_row) = shape[1], rows
    x, y = polygons[:, :, 0], polygons[:, :, 1]
    area = np.sum(np.roll(x, 1, axis=1) * y - x * np.roll(y, 1, axis=1), axis=1)
    polygons, facing = polygons[area != 0], np.sign(area[area != 0]).astype(np.int32)
    first = np.clip(np.ceil(polygons[:, :, 0].min(axis=1) - 0.5), low_row, high_row).astype(int)
    last = np.clip(np.ceil(polygons[:, :, 0].max(axis=1) - 0.5), low_row, high_row).astype(int)
    n_lines = last - first
    if not n_lines.any():
        return np.zeros((high_row - low_row, depth), dtype=np.int32)
    edges = np.zeros((high_row - low_row) * (depth + 1), dtype=np.int32)
    block = (np.cumsum(n_lines) - n_lines) // STRIPS_AT_ONCE
    for start, stop in pairwise([*np.flatnonzero(np.diff(block, prepend=-1)), len(polygons)]):
        part, lines = polygons[start:stop], n_lines[start:stop]
        which = np.repeat(np.arange(len(part)), lines)
        line = np.arange(len(which)) - np.repeat(np.cumsum(lines) - lines, lines) + first[start:stop][which]
        low, high = np.full(len(which), np.inf), np.full(len(which), -np.inf)
        for corner in range(part.shape[1]):
            a, b = part[which, corner - 1, :2], part[which, corner, :2]
            swap = (a[:, :1] > b[:, :1]) | ((a[:, :1] == b[:, :1]) & (a[:, 1:] > b[:, 1:]))
            a, b = np.where(swap, b, a), np.where(swap, a, b)
            at = line + 0.5
            # Half open, and the same numbers for both faces at an edge: a centre on it belongs to one of them.
            met = (a[:, 0] <= at) & (at < b[:, 0])
            share = np.divide(at - a[:, 0], b[:, 0] - a[:, 0], out=np.zeros(len(at)), where=met)
            crossed = a[:, 1] + share * (b[:, 1] - a[:, 1])
            low = np.where(met, np.minimum(low, crossed), low)
            high = np.where(met, np.maximum(high, crossed), high)
        met = low < high
        column, sign = (line[met] - low_row) * (depth + 1), facing[start:stop][which[met]]
        np.add.at(edges, column + np.clip(np.ceil(low[met] - 0.5), 0, depth).astype(int), sign)
        np.subtract.at(edges, column + np.clip(np.ceil(high[met] - 0.5), 0, depth).astype(int), sign)
    return _running_sums(edges, (high_row - low_row, depth))


class _ByRows:
    """Polygons (n, k, d), x in samples, of which those near some rows are asked for again and again."""

    def __init__(self, polygons: np.ndarray):
        self._polygons = polygons
        self._low, self._high = polygons[:, :, 0].min(axis=1), polygons[:, :, 0].max(axis=1)

    def near(self, first: int, last: int) -> np.ndarray:
        """Return those that may touch the rows, and perhaps others a sample away."""
        return self._polygons[(self._high >= first - 1) & (self._low <= last + 1)]


class PolygonRaster:
    """Polygons over a ground and ``margin`` samples around it, to be rasterised in strips.

    ``polygons`` is an array (n, k, 2) of world coordinates in metres. On a tiled ground everything repeats with the
    tile, wherever it stands: what reaches over a border is there again on the other side.
    """

    def __init__(self, grid: Grid, polygons: np.ndarray, margin: int, tolerance: float = 0.0):
        size = np.array(grid.shape[:2]) * SUBDIVISION
        polygons = (polygons - grid.origin) / grid.sample_size
        self._tile: tuple[int, int] = tuple(size.tolist())
        self._margin, self._tolerance, self._tiled = margin, tolerance, grid.tiled
        self.shape: tuple[int, int] = tuple((size + 2 * margin).tolist())
        self._repeats = (1, 1)
        if not grid.tiled:
            polygons = polygons + margin
        elif len(polygons):
            polygons = polygons - np.floor(polygons.min(axis=1, keepdims=True) / size) * size
            self._repeats = tuple((np.floor(polygons.max(axis=(0, 1)) / size).astype(int) + 1).tolist())
            _check_repeats(grid, self._repeats[0] * self._repeats[1])
        self._polygons = _ByRows(polygons)

    def rows(self, first: int, last: int) -> np.ndarray:
        """(last - first, depth) bool: samples of these rows, counted with the margin, that the polygons touch."""
        if not self._tiled:
            return rasterise(self._polygons.near(first, last), self.shape, self._tolerance, (first, last))
        nx, row = self._tile[0], first - self._margin
        parts = []
        while row < last - self._margin:
            begin = row % nx
            end = min(begin + last - self._margin - row, nx)
            parts.append(self._tile_rows(begin, end))
            row += end - begin
        return np.pad(np.concatenate(parts), ((0, 0), (self._margin,) * 2), mode="wrap")

    def _tile_rows(self, first: int, last: int) -> np.ndarray:
        (nx, ny), (repeats_x, repeats_y) = self._tile, self._repeats
        found = np.zeros((last - first, ny), dtype=bool)
        for x in range(0, repeats_x * nx, nx):
            rows = x + first, x + last
            near = self._polygons.near(*rows)
            mask = rasterise(near, (repeats_x * nx, repeats_y * ny), self._tolerance, rows)
            found |= mask.reshape(last - first, repeats_y, ny).any(axis=1)
        return found


def occupied_samples(grid: Grid, polygons: np.ndarray, margin: int) -> np.ndarray:
    """Rasterise polygons on the ground and ``margin`` samples around it, see :class:`PolygonRaster`."""
    raster = PolygonRaster(grid, polygons, margin)
    width, depth = raster.shape
    occupied = np.empty((width, depth), dtype=bool)
    for first, last in strips(width, depth):
        occupied[first:last] = raster.rows(first, last)
    return occupied


def _check_repeats(grid: Grid, n_tiles: int) -> None:
    """Raise SceneError if geometry that covers so many tiles would take too long to look at."""
    n_samples = grid.shape[0] * grid.shape[1] * SUBDIVISION**2
    # What stands on a corner covers four.
    if n_tiles * n_samples > max(MAX_SAMPLES, 4 * n_samples):
        raise SceneError(
            f"An obstacle or region covers {wording.number(n_tiles)} tiles of {wording.exact(grid.size[0])} x "
            f"{wording.exact(grid.size[1])} m, more than can be looked at; cut it down to the tile, or switch Tiled "
            "off."
        )


def solid_strips(grid: Grid, triangles: np.ndarray, low: float, high: float) -> Iterator[tuple[Rows, np.ndarray]]:
    """Yield the samples inside closed meshes of (T, 3, 3) world triangles in metres: (rows, (rows, 4 ny) bool).

    Strips in which nothing is solid are left out.
    """
    size = np.array(grid.shape[:2]) * SUBDIVISION
    nx, ny = size.tolist()
    moved = np.array(triangles, dtype=float)
    moved[:, :, :2] = (moved[:, :, :2] - grid.origin) / grid.sample_size
    n_tiles = np.ones(2, dtype=int)
    if grid.tiled and len(moved):
        # Faces of one mesh must stay together: look at all the tiles that the geometry covers.
        first_tile = np.floor(moved[:, :, :2].min(axis=(0, 1)) / size).astype(int)
        n_tiles = np.floor(moved[:, :, :2].max(axis=(0, 1)) / size).astype(int) + 1 - first_tile
        _check_repeats(grid, int(np.prod(n_tiles)))
        moved[:, :, :2] -= first_tile * size
    z = moved[:, :, 2]
    if not (np.isfinite(high) and np.isfinite(low)):
        return
    above, below = _ByRows(_beyond(moved, z - high)), _ByRows(_beyond(moved, low - z))
    shape = tuple((n_tiles * size).tolist())
    for first, last in strips(nx, shape[1]):
        found = np.zeros((last - first, ny), dtype=bool)
        for x in range(0, shape[0], nx):
            rows = x + first, x + last
            solid = solid_columns(above.near(*rows), below.near(*rows), shape, rows)
            found |= solid.reshape(last - first, n_tiles[1], ny).any(axis=1)
        if found.any():
            yield (first, last), found


def samples_within(grid: Grid, polygons: np.ndarray, distance: float) -> np.ndarray:
    """(4 nx, 4 ny) bool: samples of the ground with any point nearer than ``distance`` (m) to the polygons, or touched.

    The distance is that of the nearest points of two samples' squares, see :func:`.dilation.samples_near`.
    """
    margin = margin_for(grid, distance)
    return grown(grid, occupied_samples(grid, polygons, margin), margin, distance)


def margin_for(grid: Grid, distance: float) -> int:
    """Return the samples around the ground within ``distance`` (m) of it; SceneError if those are too many."""
    size = np.array(grid.shape[:2]) * SUBDIVISION
    if np.prod(size + 2 * (distance / grid.sample_size + 2)) > MAX_SAMPLES:
        raise SceneError(
            f"Keeping {wording.exact(distance)} m away from everything takes too much memory in cells of "
            f"{wording.exact(grid.cell_size)} m; use a smaller Radius or Margin, or a larger Cell Size."
        )
    return int(np.ceil(distance / grid.sample_size)) + 2


def grown(grid: Grid, occupied: np.ndarray, margin: int, distance: float) -> np.ndarray:
    """(4 nx, 4 ny) bool: what is near ``occupied``, which are samples of the ground and of ``margin`` around it."""
    if distance > 0:
        occupied = samples_near(occupied, distance / grid.sample_size)
    return np.ascontiguousarray(occupied[margin:-margin, margin:-margin])


def faces_over_and_under(grid: Grid, triangles: np.ndarray, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Two (4 nx, 4 ny) int arrays: how many more of the (T, 3, 3) world triangles (m) face up than down over the height
    ``high``, and under ``low`` (m), at each sample of a ground that is not tiled.
    """
    shape = grid.shape[0] * SUBDIVISION, grid.shape[1] * SUBDIVISION
    moved = np.array(triangles, dtype=float)
    moved[:, :, :2] = (moved[:, :, :2] - grid.origin) / grid.sample_size
    z, rows = moved[:, :, 2], (0, shape[0])
    return _crossings(_beyond(moved, z - high), shape, rows), _crossings(_beyond(moved, low - z), shape, rows)
