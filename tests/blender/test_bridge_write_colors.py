"""The coloured ground."""

import bmesh
import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.write_colors import ATTRIBUTE, ground_grid, paint, painted_colors


def grid(nx=7, ny=5, **changes):
    place = {"x0": -1.0, "y0": 2.0, "cell_size": 0.25, "z": 0.01} | changes
    return ground_grid("Map", nx=nx, ny=ny, collection=bpy.context.scene.collection, **place)


def random_colors(nx, ny, seed=0):
    return np.random.default_rng(seed).random((nx, ny, 4), dtype=np.float32)


def painted(obj, attribute=ATTRIBUTE):
    layer = obj.data.color_attributes[attribute]
    values = np.empty(4 * len(layer.data), dtype=np.float32)
    layer.data.foreach_get("color", values)
    return values.reshape(-1, 4)


def test_each_cell_lies_in_its_place_with_its_colour():
    obj = grid()
    colors = random_colors(7, 5)
    paint(obj, colors)
    assert obj.name in bpy.context.scene.collection.objects
    corner_colors = painted(obj)
    centres = np.array([polygon.center for polygon in obj.data.polygons])
    for polygon, centre in zip(obj.data.polygons, centres, strict=True):
        ix, iy = int((centre[0] + 1) / 0.25), int((centre[1] - 2) / 0.25)
        np.testing.assert_allclose(centre, [-1 + (ix + 0.5) * 0.25, 2 + (iy + 0.5) * 0.25, 0.01], atol=1e-6)
        for vertex in polygon.vertices:
            np.testing.assert_array_equal(corner_colors[vertex], colors[ix, iy])
        assert polygon.normal.z == pytest.approx(1)
        assert polygon.area == pytest.approx(0.25**2)
    assert obj.data.validate() is False  # nothing to repair


def test_painting_again_reuses_mesh_and_material():
    obj = grid()
    paint(obj, random_colors(7, 5))
    mesh, n_materials = obj.data, len(bpy.data.materials)
    again = grid(x0=3.0)
    assert again == obj and again.data == mesh
    assert min(vertex.co.x for vertex in mesh.vertices) == pytest.approx(3)
    colors = random_colors(7, 5, seed=1)
    paint(again, colors)
    np.testing.assert_array_equal(painted(obj)[::4], colors.reshape(-1, 4))
    shown = again.evaluated_get(bpy.context.evaluated_depsgraph_get())
    np.testing.assert_array_equal(painted(shown)[::4], colors.reshape(-1, 4))
    assert len(mesh.color_attributes) == 1 and len(bpy.data.materials) == n_materials
    assert len(bpy.data.objects) == 1 and len(bpy.data.meshes) == 1


def test_another_size():
    paint(grid(), random_colors(7, 5))
    obj = grid(nx=4, ny=9)
    assert len(obj.data.polygons) == 36
    colors = random_colors(4, 9)
    paint(obj, colors)
    np.testing.assert_array_equal(painted(obj)[::4], colors.reshape(-1, 4))
    with pytest.raises(ValueError, match="cells"):
        paint(obj, random_colors(7, 5))


def test_attribute_is_the_one_that_is_shown():
    obj = grid()
    obj.data.color_attributes.new("Other", "FLOAT_COLOR", "POINT")
    paint(obj, random_colors(7, 5))
    assert obj.data.color_attributes.active_color.name == ATTRIBUTE
    assert obj.data.color_attributes[obj.data.color_attributes.render_color_index].name == ATTRIBUTE


def test_two_attributes_take_turns():
    obj = grid()
    for name in ("First", "Second", "First"):
        paint(obj, random_colors(7, 5), name)
        assert obj.data.color_attributes.active_color_name == name
        assert obj.data.materials[0].name == name


def merge(mesh):
    shape = bmesh.new()
    shape.from_mesh(mesh)
    bmesh.ops.remove_doubles(shape, verts=shape.verts, dist=1e-4)
    shape.to_mesh(mesh)
    shape.free()


def clear_materials(mesh):
    mesh.materials.clear()
    mesh.color_attributes.active_color = mesh.color_attributes.new("Own", "FLOAT_COLOR", "POINT")


def convert_colors(mesh):
    mesh.color_attributes.remove(mesh.color_attributes[ATTRIBUTE])
    mesh.color_attributes.new(ATTRIBUTE, "BYTE_COLOR", "CORNER")


def remove_colors(mesh):
    mesh.color_attributes.remove(mesh.color_attributes[ATTRIBUTE])
    mesh.materials.clear()


@pytest.mark.parametrize("meddle", [merge, clear_materials, convert_colors, remove_colors])
def test_whatever_someone_has_done_to_it_it_is_painted(meddle):
    obj = grid()
    paint(obj, random_colors(7, 5))
    meddle(obj.data)
    again = random_colors(7, 5, seed=1)
    assert grid() == obj
    paint(obj, again)
    np.testing.assert_array_equal(painted_colors(obj), again)
    assert len(obj.data.vertices) == 4 * 7 * 5 and obj.data.color_attributes.active_color_name == ATTRIBUTE
    assert [material.name for material in obj.data.materials] == [ATTRIBUTE]
    assert obj.data.validate() is False


def test_someone_elses_object_of_that_name_is_left_alone():
    other = bpy.data.objects.new("Map", bpy.data.meshes.new("Map"))
    bpy.context.scene.collection.objects.link(other)
    obj = grid()
    assert obj != other and len(other.data.polygons) == 0


@pytest.mark.parametrize("engine", ["BLENDER_WORKBENCH", "CYCLES"])
def test_pictures_show_the_colours(engine, tmp_path):
    obj = grid(nx=2, ny=1, x0=0.0, y0=0.0, cell_size=1.0)
    paint(obj, np.array([[[1, 0, 0, 1]], [[0, 0, 1, 1]]], dtype=np.float32))
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location = (1, 0.5, 5)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    scene.camera = camera
    scene.render.engine = engine
    scene.render.resolution_x, scene.render.resolution_y = 32, 16
    scene.view_settings.view_transform = "Standard"
    scene.display.shading.light, scene.display.shading.color_type = "FLAT", "VERTEX"
    scene.cycles.samples = 4
    scene.render.filepath = str(tmp_path / "map.png")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels[:]).reshape(16, 32, 4)
    np.testing.assert_allclose(pixels[8, 8, :3], [1, 0, 0], atol=0.02)
    np.testing.assert_allclose(pixels[8, 24, :3], [0, 0, 1], atol=0.02)


def test_every_cell_of_a_large_floor():
    for nx, ny in ((56, 64), (800, 800)):
        obj = ground_grid("Large", 0, 0, 0.125, nx, ny, 0, bpy.context.scene.collection)
        colors = random_colors(nx, ny)
        paint(obj, colors)
        np.testing.assert_array_equal(painted_colors(obj), colors)
        assert len(painted(obj)) == 4 * nx * ny


def test_every_collection_has_a_floor_of_its_own():
    scene = bpy.context.scene
    first, second = (bpy.data.collections.new(name) for name in ("One", "Two"))
    for collection in (first, second):
        scene.collection.children.link(collection)
    floors = [ground_grid("Floor", 0, 0, 0.5, n, n, 0, c) for n, c in ((4, first), (3, second))]
    assert floors[0] is not floors[1]
    assert [len(floor.data.polygons) for floor in floors] == [16, 9]
    floors[0].name, floors[0].location = "Renamed", (3, 0, 0)
    again = ground_grid("Floor", 0, 0, 0.5, 4, 4, 0, first)
    assert again == floors[0]
    assert tuple(again.matrix_world.translation) == (0, 0, 0)
