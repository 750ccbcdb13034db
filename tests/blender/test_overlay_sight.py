"""In which viewports the environment is in sight, as far as that can be told where nothing is drawn."""

import addon_utils
import bpy
import numpy as np
import pytest
from bpy.props import BoolProperty, PointerProperty

from bl_ext.user_default.wayfarer.addon.live import environment as environment_view
from bl_ext.user_default.wayfarer.addon.live import sight as environment_sight

from .registered import EXTENSION


def viewports() -> list:
    return [area for area in bpy.context.window.screen.areas if area.type == "VIEW_3D"]


def in_region(area, kind: str):
    """Overrides the context, as while a region of an area is laid out or drawn."""
    window = bpy.context.window_manager.windows[0]
    region = next(region for region in area.regions if region.type == kind)
    return bpy.context.temp_override(window=window, area=area, region=region)


def sidebar(area):
    return next(region for region in area.regions if region.type == "UI")


def draw_sidebar(area, panel: str) -> None:
    """What Blender does with a sidebar in which a panel is open."""
    with in_region(area, "UI"):
        if panel == "Environment":
            environment_sight.panel_is_drawn(bpy.context)
        environment_sight.sidebar_is_drawn(bpy.context)


def test_sidebars_are_drawn_before_viewports():
    kinds = [region.type for region in viewports()[0].regions]
    assert kinds.index("UI") < kinds.index("WINDOW")


def test_each_sidebar_has_the_panel_open_until_it_is_drawn_without_it():
    with in_region(viewports()[0], "WINDOW"):
        assert bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5) == {"FINISHED"}
    one, other = viewports()

    def is_open():
        return [environment_sight.panel_is_open(sidebar(area)) for area in (one, other)]

    assert is_open() == [False, False]
    draw_sidebar(one, "Environment")
    assert is_open() == [True, False]
    draw_sidebar(other, "Map")
    draw_sidebar(one, "Environment")
    assert is_open() == [True, False]
    draw_sidebar(other, "Environment")
    draw_sidebar(one, "Map")
    assert is_open() == [False, True]
    # Elsewhere than in a sidebar it tells nothing of one.
    with in_region(one, "WINDOW"):
        environment_sight.panel_is_drawn(bpy.context)
    assert not environment_sight._laid_out
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert not environment_sight._open, "another file has other sidebars"


def test_a_hidden_sidebar_shows_nothing_whatever_was_open_in_it():
    area, scene = viewports()[0], bpy.context.scene
    draw_sidebar(area, "Environment")
    # In the background no sidebar is wider than a hidden one.
    assert sidebar(area).width <= 1 and environment_sight.panel_is_open(sidebar(area))
    for is_shown in (False, True):
        area.spaces.active.show_region_ui = is_shown
        assert not environment_sight.is_in_sight(scene, area)


def test_always_and_never_ask_no_sidebar():
    area, scene = viewports()[0], bpy.context.scene
    overlay = scene.wayfarer.overlay
    assert overlay.show_environment == "WITH_PANEL" and not environment_sight.windows_in_sight()
    overlay.show_environment = "ALWAYS"
    assert environment_sight.is_in_sight(scene, area)
    assert environment_sight.windows_in_sight() == list(bpy.context.window_manager.windows)
    with in_region(area, "WINDOW"):
        assert environment_sight.viewport_is_drawn(bpy.context)
    area.spaces.active.overlay.show_overlays = False
    assert not environment_sight.is_in_sight(scene, area)
    area.spaces.active.overlay.show_overlays = True
    draw_sidebar(area, "Environment")
    overlay.show_environment = "NEVER"
    assert not environment_sight.is_in_sight(scene, area) and not environment_sight.windows_in_sight()


@pytest.fixture
def with_check_box():
    """Instead of the extension: scenes with the check box that there was before, as far as a file keeps it."""

    class WayfarerOverlaySettings(bpy.types.PropertyGroup):
        show_environment: BoolProperty()

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


def test_files_with_a_check_box_keep_what_it_meant(with_check_box, tmp_path):
    path = str(tmp_path / "old.blend")
    for name, ticked in (("Off", False), ("On", True), ("Untouched", None)):
        scene = bpy.data.scenes.new(name)
        if ticked is not None:
            scene.wayfarer.overlay.show_environment = ticked
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with_check_box()
    bpy.ops.wm.open_mainfile(filepath=path)
    found = {name: bpy.data.scenes[name].wayfarer.overlay.show_environment for name in ("Off", "On", "Untouched")}
    assert found == {"Off": "NEVER", "On": "ALWAYS", "Untouched": "WITH_PANEL"}


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
    scene.wayfarer.overlay.show_environment = "ALWAYS"
    reads, read = [], environment_view.read_shapes
    monkeypatch.setattr(environment_view, "read_shapes", lambda *given: reads.append(given[0]) or read(*given))
    monkeypatch.setattr(environment_view, "_SLICE", 0.0)
    environment_view._tick()
    assert reads == [scene]
    for _ in range(100):
        environment_view._tick()
    assert reads == [scene] and environment_view.environment_view(scene).lines
