"""What the extension has registered with Blender at a moment; also for scripts that run without pytest."""

from collections.abc import Iterator

import bpy

EXTENSION = "bl_ext.user_default.wayfarer"
MENU_LIKE = (bpy.types.Panel, bpy.types.Menu, bpy.types.Header)


def subclasses(base: type) -> Iterator[type]:
    for cls in base.__subclasses__():
        yield cls
        yield from subclasses(cls)


def is_ours(thing: object) -> bool:
    module = getattr(thing, "__module__", None) or ""
    return module == EXTENSION or module.startswith(EXTENSION + ".")


def types_with_data() -> list[type]:
    """Every type that an extension may hang properties on; asked for by name, because Blender makes them late."""
    owners = (bpy.types.ID, bpy.types.Bone, bpy.types.PoseBone, bpy.types.TimelineMarker)
    kinds = [getattr(bpy.types, name) for name in dir(bpy.types)]
    return [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, owners)]


def blender_properties() -> set[str]:
    """Every property of those types, as Type.property."""
    # Iterating over the collection itself would give the properties, not their names.
    names = {owner.__name__: owner.bl_rna.properties.keys() for owner in types_with_data()}
    return {f"{owner}.{name}" for owner in names for name in names[owner]}


BUILT_IN_PROPERTIES = blender_properties()


def traces() -> set[str]:
    """What the extension has registered with Blender at this moment, one line a thing."""
    bases = subclasses(bpy.types.bpy_struct)
    found = {f"class {cls.__name__}" for cls in bases if is_ours(cls) and cls.is_registered}
    found |= {f"property {name}" for name in blender_properties() - BUILT_IN_PROPERTIES}
    for name in dir(bpy.app.handlers):
        handlers = getattr(bpy.app.handlers, name)
        if isinstance(handlers, list):
            found |= {f"handler {name}: {function}" for function in handlers if is_ours(function)}
    for cls in (cls for base in MENU_LIKE for cls in subclasses(base)):
        drawers = getattr(getattr(cls, "draw", None), "_draw_funcs", ())
        found |= {f"entry in {cls.__name__}" for function in drawers if is_ours(function)}
    keymaps = bpy.context.window_manager.keyconfigs.addon.keymaps
    for keymap in keymaps:
        found |= {f"key {item.idname}" for item in keymap.keymap_items if item.idname.startswith("wayfarer.")}
    return found
