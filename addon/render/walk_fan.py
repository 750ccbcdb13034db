"""Walks that start at one place, as curves in colours that everybody can tell apart."""

from collections.abc import Sequence

import bpy
import numpy as np

from ..bridge.materials import remove_unused_materials
from ..bridge.owned import FAN_PROPERTY, walk_fan
from .walk_curve import lay_tube, walk_material

NAME = "Wayfarer Walk from Here"

# sRGB, Okabe and Ito's palette without black, and without the green of the baked walk.
COLORS = (
    (0.90, 0.62, 0.00),
    (0.34, 0.71, 0.91),
    (0.94, 0.89, 0.26),
    (0.00, 0.45, 0.70),
    (0.84, 0.37, 0.00),
    (0.80, 0.47, 0.65),
)
_MATERIALS = tuple(f"{NAME} {number}" for number in range(1, len(COLORS) + 1))


def draw_walk_fan(paths: Sequence[np.ndarray], ground_height: float, collection) -> list[bpy.types.Object]:
    """One curve object in ``collection`` for each of some (F, 3) paths x, y (m), heading; earlier ones are removed."""
    # Their materials are used again: someone may have given them another colour.
    _remove(collection)
    made = []
    for number, path in enumerate(paths):
        color = number % len(COLORS)
        curve = bpy.data.curves.new(NAME, "CURVE")
        curve.materials.append(walk_material(_MATERIALS[color], COLORS[color]))
        lay_tube(curve, path, ground_height)
        obj = bpy.data.objects.new(NAME, curve)
        obj[FAN_PROPERTY] = number
        collection.objects.link(obj)
        made.append(obj)
    # There may have been more walks than now.
    remove_unused_materials(_MATERIALS)
    return made


def remove_walk_fan(collection) -> int:
    """Remove the curves of :func:`draw_walk_fan` and their materials; returns how many curves there were."""
    n_curves = _remove(collection)
    remove_unused_materials(_MATERIALS)
    return n_curves


def _remove(collection) -> int:
    curves = [obj.data for obj in walk_fan(collection) if obj.data is not None]
    bpy.data.batch_remove(walk_fan(collection))
    bpy.data.batch_remove([curve for curve in curves if curve.users == 0])
    return len(curves)
