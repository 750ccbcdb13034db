"""Solid mode in colours of attributes, and the objects that have none."""

from collections.abc import Iterable

import bpy


def keep_material_colors(objects: Iterable) -> None:
    """Let objects without a colour attribute keep their material's colour where solid mode colours by attribute.

    Blender 5.0 does so by itself. Versions before it show their object colour, which is white unless someone has
    chosen it; those that are white get the colour of their material.
    """
    if bpy.app.version >= (5, 0, 0):
        return
    for obj in objects:
        material = obj.active_material
        if (
            material is not None
            and obj.is_editable
            and tuple(obj.color) == (1.0, 1.0, 1.0, 1.0)
            and not getattr(obj.data, "color_attributes", ())
        ):
            obj.color = material.diffuse_color
