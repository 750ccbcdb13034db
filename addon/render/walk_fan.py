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
    """One curve object in ``collection`` for each of some (F, 3) paths x, y (m), heading.

    Those of earlier walks are used again, with all that the artist hung on them; what is too many is removed.
    """
    known = {obj[FAN_PROPERTY]: obj for obj in walk_fan(collection) if isinstance(obj.data, bpy.types.Curve)}
    made = []
    for number, path in enumerate(paths):
        obj = known.get(number)
        if obj is None:
            color = number % len(COLORS)
            curve = bpy.data.curves.new(NAME, "CURVE")
            curve.materials.append(walk_material(_MATERIALS[color], COLORS[color]))
            obj = bpy.data.objects.new(NAME, curve)
            obj[FAN_PROPERTY] = number
            collection.objects.link(obj)
        lay_tube(obj.data, path, ground_height)
        made.append(obj)
    _remove([obj for obj in walk_fan(collection) if obj not in made])
    remove_unused_materials(_MATERIALS)
    return made


def remove_walk_fan(collection) -> int:
    """Remove the curves of :func:`draw_walk_fan` and their materials; returns how many curves there were."""
    n_curves = _remove(walk_fan(collection))
    remove_unused_materials(_MATERIALS)
    return n_curves


def _remove(objects: Sequence[bpy.types.Object]) -> int:
    curves = [obj.data for obj in objects if obj.data is not None]
    bpy.data.batch_remove(objects)
    bpy.data.batch_remove([curve for curve in curves if curve.users == 0])
    return len(curves)
