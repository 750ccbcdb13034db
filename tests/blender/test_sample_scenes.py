"""The sample scenes: small files that hold what their plans say, and replace one another."""

import shutil

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.owned import OBSTACLES, OUTPUT, REGIONS, ROOM, ensure_collection
from bl_ext.user_default.wayfarer.addon.bridge.write_colors import ground_grid
from bl_ext.user_default.wayfarer.addon.render.floor import find_floor
from bl_ext.user_default.wayfarer.addon.sample import scene_file
from bl_ext.user_default.wayfarer.addon.sample.layouts import LAYOUTS, layout_of
from bl_ext.user_default.wayfarer.addon.sample.scene_objects import MATERIALS, add_scene_objects, configure
from bl_ext.user_default.wayfarer.addon.scene.inputs import make_environment, read_shapes
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
    # Nothing of the scene before is left behind: this one has no step.
    assert all(block.users for blocks in (bpy.data.meshes, bpy.data.materials) for block in blocks)
    operators.add_sample_room(sample="STEP_ROOM")
    assert not settings.tiled and settings.cell_size == pytest.approx(0.1) and len(settings.regions) == 1
    assert settings.regions[0].object.name == "Step" and settings.regions[0].margin == pytest.approx(0.3)
    assert len(bpy.data.materials) == n_materials and "Table" in bpy.data.objects
    assert len([mesh for mesh in bpy.data.meshes if mesh.name.startswith("Ground")]) == 1
    assert {m.name for m in bpy.data.materials} == set(MATERIALS)
    assert not list(bpy.data.libraries)
    # One collection of each kind, in this scene.
    assert [c.name for c in bpy.context.scene.collection.children] == [ROOM, OBSTACLES, REGIONS]


def test_a_ground_is_no_painted_floor():
    """Even where the collections have changed their names: both objects say in a property of one name how they are cut
    into cells."""
    operators.add_sample_room()
    scene, ground = bpy.context.scene, bpy.data.objects["Ground"]
    room = scene.wayfarer.environment.ground.users_collection[0]
    room.name = OUTPUT
    assert find_floor(scene) is None
    floor = ground_grid("Floor", 0.0, 0.0, 0.5, 2, 2, 0.0, room)
    assert floor != ground and find_floor(scene) == floor
    assert len(ground.data.polygons) == 1
    # And the other way round.
    room.name = ROOM
    room.objects.unlink(ground)
    room.objects.link(ground)
    assert [obj.name for obj in room.objects] == ["Floor", "Ground"]
    assert operators.add_sample_room() == {"FINISHED"}
    assert scene.wayfarer.environment.ground.name == "Ground" and floor.name in room.objects


def test_an_overridden_room_is_not_ours_to_change(tmp_path):
    operators.add_sample_room()
    path = str(tmp_path / "room.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, here):
        here.collections = [REGIONS]
    scene = bpy.context.scene
    override = here.collections[0].override_hierarchy_create(scene, bpy.context.view_layer)
    before = [obj.name for obj in override.objects]
    assert operators.add_sample_room() == {"FINISHED"}
    assert [obj.name for obj in override.objects] == before
    assert scene.wayfarer.environment.regions[0].object.override_library is None


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
