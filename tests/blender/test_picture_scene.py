"""Pictures leave the file as it was."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.write_colors import ground_grid, paint
from bl_ext.user_default.wayfarer.tools.pictures import view_picture
from bl_ext.user_default.wayfarer.tools.pictures.legend import Legend
from bl_ext.user_default.wayfarer.tools.pictures.map_picture import MapScene
from bl_ext.user_default.wayfarer.tools.pictures.picture_scene import picture_scene

BLOCKS = ("scenes", "worlds", "objects", "meshes", "curves", "materials", "cameras", "lights", "fonts", "node_groups")


def contents() -> dict[str, list[str]]:
    return {kind: [block.name for block in getattr(bpy.data, kind)] for kind in BLOCKS}


@pytest.fixture
def floor():
    """A painted floor of 2 x 2 m."""
    obj = ground_grid("Floor", -1.0, -1.0, 1.0, 2, 2, 0.0, bpy.context.scene.collection)
    paint(obj, np.ones((2, 2, 4)))
    return obj


def test_a_legend_leaves_nothing_behind():
    # Someone has a material of the name that ours would have.
    own = bpy.data.materials.new("Wayfarer 0.860-0.870-0.890")
    before, color = contents(), tuple(own.diffuse_color)
    with picture_scene("Picture") as picture:
        legend = Legend(picture, 0.0, 0.0, 0.0, 1.0)
        legend.title("Title")
        legend.note("Note")
        legend.title("Another")
        legend.ramp("few", "many")
        # One material for each colour, made once: of two titles, of notes, and of 48 greys.
        assert len(bpy.data.materials) == 1 + 2 + 48
    assert contents() == before and tuple(own.diffuse_color) == color


def test_a_font_that_was_there_stays():
    text = bpy.data.curves.new("Own", "FONT")
    bpy.data.curves.remove(text)
    before = contents()
    assert before["fonts"]
    with picture_scene("Picture") as picture:
        Legend(picture, 0.0, 0.0, 0.0, 1.0).title("Title")
    assert contents() == before


def test_a_view_leaves_nothing_behind(floor, tmp_path, monkeypatch):
    monkeypatch.setattr(view_picture, "_SIZE", (32, 20))
    monkeypatch.setattr(view_picture, "_SAMPLES", 1)
    before = contents()
    shown = MapScene(floor, (), (), None, (-1.0, -1.0), (1.0, 1.0), 0.0)
    view_picture.draw_view(tmp_path / "view.png", shown, [floor], [1, 2])
    assert (tmp_path / "view.png").stat().st_size > 0
    assert contents() == before
