"""What of a scene counts as obstacle and as ground, and what an artist is told where that may surprise."""

import contextlib
from dataclasses import asdict

import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix

from bl_ext.user_default.wayfarer.addon.live import environment
from bl_ext.user_default.wayfarer.addon.results import advice, staleness, store
from bl_ext.user_default.wayfarer.addon.results import file as storage
from bl_ext.user_default.wayfarer.addon.scene.inputs import obstacle_objects, read_shapes
from bl_ext.user_default.wayfarer.addon.scene.relief import lowest_floor
from bl_ext.user_default.wayfarer.addon.session import SESSION

from .test_bad_input import new_mesh_object
from .test_operators import build, fails_and_changes_nothing

operators = bpy.ops.wayfarer


@pytest.fixture
def settings(small_file, empty_scene):
    """The sample, everything coarse, on the whole of its ground."""
    bpy.ops.wm.open_mainfile(filepath=small_file)
    settings = bpy.context.scene.wayfarer
    settings.environment.ground_source = "OBJECT"
    settings.environment.regions[0].rule, settings.environment.regions[0].tag = "FORBID", "step"
    return settings


@pytest.fixture
def built(settings):
    build("build_motion_graph")
    return settings


def solid() -> set[str]:
    return {obj.name for obj in obstacle_objects(bpy.context.scene)}


def faces() -> int:
    bpy.context.view_layer.update()
    return len(read_shapes(bpy.context.scene, bpy.context.evaluated_depsgraph_get()).obstacles)


def warnings(capfd) -> list[str]:
    """What Embed warns of."""
    bpy.context.view_layer.update()
    capfd.readouterr()
    build("embed")
    said = capfd.readouterr()
    return [line.partition(": ")[2] for line in (said.out + said.err).splitlines() if line.startswith("Warning")]


def hang(obj, parent, **how):
    """Parent an object where it stands."""
    bpy.context.view_layer.update()
    obj.parent = parent
    obj.matrix_parent_inverse = parent.matrix_world.inverted()
    for name, value in how.items():
        setattr(obj, name, value)


def cube(name, collection, size=0.4):
    mesh, work = bpy.data.meshes.new(name), bmesh.new()
    bmesh.ops.create_cube(work, size=size)
    work.to_mesh(mesh)
    work.free()
    obj = bpy.data.objects.new(name, mesh)
    collection.objects.link(obj)
    return obj


# ----------------------------------------------------------------------------------------------- obstacles


@pytest.mark.parametrize("parent", ["ground", "region", "floor", "wall"])
def test_obstacles_on_the_ground_a_region_or_the_floor_stand_in_the_way(built, parent):
    build("embed", "paint_map")
    environment, scene = built.environment, bpy.context.scene
    nodes, names, triangles = store.results(scene).embedding.n_nodes, solid(), faces()
    assert len(names) > 5
    above = {
        "ground": environment.ground,
        "region": environment.regions[0].object,
        "floor": bpy.data.objects["Wayfarer Floor"],
        "wall": bpy.data.objects["Wall Far"],
    }[parent]
    for name in names - {above.name}:
        hang(bpy.data.objects[name], above)
    assert solid() == names and faces() == triangles
    build("embed")
    assert store.results(scene).embedding.n_nodes == nodes


def test_the_ground_and_the_regions_are_no_obstacles_themselves(settings):
    names, environment = solid(), settings.environment
    for obj in (environment.ground, environment.regions[0].object):
        environment.obstacles.objects.link(obj)
    assert solid() == names


def test_what_hangs_below_the_character_is_no_obstacle(built):
    build("embed")
    scene, environment, character = bpy.context.scene, built.environment, built.character
    nodes, names = store.results(scene).embedding.n_nodes, solid()
    sword, charm, tassel = (cube(name, environment.obstacles) for name in ("Sword", "Charm", "Tassel"))
    assert solid() == names | {"Sword", "Charm", "Tassel"}
    sword.parent, sword.parent_type, sword.parent_bone = character, "BONE", "RightHand"
    charm.parent, tassel.parent = sword, charm
    # A mesh may be deformed by the character without being its child.
    coat = cube("Coat", environment.obstacles)
    coat.modifiers.new("Armature", "ARMATURE").object = character
    hat = cube("Hat", environment.obstacles)
    hat.parent = coat
    bpy.context.view_layer.update()
    assert solid() == names
    build("embed", "random_walk")
    assert store.results(scene).embedding.n_nodes == nodes
    scene.frame_set(scene.frame_start + 40)
    assert not staleness.embedding_is_stale(scene)
    sword.parent = None
    assert solid() == names | {"Sword", "Charm", "Tassel"}


def test_copies_of_the_character_are_no_obstacles_nor_what_they_carry(built):
    build("embed", "walks_from", "crowd")
    environment, names = built.environment, solid()
    crowd = bpy.data.collections["Wayfarer Crowd"]
    environment.obstacles.children.link(crowd)
    hat = cube("Hat", environment.obstacles)
    hat.parent = next(obj for obj in crowd.objects if obj.type == "MESH")
    follower = cube("Follower", environment.obstacles)
    follower.parent = next(obj for obj in bpy.data.objects if obj.name.startswith("Wayfarer Walk from Here"))
    assert len(crowd.objects) > 2 and solid() == names
    # What was moved elsewhere is the artist's.
    moved = [*hat.parent.children_recursive, hat.parent]
    bystander = hat.parent
    bystander.parent = None
    bystander.modifiers.clear()
    environment.obstacles.objects.link(bystander)
    crowd.objects.unlink(bystander)
    assert solid() == names | {obj.name for obj in moved}


# --------------------------------------------------------------------------------------- hidden obstacles


def layer_collection(collection):
    found = [bpy.context.view_layer.layer_collection]
    for layer in found:
        if layer.collection == collection:
            return layer
        found += layer.children
    raise LookupError(collection.name)


def hide_all(obstacles):
    for obj in obstacles.all_objects:
        obj.hide_set(True)


def exclude(obstacles):
    layer_collection(obstacles).exclude = True


def hide_collection(obstacles):
    layer_collection(obstacles).hide_viewport = True


def unlink(obstacles):
    for parent in [bpy.context.scene.collection, *bpy.data.collections]:
        if obstacles.name in parent.children:
            parent.children.unlink(obstacles)


@pytest.mark.parametrize("hide", [hide_all, exclude, hide_collection, unlink])
def test_obstacles_that_are_all_hidden_are_told(built, hide, capfd):
    obstacles = built.environment.obstacles
    # A lamp is visible, but in nobody's way.
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT")))
    n_objects = len(solid())
    assert warnings(capfd) == []
    hide(obstacles)
    told = (
        f"None of the {n_objects} objects of '{obstacles.name}' is visible in this view layer, so that nothing stands "
        "in the way; show them, or choose another collection"
    )
    assert faces() == 0 and warnings(capfd) == [told]
    assert told in advice.embedding_advice(bpy.context.scene)


def test_one_hidden_obstacle_and_one_that_is_shown(built, capfd):
    obstacles = built.environment.obstacles
    hide_all(obstacles)
    table = bpy.data.objects["Table"]
    table.hide_set(False)
    assert warnings(capfd) == []
    for obj in [obj for obj in obstacles.all_objects if obj != table]:
        bpy.data.objects.remove(obj)
    table.hide_set(True)
    assert warnings(capfd)[0].startswith(f"The only object of '{obstacles.name}' is not visible in this view layer")
    built.environment.obstacles = bpy.data.collections.new("Nothing")
    assert warnings(capfd) == []


# -------------------------------------------------------------------------------------------------- ground


def new_ground(settings, name="Terrain", vertices=(), polygons=()):
    obj = new_mesh_object(name, vertices, polygons)
    bpy.context.scene.collection.objects.link(obj)
    settings.environment.ground = obj
    return obj


def bumps(size=8.0, n=9):
    """(vertices, polygons) of a plane in n x n vertices about the origin."""
    line = np.linspace(-size / 2, size / 2, n).tolist()
    points = [(x, y, 0.0) for x in line for y in line]
    corners = [
        (i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1) for i in range(n - 1) for j in range(n - 1)
    ]
    return points, corners


def triangles_of(obj):
    mesh = obj.data
    mesh.calc_loop_triangles()
    points = np.array([tuple(obj.matrix_world @ vertex.co) for vertex in mesh.vertices])
    return points[np.array([tuple(triangle.vertices) for triangle in mesh.loop_triangles])]


@pytest.mark.parametrize("flip", [False, True])
def test_a_ground_with_a_peak_is_told(built, capfd, flip):
    assert warnings(capfd) == []
    peaked = new_ground(built, "Terrain", *bumps())
    if flip:
        peaked.data.flip_normals()
    peaked.data.vertices[40].co.z = 3.0
    assert warnings(capfd)[0] == (
        "The ground 'Terrain' is not flat (0 m to 3.00 m), and walks are planned on its highest point; choose a flat "
        "ground"
    )
    assert store.results(bpy.context.scene).ground_height == 3.0
    # Nobody should move the character up there.
    assert not any("above" in sentence for sentence in advice.embedding_advice(bpy.context.scene))
    peaked.data.vertices[40].co.z = 0.01
    assert warnings(capfd) == []


@pytest.mark.parametrize("angle", [0.02, 0.1, 0.5])
def test_a_tilted_ground_is_told(built, capfd, angle):
    ground = built.environment.ground
    ground.rotation_euler.x = angle
    (sentence,) = [s for s in warnings(capfd) if "is not flat" in s]
    high = 4.0 * np.sin(angle)
    assert f"({-high:.2f} m to {high:.2f} m)" in sentence and f"'{ground.name}'" in sentence
    ground.rotation_euler.x = 0.0
    assert warnings(capfd) == []


def test_slabs_are_flat(built, capfd):
    """Their lower face is nobody's floor, whatever the scale and however the faces are wound."""
    slab = cube("Slab", bpy.context.scene.collection, 1.0)
    slab.scale, slab.location = (8, 8, 0.3), (0, 0, -0.15)
    built.environment.ground = slab
    assert warnings(capfd) == []
    slab.data.flip_normals()
    assert warnings(capfd) == []
    slab.scale.x = -8
    assert warnings(capfd) == []
    bevel = slab.modifiers.new("Bevel", "BEVEL")
    bevel.width = 0.005
    assert warnings(capfd) == []
    slab.rotation_euler.y = 0.1
    assert any("'Slab' is not flat" in sentence for sentence in warnings(capfd))


def test_a_ground_that_solidify_makes_a_slab(built, capfd):
    ground = new_ground(built, "Slab", *bumps())
    solidify = ground.modifiers.new("Solidify", "SOLIDIFY")
    solidify.thickness = 0.5
    assert warnings(capfd) == []


def test_what_looks_up_in_shapes_that_are_known():
    boxes = cube("Box", bpy.context.scene.collection, 2.0)
    for z, far in ((0.0, 0.0), (5.0, 300.0)):
        boxes.matrix_world = Matrix.Translation((far, far, z))
        bpy.context.view_layer.update()
        solid_box = triangles_of(boxes)
        for triangles in (solid_box, solid_box[:, ::-1]):
            assert lowest_floor(triangles, z + 0.98) is None
            assert lowest_floor(triangles, z + 1.01) == pytest.approx(z + 1.0)
            # A second one beside it, and lower.
            lower = triangles + (4.0, 0.0, -0.5)
            assert lowest_floor(np.concatenate([triangles, lower]), z + 0.98) == pytest.approx(z + 0.5)
    walls = solid_box[np.abs(np.cross(*np.moveaxis(np.diff(solid_box, axis=1), 1, 0))[:, 2]) < 1e-6]
    assert len(walls) == 8 and lowest_floor(walls, 10.0) is None
    assert lowest_floor(np.empty((0, 3, 3)), 0.0) is None


def test_a_room_in_one_mesh_is_told(built, capfd):
    """The top of its walls would be the floor."""
    room = new_ground(built, "Room", *bumps())
    mesh = bmesh.new()
    mesh.from_mesh(room.data)
    for edge in [edge for edge in mesh.edges if edge.is_boundary]:
        made = bmesh.ops.extrude_edge_only(mesh, edges=[edge])["geom"]
        bmesh.ops.translate(
            mesh, vec=(0, 0, 2.5), verts=[part for part in made if isinstance(part, bmesh.types.BMVert)]
        )
    mesh.to_mesh(room.data)
    mesh.free()
    assert any("'Room' is not flat" in sentence and "2.50 m" in sentence for sentence in warnings(capfd))


def test_what_was_told_of_a_ground_is_kept_with_the_file(built, tmp_path, capfd):
    built.environment.ground.rotation_euler.x = 0.2
    before = warnings(capfd)
    assert any("is not flat" in sentence for sentence in before)
    path = str(tmp_path / "tilted.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert advice.embedding_advice(bpy.context.scene) == before


@pytest.mark.parametrize("bad", [["Ground"], ["Ground", "low", 1.0], [1.0, 2.0, 3.0], ["Ground", 0.0, 1.0, 2.0]])
def test_a_damaged_note_of_the_ground_is_refused(bad):
    with pytest.raises(ValueError, match="do not fit together"):
        storage._summary({**asdict(store.Summary()), "uneven": bad})


def test_typed_in_grounds_are_flat(built, capfd):
    built.environment.ground.rotation_euler.x = 0.5
    built.environment.ground_source = "TYPED"
    assert not any("flat" in sentence for sentence in warnings(capfd))


def test_grounds_without_faces_are_named(built):
    scene, environment = bpy.context.scene, built.environment
    library = bpy.data.collections.new("Set")
    library.objects.link(environment.ground)
    instance = bpy.data.objects.new("Set Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", library
    upright = new_mesh_object("Poster", *bumps())
    upright.rotation_euler.x = np.pi / 2
    for obj in (bpy.data.objects.new("Marker", None), instance, upright, new_mesh_object("Nothing")):
        scene.collection.objects.link(obj)
        environment.ground = obj
        bpy.context.view_layer.update()
        said = fails_and_changes_nothing(operators.embed)
        assert f"The ground '{obj.name}' has no faces to walk on; choose a mesh that lies flat." in said


def test_an_outline_is_a_ground_like_before(built, capfd):
    """Edges without faces tell how large it is, too."""
    outline = new_ground(built, "Outline", [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)])
    assert outline.data.polygons.values() == [] and warnings(capfd) == []


def test_what_stands_on_the_ground_and_is_no_obstacle_is_told(built, capfd):
    scene = bpy.context.scene
    assert warnings(capfd) == [] and advice.unlisted_advice(scene) == []
    box = cube("Cube", scene.collection, 1.0)
    box.location = (0.5, 0.5, 0.5)
    for name, z, size in (("Rug", 0.0, 0.02), ("Lamp", 3.0, 0.5), ("Sky", 0.0, 200.0)):
        cube(name, scene.collection, size).location.z = z
    cube("Far", scene.collection, 1.0).location = (500.0, 0.0, 0.5)
    (told,) = warnings(capfd)
    assert told.startswith("'Cube' stands on the ground") and "Add to Obstacles" in told
    box.hide_set(True)
    assert warnings(capfd) == []
    box.hide_set(False)
    operators.add_obstacles()
    assert box.name in built.environment.obstacles.objects and "Cube" in solid()
    assert warnings(capfd) == []
    assert "an obstacle already" in fails_and_changes_nothing(operators.add_obstacles)


def test_the_first_obstacle_makes_a_collection(built, capfd):
    built.environment.obstacles = None
    for obj in [obj for obj in bpy.context.scene.objects if obj.type == "MESH" and obj != built.environment.ground]:
        if obj.parent is None and obj.find_armature() is None and obj != built.environment.regions[0].object:
            bpy.data.objects.remove(obj)
    box = cube("Cube", bpy.context.scene.collection, 1.0)
    bpy.context.view_layer.update()
    operators.add_obstacles()
    assert [*built.environment.obstacles.objects] == [box] and warnings(capfd) == []


@contextlib.contextmanager
def alone(obj):
    """A viewport that shows nothing but an object."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        for other in bpy.context.view_layer.objects:
            other.select_set(other == obj)
        bpy.ops.view3d.localview(frame_selected=False)
        yield
        bpy.ops.view3d.localview(frame_selected=False)


def test_a_local_view_leaves_no_obstacle_out(built, capfd):
    """Neither in the environment, nor in what is drawn of it, nor in what is reported."""
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    said, everything = warnings(capfd), read_shapes(scene, depsgraph)
    embedded = store.embedding_of(scene)
    environment.look(scene, depsgraph)
    drawn = environment.environment_view(scene)
    with alone(built.environment.ground):
        assert not any(obj.visible_get() for obj in built.environment.obstacles.all_objects)
        assert read_shapes(scene, depsgraph).fingerprint == everything.fingerprint and len(everything.pieces) > 1
        SESSION.clear()
        environment.look(scene, depsgraph)
        again = environment.environment_view(scene)
        assert len(again.lines) == len(drawn.lines) > 1
        assert all(np.array_equal(a.points, b.points) for a, b in zip(again.lines, drawn.lines, strict=True))
        build("build_motion_graph")
        assert warnings(capfd) == said == []
        assert np.array_equal(store.embedding_of(scene).environment.blocked, embedded.environment.blocked)
        assert store.embedding_of(scene).n_nodes == embedded.n_nodes > 0
