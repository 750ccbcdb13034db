"""Enabling and disabling the extension: it comes back whole, and leaves nothing behind."""

import sys

import addon_utils
import bpy
import pytest

from .registered import EXTENSION, traces


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
