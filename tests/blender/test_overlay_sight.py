"""In which viewports the environment is in sight, as far as that can be told where nothing is drawn."""

import addon_utils
import bpy
import numpy as np
import pytest
from bpy.props import EnumProperty, PointerProperty

from bl_ext.user_default.wayfarer.addon.live import environment as environment_view

from .registered import EXTENSION


def viewports() -> list:
    return [area for area in bpy.context.window.screen.areas if area.type == "VIEW_3D"]


def test_the_check_box_says_whether_it_is_shown():
    area, scene = viewports()[0], bpy.context.scene
    overlay = scene.wayfarer.overlay
    assert not overlay.show_environment and not environment_view.windows_in_sight()
    overlay.show_environment = True
    assert environment_view.is_in_sight(scene, area)
    assert environment_view.windows_in_sight() == list(bpy.context.window_manager.windows)
    area.spaces.active.overlay.show_overlays = False
    assert not environment_view.is_in_sight(scene, area)
    area.spaces.active.overlay.show_overlays = True
    overlay.show_environment = False
    assert not environment_view.is_in_sight(scene, area) and not environment_view.windows_in_sight()


@pytest.fixture
def with_choice():
    """Instead of the extension: scenes with the choice that there was before, as far as a file keeps it."""

    class WayfarerOverlaySettings(bpy.types.PropertyGroup):
        show_environment: EnumProperty(
            items=[(name, name, "", "NONE", number) for number, name in enumerate(("NEVER", "ALWAYS", "WITH_PANEL"))]
        )

    class WayfarerSceneSettings(bpy.types.PropertyGroup):
        overlay: PointerProperty(type=WayfarerOverlaySettings)

    def fail(error: Exception):
        raise error

    addon_utils.disable(EXTENSION, default_set=True, handle_error=fail)
    for group in (WayfarerOverlaySettings, WayfarerSceneSettings):
        bpy.utils.register_class(group)
    bpy.types.Scene.wayfarer = PointerProperty(type=WayfarerSceneSettings)
    here = [True]

    def enable_extension():
        if here:
            here.clear()
            del bpy.types.Scene.wayfarer
            for group in (WayfarerSceneSettings, WayfarerOverlaySettings):
                bpy.utils.unregister_class(group)
            addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)

    yield enable_extension
    enable_extension()


def test_files_with_a_choice_keep_what_it_meant(with_choice, tmp_path):
    path = str(tmp_path / "old.blend")
    for name, choice in (("Off", "NEVER"), ("On", "ALWAYS"), ("Panel", "WITH_PANEL"), ("Untouched", None)):
        scene = bpy.data.scenes.new(name)
        if choice is not None:
            scene.wayfarer.overlay.show_environment = choice
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with_choice()
    bpy.ops.wm.open_mainfile(filepath=path)
    names = ("Off", "On", "Panel", "Untouched")
    found = {name: bpy.data.scenes[name].wayfarer.overlay.show_environment for name in names}
    assert found == {"Off": False, "On": True, "Panel": True, "Untouched": False}


def test_a_look_that_is_overtaken_by_a_change_is_followed_by_another(sample_settings):
    scene, environment = bpy.context.scene, sample_settings.environment

    def lines():
        return [found.points for found in environment_view.environment_view(scene).lines]

    def same(one, other) -> bool:
        return len(one) == len(other) and all(map(np.array_equal, one, other))

    def steps():
        return environment_view.look_steps(scene, bpy.context.evaluated_depsgraph_get())

    def end(begun) -> bool:
        while True:
            try:
                next(begun)
            except StopIteration as found:
                return found.value

    assert environment_view.look(scene, bpy.context.evaluated_depsgraph_get())
    before = lines()
    environment.radius += 0.1
    begun = steps()
    next(begun)
    environment.radius -= 0.1
    # That of the moment when it began.
    assert end(begun) and not same(lines(), before)
    assert end(steps()) and same(lines(), before)
    assert not end(steps())
    # What is wrong with it is told, and that it is no more.
    tag, environment.regions[0].tag = environment.regions[0].tag, ""
    assert end(steps()) and environment_view.environment_view(scene).error
    environment.regions[0].tag = tag
    assert end(steps()) and same(lines(), before) and not environment_view.environment_view(scene).error


def test_a_scene_that_takes_long_to_evaluate_is_read_at_once(sample_settings, monkeypatch):
    """By the next piece of work Blender may have made its data anew."""
    scene = bpy.context.scene
    scene.wayfarer.overlay.show_environment = True
    reads, read = [], environment_view.read_shapes
    monkeypatch.setattr(environment_view, "read_shapes", lambda *given: reads.append(given[0]) or read(*given))
    monkeypatch.setattr(environment_view, "_SLICE", 0.0)
    environment_view._tick()
    assert reads == [scene]
    for _ in range(100):
        environment_view._tick()
    assert reads == [scene] and environment_view.environment_view(scene).lines
