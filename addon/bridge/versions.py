"""Differences between the supported versions of Blender, 4.5 LTS to 5.2 LTS: the only module that asks for the version.

What differs without being asked for is written so that it is right in all of them: slots of actions are named and
assigned, f-curves are reached through their channelbags.
"""

from collections.abc import Iterable
from typing import cast

import bpy

_FIVE = bpy.app.version >= (5, 0, 0)


def node_tree(owner) -> bpy.types.NodeTree:
    """The nodes of a material or world, which were optional before 5.0: new ones had none."""
    if owner.node_tree is None:
        owner.use_nodes = True
    return cast(bpy.types.NodeTree, owner.node_tree)


def keep_material_colors(objects: Iterable) -> None:
    """Let objects without a colour attribute keep their material's colour where solid mode colours by attribute.

    Blender 5.0 does so by itself. Versions before it show their object colour, which is white unless someone has
    chosen it; those that are white get the colour of their material.
    """
    if _FIVE:
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
