"""Obstacles: triangles rasterised on the sample mask, and grown by the character's radius.

Rounding is on the safe side everywhere: a sample counts as occupied when any part of a triangle touches its
square, and as free only when every point of it keeps the radius from every point of every occupied sample.
"""

from itertools import pairwise

import numpy as np
from scipy import ndimage

from ..errors import SceneError
from ..motion.kinematics import FARTHEST, are_positions
from .grid import SUBDIVISION, Grid

#: Pairs of a polygon and a strip of samples that are looked at together: some 100 MB.
STRIPS_AT_ONCE = 500_000

#: Bytes that a sample takes while obstacles are grown (measured), and how many may be looked at: 4 GB.
SAMPLE_BYTES = 40
MAX_SAMPLES = 100_000_000


def clip_to_heights(triangles: np.ndarray, low: float, high: float) -> np.ndarray:
    """The parts of (T, 3, 3) triangles with low <= z <= high, seen from above.

    Returns (n, 5, 2) corners of convex polygons; those with fewer than five corners repeat the last one. Most
    triangles lie wholly inside the range or outside it and pass as they are; only the rest are cut.
    """
    if not np.isfinite(triangles).all():
        raise SceneError("An obstacle has a vertex whose position is not a number; repair that mesh.")
    if not are_positions(triangles).all():
        raise SceneError(
            f"An obstacle or region reaches farther than {FARTHEST / 1000:,.0f} km from the origin; shrink it, or "
            "leave it out."
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
    """Polygons (m, k, 3) as (m, n, 3), the last corner repeated."""
    return polygons[:, np.minimum(np.arange(n), polygons.shape[1] - 1)]


def rasterise(polygons: np.ndarray, shape: tuple[int, int], tolerance: float = 0.0) -> np.ndarray:
    """Samples touched by convex polygons.

    Parameters
    ----------
    polygons : (n, k, 2) float array
        Corners in sample units: sample (i, j) is the closed square [i, i + 1] x [j, j + 1].
    shape : (width, depth) of the mask
    tolerance : float
        What comes this close to a square (in samples) touches it.

    Returns
    -------
    (width, depth) bool array: exact - a sample is set if and only if a polygon touches its square (a polygon that
    only touches its border may set either neighbour).
    """
    width, depth = shape
    edges = np.zeros(width * (depth + 1), dtype=np.int32)
    x, y = polygons[:, :, 0], polygons[:, :, 1]
    near = (x.max(axis=1) >= 0) & (x.min(axis=1) <= width) & (y.max(axis=1) >= 0) & (y.min(axis=1) <= depth)
    polygons = polygons[near]
    first = np.clip(np.floor(polygons[:, :, 0].min(axis=1) - tolerance), 0, width).astype(int)
    last = np.clip(np.floor(polygons[:, :, 0].max(axis=1) + tolerance), -1, width - 1).astype(int)
    n_strips = np.maximum(last - first + 1, 0)
    # So many at a time that memory does not depend on the size of the mesh.
    block = (np.cumsum(n_strips) - n_strips) // STRIPS_AT_ONCE
    for start, stop in pairwise([*np.flatnonzero(np.diff(block, prepend=-1)), len(polygons)]):
        _fill(edges, polygons[start:stop], first[start:stop], n_strips[start:stop], depth, tolerance)
    return _running_sums(edges, shape) > 0


def _fill(edges, polygons, first, n_strips, depth: int, tolerance: float) -> None:
    """Count the polygons into ``edges``: +1 where one begins in a strip, -1 after it ends.

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
    np.add.at(edges, strip[met] * (depth + 1) + bottom, 1)
    np.subtract.at(edges, strip[met] * (depth + 1) + top + 1, 1)


def _running_sums(edges: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """(width, depth) sums along each column of samples up to each of them; overwrites ``edges``."""
    width, depth = shape
    columns = edges.reshape(width, depth + 1)
    return np.cumsum(columns, axis=1, out=columns)[:, :depth]


def solid_columns(triangles: np.ndarray, low: float, high: float, shape: tuple[int, int]) -> np.ndarray:
    """(width, depth) bool: samples whose centre lies inside a closed mesh all the way from ``low`` to ``high``.

    ``triangles`` (T, 3, 3) have x and y in sample units. A ray upwards from inside a solid leaves it through one face
    more than it enters by, a ray downwards likewise; a ceiling, a floor or a room seen from within passes one of the
    two tests at most. Only meaningful where no triangle passes through the column between the two heights.
    """
    z = triangles[:, :, 2]
    above = _beyond(triangles, z - high) if np.isfinite(high) else triangles[:0]
    below = _beyond(triangles, low - z) if np.isfinite(low) else triangles[:0]
    return (_crossings(above, shape) > 0) & (_crossings(below, shape) < 0)


def _beyond(triangles: np.ndarray, height: np.ndarray) -> np.ndarray:
    """(n, 4, 3) corners of the parts of triangles where the height (T, 3) of the corners over a plane is not negative.

    Only those that the plane passes through need cutting.
    """
    low, high = height.min(axis=1), height.max(axis=1)
    cut = (low < 0) & (high >= 0)
    return np.concatenate([_with_corners(triangles[low >= 0], 4), _cut(triangles[cut], height[cut])])


def _crossings(polygons: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """(width, depth) int: polygons (n, k, 3) over or under each sample's centre, +1 facing up and -1 facing down."""
    width, depth = shape
    x, y = polygons[:, :, 0], polygons[:, :, 1]
    area = np.sum(np.roll(x, 1, axis=1) * y - x * np.roll(y, 1, axis=1), axis=1)
    polygons, facing = polygons[area != 0], np.sign(area[area != 0]).astype(np.int32)
    first = np.clip(np.ceil(polygons[:, :, 0].min(axis=1) - 0.5), 0, width).astype(int)
    last = np.clip(np.ceil(polygons[:, :, 0].max(axis=1) - 0.5), 0, width).astype(int)
    n_lines = last - first
    edges = np.zeros(width * (depth + 1), dtype=np.int32)
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
        column, sign = line[met] * (depth + 1), facing[start:stop][which[met]]
        np.add.at(edges, column + np.clip(np.ceil(low[met] - 0.5), 0, depth).astype(int), sign)
        np.subtract.at(edges, column + np.clip(np.ceil(high[met] - 0.5), 0, depth).astype(int), sign)
    return _running_sums(edges, shape)


def occupied_samples(grid: Grid, polygons: np.ndarray, margin: int, tolerance: float = 0.0) -> np.ndarray:
    """Samples of the ground and of ``margin`` samples around it that the polygons touch.

    ``polygons`` is an array (n, k, 2) of world coordinates in metres. On a tiled ground everything repeats with the
    tile, wherever it stands: what reaches over a border is there again on the other side.
    """
    size = np.array(grid.shape[:2]) * SUBDIVISION
    polygons = (polygons - grid.origin) / grid.sample_size
    if not grid.tiled:
        return rasterise(polygons + margin, tuple((size + 2 * margin).tolist()), tolerance)
    if len(polygons) == 0:
        return np.zeros(size + 2 * margin, dtype=bool)
    polygons = polygons - np.floor(polygons.min(axis=1, keepdims=True) / size) * size
    nx, ny = size.tolist()
    repeats_x, repeats_y = (np.floor(polygons.max(axis=(0, 1)) / size).astype(int) + 1).tolist()
    _check_repeats(grid, repeats_x * repeats_y)
    mask = rasterise(polygons, (repeats_x * nx, repeats_y * ny), tolerance)
    tile = mask.reshape(repeats_x, nx, repeats_y, ny).any(axis=(0, 2))
    return np.pad(tile, margin, mode="wrap")


def _check_repeats(grid: Grid, n_tiles: int) -> None:
    """SceneError if geometry that covers so many tiles would take too much memory."""
    if n_tiles * grid.shape[0] * grid.shape[1] * SUBDIVISION**2 > MAX_SAMPLES:
        raise SceneError(
            f"An obstacle or region covers {n_tiles:,} tiles of {grid.size[0]:g} x {grid.size[1]:g} m, more than "
            "can be looked at; cut it down to the tile, or do not tile the ground."
        )


def solid_samples(grid: Grid, triangles: np.ndarray, low: float, high: float) -> np.ndarray:
    """(4 nx, 4 ny) bool: samples of the ground inside closed meshes, for (T, 3, 3) world triangles in metres."""
    size = np.array(grid.shape[:2]) * SUBDIVISION
    moved = np.array(triangles, dtype=float)
    moved[:, :, :2] = (moved[:, :, :2] - grid.origin) / grid.sample_size
    if not grid.tiled or len(moved) == 0:
        return solid_columns(moved, low, high, tuple(size.tolist()))
    # Faces of one mesh must stay together: look at all the tiles that the geometry covers.
    first = np.floor(moved[:, :, :2].min(axis=(0, 1)) / size).astype(int)
    n_tiles = np.floor(moved[:, :, :2].max(axis=(0, 1)) / size).astype(int) + 1 - first
    _check_repeats(grid, int(np.prod(n_tiles)))
    moved[:, :, :2] -= first * size
    nx, ny = size.tolist()
    solid = solid_columns(moved, low, high, tuple((n_tiles * size).tolist()))
    return solid.reshape(n_tiles[0], nx, n_tiles[1], ny).any(axis=(0, 2))


def samples_within(grid: Grid, polygons: np.ndarray, distance: float) -> np.ndarray:
    """(4 nx, 4 ny) bool: samples of the ground with any point nearer than ``distance`` (m) to the polygons, or touched.

    The distance between two samples is that of the nearest points of their squares: growing the occupied ones by
    one sample in all eight directions and measuring between centres gives exactly that.
    """
    size = np.array(grid.shape[:2]) * SUBDIVISION
    if np.prod(size + 2 * (distance / grid.sample_size + 2)) > MAX_SAMPLES:
        raise SceneError(
            f"Keeping {distance:g} m away from everything takes too much memory in cells of {grid.cell_size:g} m; use "
            "a smaller radius or margin, or larger cells."
        )
    margin = int(np.ceil(distance / grid.sample_size)) + 2
    occupied = occupied_samples(grid, polygons, margin)
    if distance > 0 and occupied.any():
        apart = np.asarray(ndimage.binary_erosion(~occupied, np.ones((3, 3), dtype=bool), border_value=True))
        clearance = np.asarray(ndimage.distance_transform_edt(apart)) * grid.sample_size
        # A hair of tolerance on the safe side, against rounding in the distance itself.
        occupied = occupied | (clearance < distance * (1 + 1e-9))
    return occupied[margin:-margin, margin:-margin]
