"""The painted floor of a scene, with its legend."""

from typing import cast

import bpy
import numpy as np

from ...core.errors import SceneError
from ...core.maps.floor_map import PaintedMap
from ...core.maps.legend import MapLegend
from ..bridge.owned import OUTPUT, ensure_collection, find_collection, painted_ground
from ..bridge.write_colors import ground_grid, paint

FLOOR_NAME = "Wayfarer Floor"
LEGEND_PROPERTY = "wayfarer_legend"

_APART = 4e-4
"""Metres above the ground for each metre of its diagonal: what is seen from farther away is told apart less well."""


def put_on_floor(scene, grid, ground_height: float, offset: float, painted: PaintedMap):
    """Paint the scene's floor, made if there is none, and keep the legend with it; returns the object.

    ``grid`` is the core's Grid, ``ground_height`` and ``offset`` are metres.

    Raises SceneError if the floor is being edited.
    """
    nx, ny, _ = grid.shape
    earlier = find_floor(scene)
    if earlier is not None and cast(bpy.types.Mesh, earlier.data).is_editmode:
        raise SceneError(f"The floor '{earlier.name}' is being edited; leave Edit Mode, so that it can be painted.")
    above = max(offset, _APART * float(np.hypot(*grid.size)))
    collection = ensure_collection(scene, OUTPUT)
    x, y = grid.origin
    floor = ground_grid(FLOOR_NAME, x, y, grid.cell_size, nx, ny, ground_height + above, collection)
    paint(floor, painted.colors)
    text = painted.legend.to_json()
    # Writing it anew would tell Blender of a change.
    if floor.get(LEGEND_PROPERTY) != text:
        floor[LEGEND_PROPERTY] = text
    return floor


def find_floor(scene):
    """Return the scene's painted floor, or None."""
    collection = find_collection(scene, OUTPUT)
    return painted_ground(collection) if collection is not None else None


def floor_legend(floor) -> MapLegend | None:
    """Return the legend of a painted floor; None if it has none that can be read."""
    text = floor.get(LEGEND_PROPERTY)
    if not isinstance(text, str):
        return None
    if text not in _read:
        _read.clear()
        try:
            _read[text] = MapLegend.from_json(text)
        except (ValueError, LookupError, TypeError, ArithmeticError):
            # Files are opened by older and newer versions, too.
            _read[text] = None
    return _read[text]


_read: dict[str, MapLegend | None] = {}
"""The legend that was read last, by its text: asked for at every redraw."""
