"""Exact plane geometry for the tests: distances from points to triangles, without any grid."""

import numpy as np


def distance_to_segments(points, a, b):
    """(P,) distance of each of (P, 2) points to the nearest of n straight pieces from (n, 2) a to b."""
    nearest = np.full(len(points), np.inf)
    for start, end in zip(a, b, strict=True):
        run = end - start
        t = np.clip((points - start) @ run / max(run @ run, 1e-300), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(points - start - t[:, None] * run, axis=1))
    return nearest


def inside_polygon(points, corners):
    """(P,) bool: points inside a convex polygon (k, 2), border included."""
    start, run = np.roll(corners, 1, axis=0), corners - np.roll(corners, 1, axis=0)
    away = points[:, None] - start
    side = run[:, 0] * away[..., 1] - run[:, 1] * away[..., 0]
    return np.all(side >= 0, axis=1) | np.all(side <= 0, axis=1)


def distance_to_polygons(points, polygons):
    """(P,) distance of points to the nearest of convex polygons [(k, 2)]; 0 inside."""
    nearest = np.full(len(points), np.inf)
    for corners in polygons:
        distance = distance_to_segments(points, corners, np.roll(corners, -1, axis=0))
        nearest = np.minimum(nearest, np.where(inside_polygon(points, corners), 0.0, distance))
    return nearest


def box_triangles(low, high):
    """(12, 3, 3) triangles of the box between two corners, facing outwards."""
    corners = np.array([[(low, high)[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    triangles = np.array([corners[[a, b, c]] for q in quads for a, b, c in (q[:3], (q[0], q[2], q[3]))])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inwards = np.sum(normals * (triangles.mean(axis=1) - corners.mean(axis=0)), axis=1) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return triangles
