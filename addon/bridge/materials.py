"""Materials of our own: each made once, used by whatever wants it, and gone with the last that does.

Blender counts who uses a datablock, but removes what nobody uses only on saving: until then it is left behind.
"""

from collections.abc import Callable

import bpy

from .owned import is_called


def own_material(name: str, furnish: Callable[[bpy.types.Material], None]) -> bpy.types.Material:
    """The material of this name, as the artist may have changed it; if there is none, a new one that ``furnish`` has
    given its looks. One that is linked from another file is not ours: it goes when that file does."""
    material = bpy.data.materials.get((name, None))
    if material is None:
        material = bpy.data.materials.new(name)
        furnish(material)
    return material


def remove_unused_materials(names) -> None:
    """Remove the materials of these names that nobody uses: call it when something that had them is gone, or has got
    others. Those that someone has renamed, or given a fake user, stay."""
    names = list(names)
    bpy.data.batch_remove(
        [
            material
            for material in bpy.data.materials
            if material.users == 0 and material.library is None and any(is_called(material, name) for name in names)
        ]
    )
