"""The sample scenes: small files that hold what their plans say, and replace one another."""

import shutil

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.inputs import make_environment, read_shapes
from bl_ext.user_default.wayfarer.addon.sample import scene_file
from bl_ext.user_default.wayfarer.addon.sample.layouts import LAYOUTS, layout_of
from bl_ext.user_default.wayfarer.addon.sample.scene_objects import add_scene_objects, configure
from bl_ext.user_default.wayfarer.addon.scene_collections import OBSTACLES, REGIONS, ROOM, ensure_collection
from bl_ext.user_default.wayfarer.core.environment.regions import RegionRule

operators = bpy.ops.wayfarer


def environment():
    bpy.context.view_layer.update()
    scene = bpy.context.scene
    return make_environment(scene, read_shapes(scene, bpy.context.evaluated_depsgraph_get()))


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.key)
def test_files_are_small_and_hold_what_their_plans_say(layout):
    assert (scene_file.SCENES / layout.file_name).stat().st_size < 200_000
    assert operators.add_sample_room(sample=layout.key) == {"FINISHED"}
    shipped = environment()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    collections = [ensure_collection(bpy.context.scene, name) for name in (ROOM, OBSTACLES, REGIONS)]
    add_scene_objects(layout, *collections)
    configure(bpy.context.scene.wayfarer.environment, *collections)
    made = environment()
    assert shipped.grid == made.grid and np.array_equal(shipped.blocked, made.blocked)
    assert shipped.grid.tiled == layout.is_tiled and shipped.grid.size == pytest.approx(layout.size)
    assert shipped.grid.cell_size == pytest.approx(layout.cell_size) and 0.02 < shipped.blocked.mean() < 0.5
    assert [(r.name, r.rule, r.tag) for r in shipped.regions] == [(r.name, r.rule, r.tag) for r in made.regions]
    assert all(np.array_equal(a.mask, b.mask) for a, b in zip(shipped.regions, made.regions, strict=True))
    assert [r.rule for r in shipped.regions] == [RegionRule.REQUIRE] * len(layout.steps)


def test_files_open_on_their_own():
    bpy.ops.wm.open_mainfile(filepath=str(scene_file.SCENES / layout_of("TWO_STEPS").file_name))
    settings = bpy.context.scene.wayfarer.environment
    assert settings.ground.name == "Ground" and len(settings.regions) == 2 and len(settings.obstacles.objects) == 8


def test_a_scene_replaces_the_one_before_and_nothing_else():
    operators.add_sample_room()
    own = bpy.data.objects.new("Own", bpy.data.meshes.new("Own"))
    settings = bpy.context.scene.wayfarer.environment
    settings.obstacles.objects.link(own)
    n_materials = len(bpy.data.materials)
    operators.add_sample_room(sample="TILE")
    assert own.name in settings.obstacles.objects and "Table" not in bpy.data.objects
    assert settings.tiled and settings.ground.name == "Ground" and len(settings.regions) == 0
    operators.add_sample_room(sample="STEP_ROOM")
    assert not settings.tiled and settings.cell_size == pytest.approx(0.125) and len(settings.regions) == 1
    assert settings.regions[0].object.name == "Step" and settings.regions[0].margin == pytest.approx(0.3)
    assert len(bpy.data.materials) == n_materials and "Table" in bpy.data.objects
    assert len([mesh for mesh in bpy.data.meshes if mesh.name.startswith("Ground")]) == 1
    assert not list(bpy.data.libraries)
    # One collection of each kind, in this scene.
    assert [c.name for c in bpy.context.scene.collection.children] == [ROOM, OBSTACLES, REGIONS]


def test_a_file_that_is_none_is_refused(tmp_path, monkeypatch):
    shutil.copy(scene_file.SCENES / "room.blend", tmp_path / "step_room.blend")
    (tmp_path / "tile.blend").write_bytes(b"no blend")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "s_hall.blend"), copy=True)
    scene = bpy.context.scene
    scene_file.append_scene_file(scene, tmp_path / "step_room.blend")
    before = {obj.name for obj in scene.objects}
    for name, sentence in (("tile", "cannot be read"), ("absent", "cannot be read"), ("s_hall", "holds no sample")):
        with pytest.raises(Exception, match=sentence):
            scene_file.append_scene_file(scene, tmp_path / f"{name}.blend")
    assert {obj.name for obj in scene.objects} == before
