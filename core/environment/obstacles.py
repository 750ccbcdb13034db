"""Obstacles: triangles rasterised on the sample mask, and grown by the character's radius.

Rounding is on the safe side everywhere: a sample counts as occupied when any part of a triangle touches its
square, and as free only when every point of it keeps the radius from every point of every occupied sample.
"""

import numpy as np
from scipy import ndimage

from ..errors import SceneError
from .grid import SUBDIVISION, Grid


def clip_to_heights(triangles: np.ndarray, low: float, high: float) -> list[np.ndarray]:
    """The parts of (T, 3, 3) triangles with low <= z <= high, as arrays (n, k, 2) of convex polygons seen from above.

    Most triangles lie wholly inside the range or outside it and pass as they are; only the rest are cut.
    """
    if not np.isfinite(triangles).all():
        raise SceneError("An obstacle has a vertex whose position is not a number; repair that mesh.")
    z = triangles[:, :, 2]
    inside = np.all((z >= low) & (z <= high), axis=1)
    apart = np.all(z > high, axis=1) | np.all(z < low, axis=1)
    polygons = [triangles[inside][:, :, :2]]
    for triangle in triangles[~inside & ~apart]:
        polygon = _cut_below(_cut_below(triangle, low), -high, sign=-1)
        if len(polygon):
            polygons.append(polygon[None, :, :2])
    return [polygon for polygon in polygons if len(polygon)]


def _cut_below(polygon: np.ndarray, level: float, sign: int = 1) -> np.ndarray:
    """The part of a convex polygon (k, 3) where sign * z >= level (Sutherland-Hodgman, one plane)."""
    height = sign * polygon[:, 2] - level if len(polygon) else np.empty(0)
    kept = []
    for i in range(len(polygon)):
        before, after = polygon[i - 1], polygon[i]
        if (height[i - 1] < 0) != (height[i] < 0):
            t = height[i - 1] / (height[i - 1] - height[i])
            kept.append(before + t * (after - before))
        if height[i] >= 0:
            kept.append(after)
    return np.array(kept).reshape(-1, 3)


def rasterise(polygons: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Samples touched by convex polygons.

    Parameters
    ----------
    polygons : (n, k, 2) float array
        Corners in sample units: sample (i, j) is the closed square [i, i + 1] x [j, j + 1].
    shape : (width, depth) of the mask

    Returns
    -------
    (width, depth) bool array: exact - a sample is set if and only if a polygon touches its square (a polygon that
    only touches its border may set either neighbour).

    Each polygon meets the strip i <= x <= i + 1 in one convex piece, and so in one interval of y: the intervals are
    found for all (polygon, strip) pairs at once and filled by a running sum.
    """
    width, depth = shape
    first = np.clip(np.floor(polygons[:, :, 0].min(axis=1)), 0, width).astype(int)
    last = np.clip(np.floor(polygons[:, :, 0].max(axis=1)), -1, width - 1).astype(int)
    n_strips = np.maximum(last - first + 1, 0)
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
        from_x, to_x = np.maximum(a[:, 0], strip), np.minimum(b[:, 0], strip + 1)
        y0 = a[:, 1] + slope * (from_x - a[:, 0])
        y1 = np.where(run > 0, a[:, 1] + slope * (to_x - a[:, 0]), b[:, 1])
        met = from_x <= to_x
        low = np.where(met, np.minimum(low, np.minimum(y0, y1)), low)
        high = np.where(met, np.maximum(high, np.maximum(y0, y1)), high)
    met = (low <= high) & (high >= 0) & (low < depth)
    bottom = np.clip(np.floor(low[met]), 0, depth).astype(int)
    top = np.clip(np.floor(high[met]), -1, depth - 1).astype(int)
    edges = np.bincount(strip[met] * (depth + 1) + bottom, minlength=width * (depth + 1)).astype(np.int64)
    edges -= np.bincount(strip[met] * (depth + 1) + top + 1, minlength=width * (depth + 1))
    return np.cumsum(edges.reshape(width, depth + 1), axis=1)[:, :depth] > 0


def occupied_samples(grid: Grid, polygons: list[np.ndarray], margin: int) -> np.ndarray:
    """Samples of the ground and of ``margin`` samples around it that the polygons touch.

    ``polygons`` are arrays (n, k, 2) of world coordinates in metres. Around a tiled ground stand its own repetitions;
    geometry that reaches over its border is carried to the other side.
    """
    nx, ny = grid.shape[0] * SUBDIVISION, grid.shape[1] * SUBDIVISION
    around = (nx, ny) if grid.tiled else (margin, margin)
    shape = (nx + 2 * around[0], ny + 2 * around[1])
    mask = np.zeros(shape, dtype=bool)
    for part in polygons:
        mask |= rasterise((part - grid.origin) / grid.sample_size + around, shape)
    if not grid.tiled:
        return mask
    tile = mask.reshape(3, nx, 3, ny).any(axis=(0, 2))
    return np.pad(tile, margin, mode="wrap")


def samples_within(grid: Grid, polygons: list[np.ndarray], distance: float) -> np.ndarray:
    """(4 nx, 4 ny) bool: samples of the ground with any point nearer than ``distance`` (m) to the polygons, or touched.

    The distance between two samples is that of the nearest points of their squares: growing the occupied ones by
    one sample in all eight directions and measuring between centres gives exactly that.
    """
    margin = int(np.ceil(distance / grid.sample_size)) + 2
    occupied = occupied_samples(grid, polygons, margin)
    if distance > 0 and occupied.any():
        apart = np.asarray(ndimage.binary_erosion(~occupied, np.ones((3, 3), dtype=bool), border_value=True))
        clearance = np.asarray(ndimage.distance_transform_edt(apart)) * grid.sample_size
        # A hair of tolerance on the safe side, against rounding in the distance itself.
        occupied = occupied | (clearance < distance * (1 + 1e-9))
    return occupied[margin:-margin, margin:-margin]
