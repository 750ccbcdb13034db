"""Enabling and disabling the extension: it comes back whole, and leaves nothing behind."""

import sys
from collections.abc import Iterator

import addon_utils
import bpy
import pytest

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


def fail(error: Exception):
    raise error


def test_is_enabled(wayfarer):
    assert addon_utils.check(EXTENSION) == (True, True)
    assert wayfarer.__name__ == EXTENSION
    assert EXTENSION + ".addon" in sys.modules


def test_leaves_nothing_behind(wayfarer):
    enabled = traces()
    for _ in range(2):
        addon_utils.disable(EXTENSION, default_set=True, handle_error=fail)
        assert traces() == set()
        assert EXTENSION not in bpy.context.preferences.addons
        addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)
        assert traces() == enabled


def test_survives_a_new_file(wayfarer):
    enabled = traces()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert traces() == enabled


@pytest.fixture
def forgotten():
    """Things that a careless extension would leave behind."""
    inside = {"__module__": EXTENSION + ".forgotten"}
    group = type("ForgottenGroup", (bpy.types.PropertyGroup,), dict(inside))
    panel = {"bl_space_type": "VIEW_3D", "bl_region_type": "UI", "bl_label": "", "draw": lambda self, _: None}
    classes = (group, type("VIEW3D_PT_forgotten", (bpy.types.Panel,), {**inside, **panel}))

    def drawer(self, context):
        pass

    drawer.__module__ = EXTENSION + ".forgotten"
    for cls in classes:
        bpy.utils.register_class(cls)
    bpy.types.Scene.forgotten = bpy.props.PointerProperty(type=group)
    bpy.app.handlers.load_post.append(drawer)
    bpy.types.VIEW3D_MT_object.append(drawer)
    yield {"class ForgottenGroup", "class VIEW3D_PT_forgotten", "property Scene.forgotten"} | {
        f"handler load_post: {drawer}",
        "entry in VIEW3D_MT_object",
    }
    bpy.types.VIEW3D_MT_object.remove(drawer)
    bpy.app.handlers.load_post.remove(drawer)
    del bpy.types.Scene.forgotten
    for cls in classes:
        bpy.utils.unregister_class(cls)


def test_would_see_what_is_left_behind(forgotten):
    assert forgotten <= traces()
