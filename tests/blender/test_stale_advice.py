"""An embedding that is out of date can be asked and walked in, and whoever does so is told."""

import bpy
import pytest

from bl_ext.user_default.wayfarer.addon.results.advice import stale_advice
from bl_ext.user_default.wayfarer.addon.ui.panels.floor_map import WAYFARER_PT_map
from bl_ext.user_default.wayfarer.addon.ui.panels.walk import WAYFARER_PT_walk

from .findings import operators, run
from .test_panel import Layout

WORDS = "The embedding is out of date, because ground, obstacles or regions have moved or changed; embed again"


@pytest.fixture
def settings(sample_settings):
    run("build_motion_graph", "embed")
    sample_settings.walk.duration = 4
    return sample_settings


def shown(panel) -> str:
    layout = Layout()
    panel.draw(type("Panel", (), {"layout": layout, "is_popover": False})(), bpy.context)
    return " ".join(text for kind, text, *_ in layout.drawn if kind == "text")


def move_table():
    bpy.data.objects["Table"].location.x += 0.5
    bpy.context.view_layer.update()


def test_who_walks_paints_or_asks_is_told(settings, capfd):
    scene = bpy.context.scene
    asking = ("paint_map", "random_walk", "find_weak_spots", "find_reach", "prune")
    run(*asking)
    assert stale_advice(scene) == [] and "out of date" not in capfd.readouterr().out
    move_table()
    assert stale_advice(scene) == [WORDS]
    for name in asking:
        capfd.readouterr()
        run(name)
        assert capfd.readouterr().out.count(f"Warning: {WORDS}") == 1, name
    run("embed")
    assert stale_advice(scene) == []


def test_the_panels_say_so_with_the_remedy(settings):
    for panel in (WAYFARER_PT_map, WAYFARER_PT_walk):
        assert "out of date" not in shown(panel)
    move_table()
    for panel in (WAYFARER_PT_map, WAYFARER_PT_walk):
        assert "embed again" in shown(panel) and "The embedding is out of date" in shown(panel)
    assert operators.embed() == {"FINISHED"}
    assert "out of date" not in shown(WAYFARER_PT_walk)
