"""The ground's outline: where there is something to stand on."""

import numpy as np

_NEAR = 1e-6
"""Share of the ground's extent up to which a corner lies on its border."""


def fills_rectangle(triangles: np.ndarray) -> bool:
    """Return True if (T, 3, 3) triangles (m), seen from above, surely fill the rectangle that holds them.

    The border of what they cover consists of edges that have faces on one side only. Where all of these lie on the
    rectangle's own border, nothing is missing. False may also mean that this cannot be seen from the edges alone, as
    for faces that overlap or meet without sharing corners.
    """
    xy = np.asarray(triangles, dtype=float)[:, :, :2]
    (ax, ay), (bx, by) = (xy[:, 1] - xy[:, 0]).T, (xy[:, 2] - xy[:, 0]).T
    area = ax * by - ay * bx
    # What stands upright covers nothing; all others go around in the same direction.
    flat = area != 0
    xy = np.where((area > 0)[:, None, None], xy, xy[:, ::-1])[flat]
    if len(xy) == 0:
        return False
    points, corner = np.unique(xy.reshape(-1, 2), axis=0, return_inverse=True)
    start = corner.reshape(-1, 3)
    n, stop = len(points), np.roll(start, -1, axis=1)
    edges = np.unique(start * n + stop)
    first, last = np.divmod(edges, n)
    alone = ~np.isin(last * n + first, edges, assume_unique=True)
    ends = np.stack([points[first[alone]], points[last[alone]]], axis=1)
    low, high = points.min(axis=0), points.max(axis=0)
    near = _NEAR * (high - low)
    on_border = (ends <= low + near).all(axis=1) | (ends >= high - near).all(axis=1)
    return bool(on_border.any(axis=1).all())
