"""Triangles of evaluated scenes."""

import bmesh
import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.bridge.read_scene import read_triangles
from bl_ext.user_default.wayfarer.core.errors import SceneError


def cube(name="Cube", location=(0, 0, 0), collection=None):
    mesh = bpy.data.meshes.new(name)
    work = bmesh.new()
    bmesh.ops.create_cube(work, size=1.0)
    work.to_mesh(mesh)
    work.free()
    obj = bpy.data.objects.new(name, mesh)
    obj.location = location
    (collection or bpy.context.scene.collection).objects.link(obj)
    return obj


def triangles_of(*objects):
    return read_triangles(objects, bpy.context.evaluated_depsgraph_get())


def area(triangles):
    sides = triangles[:, 1:] - triangles[:, :1]
    return np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum() / 2


def bounds(triangles):
    return triangles.reshape(-1, 3).min(axis=0), triangles.reshape(-1, 3).max(axis=0)


def test_world_space():
    obj = cube()
    obj.location, obj.scale, obj.rotation_euler.z = (1, 2, 3), (2, 1, 1), np.pi / 2
    triangles = triangles_of(obj)
    assert triangles.shape == (12, 3, 3) and triangles.dtype == np.float64
    low, high = bounds(triangles)
    np.testing.assert_allclose(low, [0.5, 1, 2.5], atol=1e-6)
    np.testing.assert_allclose(high, [1.5, 3, 3.5], atol=1e-6)
    assert area(triangles) == pytest.approx(10)


def test_only_the_objects_asked_for():
    one, _ = cube("One"), cube("Two", (5, 0, 0))
    assert len(triangles_of(one)) == 12
    assert triangles_of().shape == (0, 3, 3)


def test_modifiers():
    obj = cube()
    modifier = obj.modifiers.new("Array", "ARRAY")
    modifier.count = 3
    triangles = triangles_of(obj)
    assert len(triangles) == 36
    assert bounds(triangles)[1][0] == pytest.approx(2.5)


def test_collection_instances():
    hidden = bpy.data.collections.new("Library")  # not linked to the scene
    cube("A", (0, 0, 0), hidden)
    cube("B", (2, 0, 0), hidden)
    empty = bpy.data.objects.new("Instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", hidden
    empty.location.z = 10
    bpy.context.scene.collection.objects.link(empty)
    triangles = triangles_of(empty)
    assert len(triangles) == 24
    np.testing.assert_allclose(bounds(triangles), [[-0.5, -0.5, 9.5], [2.5, 0.5, 10.5]], atol=1e-6)


def test_geometry_node_instances():
    cube_to_place = cube("Placed", (100, 0, 0))
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    line = tree.nodes.new("GeometryNodeMeshLine")
    line.inputs["Count"].default_value = 4
    line.inputs["Offset"].default_value = (3, 0, 0)
    info = tree.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value = cube_to_place
    info.inputs["As Instance"].default_value = True
    place = tree.nodes.new("GeometryNodeInstanceOnPoints")
    output = tree.nodes.new("NodeGroupOutput")
    tree.links.new(line.outputs["Mesh"], place.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], place.inputs["Instance"])
    tree.links.new(place.outputs["Instances"], output.inputs["Geometry"])
    carrier = cube("Carrier")
    carrier.location.y = 5
    carrier.modifiers.new("Scatter", "NODES").node_group = tree
    triangles = triangles_of(carrier)
    assert len(triangles) == 48
    np.testing.assert_allclose(bounds(triangles), [[-0.5, 4.5, -0.5], [9.5, 5.5, 0.5]], atol=1e-6)


def test_generated_meshes_as_instances():
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    points = tree.nodes.new("GeometryNodePoints")
    points.inputs["Count"].default_value = 3
    shape = tree.nodes.new("GeometryNodeMeshCube")
    place = tree.nodes.new("GeometryNodeInstanceOnPoints")
    output = tree.nodes.new("NodeGroupOutput")
    tree.links.new(points.outputs[0], place.inputs["Points"])
    tree.links.new(shape.outputs["Mesh"], place.inputs["Instance"])
    tree.links.new(place.outputs["Instances"], output.inputs["Geometry"])
    carrier = cube("Carrier", (0, 0, 4))
    carrier.modifiers.new("Scatter", "NODES").node_group = tree
    triangles = triangles_of(carrier)
    assert len(triangles) == 36
    np.testing.assert_allclose(bounds(triangles), [[-0.5, -0.5, 3.5], [0.5, 0.5, 4.5]], atol=1e-6)


def test_curves_text_and_metaballs():
    curve = bpy.data.curves.new("Pipe", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.1
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[1].co = (2, 0, 0, 1)
    text = bpy.data.curves.new("Text", "FONT")
    text.body, text.extrude = "A", 0.1
    ball = bpy.data.metaballs.new("Ball")
    ball.elements.new()
    objects = [bpy.data.objects.new(data.name, data) for data in (curve, text, ball)]
    for obj in objects:
        bpy.context.scene.collection.objects.link(obj)
        triangles = triangles_of(obj)
        assert len(triangles) > 10, obj.name
        once = {tuple(triangle.ravel().round(6)) for triangle in triangles}
        assert len(once) == len(triangles), f"{obj.name} was read twice"
    length = bounds(triangles_of(objects[0]))
    assert length[1][0] == pytest.approx(2, abs=1e-5) and length[1][2] == pytest.approx(0.1, abs=1e-3)


def test_without_faces():
    points = bpy.data.meshes.new("Points")
    points.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    objects = [
        bpy.data.objects.new("Points", points),
        bpy.data.objects.new("Empty", None),
        bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT")),
        bpy.data.objects.new("Line", bpy.data.curves.new("Line", "CURVE")),
    ]
    for obj in objects:
        bpy.context.scene.collection.objects.link(obj)
    assert triangles_of(*objects).shape == (0, 3, 3)


def test_hidden_objects_do_not_count():
    globally, by_eye = cube("Globally"), cube("By eye")
    globally.hide_viewport = True
    bpy.context.view_layer.update()
    by_eye.hide_set(True)
    assert len(triangles_of(globally, by_eye)) == 0


@pytest.mark.parametrize("shown", [True, False])
def test_duplis_on_faces(shown):
    carrier, copied = cube("Carrier", (0, 0, 5)), cube("Copied", (0, 0, 0))
    copied.parent = carrier
    copied.scale = (0.1, 0.1, 0.1)
    carrier.instance_type = "FACES"
    carrier.show_instancer_for_viewport = shown
    triangles = triangles_of(carrier)
    assert len(triangles) == 6 * 12 + (12 if shown else 0)
    assert area(triangles) == pytest.approx(6 * 0.06 + (6 if shown else 0), rel=1e-4)


def test_edit_mode():
    obj = cube()
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        assert len(triangles_of(obj)) == 12
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def test_not_a_number():
    obj = cube("Broken")
    obj.data.vertices[3].co.x = float("nan")
    with pytest.raises(SceneError, match="'Broken'"):
        triangles_of(obj)


def test_many_triangles_are_those_of_the_slow_way():
    mesh = bpy.data.meshes.new("Grid")
    work = bmesh.new()
    bmesh.ops.create_grid(work, x_segments=224, y_segments=224, size=5.0)
    for vertex in work.verts:
        vertex.co.z = np.sin(3 * vertex.co.x) * vertex.co.y
    work.to_mesh(mesh)
    work.free()
    obj = bpy.data.objects.new("Grid", mesh)
    obj.location = (1, 2, 3)
    bpy.context.scene.collection.objects.link(obj)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    triangles = read_triangles([obj], depsgraph)
    assert len(triangles) == 2 * 224**2
    mesh.calc_loop_triangles()
    slow = [[obj.matrix_world @ mesh.vertices[i].co for i in t.vertices] for t in list(mesh.loop_triangles)[::1000]]
    np.testing.assert_allclose(triangles[::1000], np.array(slow), atol=1e-5)
