"""Grounds that are not flat, although walks are planned on one height."""

import numpy as np

from ..bridge.read_scene import ShapeMemory, read_own_piece
from ..properties.environment import REGION_TYPES, GroundSource

_FLAT = 0.02
"""Metres from the lowest to the highest point of what counts as flat."""

_NEGLIGIBLE = 0.02
"""Share of what looks up that may lie lower: bevelled edges, a drain."""

_OPEN = 1e-4
"""Share of all faces, seen from above, by which those of one side outweigh the others where a mesh is not closed."""


def uneven_ground(scene, height: float, depsgraph, memory: ShapeMemory) -> tuple[str, float, float] | None:
    """Name, lowest and highest z (m) of the scene's ground object if it is not flat; the highest is ``height``, at
    which walks are planned. None for a flat ground, and for one that is no object or has no faces."""
    settings = scene.wayfarer.environment
    ground = settings.ground if settings.source is GroundSource.OBJECT else None
    if ground is None or ground.type not in REGION_TYPES:
        return None
    piece = read_own_piece(ground, depsgraph, memory)
    lowest = None if piece is None else lowest_floor(piece.triangles(), height - _FLAT)
    return None if lowest is None else (ground.name, lowest, height)


def lowest_floor(triangles: np.ndarray, flat: float) -> float | None:
    """Lowest z (m) of those of (T, 3, 3) triangles that look up; None if next to nothing of them is below ``flat``.

    Which side of a mesh is up does not depend on how its faces are wound, for that is often wrong: an open mesh, such
    as a plane, looks up with the side that most of it shows from above, a closed one, such as a slab, outwards.
    """
    if len(triangles) == 0:
        return None
    sides = triangles[:, 1:] - triangles[:, :1]
    normals = np.cross(sides[:, 0], sides[:, 1])
    areas = normals[:, 2]
    net, gross = areas.sum(), np.abs(areas).sum()
    if abs(net) <= _OPEN * gross:
        # About their middle: far from the world's origin, the volume would be lost in rounding.
        net = ((triangles[:, 0] - triangles.mean(axis=(0, 1))) * normals).sum()
    areas = -areas if net < 0 else areas
    up = areas > 1e-3 * np.linalg.norm(normals, axis=1)
    lows = triangles[up, :, 2].min(axis=1)
    low = lows < flat
    return float(lows.min()) if areas[up][low].sum() > _NEGLIGIBLE * areas[up].sum() else None
