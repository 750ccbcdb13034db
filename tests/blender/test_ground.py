"""The ground rectangle: an object's, the obstacles', or typed in."""

import bpy
import numpy as np
import pytest

from bl_ext.user_default.wayfarer.addon.properties import GroundSource
from bl_ext.user_default.wayfarer.addon.results import staleness, store
from bl_ext.user_default.wayfarer.addon.scene.inputs import make_environment, read_shapes
from bl_ext.user_default.wayfarer.core.errors import SceneError

operators = bpy.ops.wayfarer


def shapes():
    return read_shapes(bpy.context.scene, bpy.context.evaluated_depsgraph_get())


@pytest.fixture
def environment():
    operators.add_sample_room()
    return bpy.context.scene.wayfarer.environment


def test_the_ground_is_the_object_at_first(environment):
    assert environment.source is GroundSource.OBJECT
    found = shapes()
    np.testing.assert_allclose((*found.low, *found.high), (-3.5, -4, 3.5, 4))
    environment.ground = None
    corners = shapes().obstacles.reshape(-1, 3)
    np.testing.assert_allclose(shapes().low, corners[:, :2].min(axis=0))


def test_the_obstacles_bounds(environment):
    environment.ground_source = GroundSource.BOUNDS.name
    before = shapes()
    bpy.data.objects["Table"].location.x += 20
    bpy.context.view_layer.update()
    after = shapes()
    assert after.high[0] > before.high[0] + 10
    corners = after.obstacles.reshape(-1, 3)
    np.testing.assert_allclose((*after.low, *after.high), (*corners[:, :2].min(axis=0), *corners[:, :2].max(axis=0)))
    assert after.ground_height == pytest.approx(corners[:, 2].min())
    environment.obstacles = None
    assert not environment.has_ground
    with pytest.raises(SceneError, match="There is no ground"):
        shapes()


def test_typed_in(environment):
    environment.ground_source = GroundSource.TYPED.name
    environment.ground_low, environment.ground_high, environment.ground_height = (-2, -1), (3, 2.5), 0.25
    found = shapes()
    assert (found.low, found.high, found.ground_height) == ((-2, -1), (3, 2.5), 0.25)
    environment.regions.clear()
    environment.cell_size = 0.25
    grid = make_environment(bpy.context.scene, shapes()).grid
    assert grid.shape[:2] == (20, 14) and grid.origin == (-2, -1)
    environment.ground_high[0] = -5
    with pytest.raises(SceneError, match="ground rectangle is empty"):
        make_environment(bpy.context.scene, shapes())


def test_typed_in_needs_neither_ground_nor_obstacles(sample_settings):
    environment = sample_settings.environment
    environment.ground = environment.obstacles = None
    environment.regions.clear()
    operators.build_motion_graph()
    assert not operators.embed.poll()
    environment.ground_source = GroundSource.TYPED.name
    environment.ground_low, environment.ground_high = (0, 0), (6, 5)
    assert operators.embed() == {"FINISHED"}
    embedding = store.results(bpy.context.scene).embedding
    assert embedding.shape[:2] == (24, 20) and embedding.n_nodes > 0
    assert not staleness.embedding_is_stale(bpy.context.scene)
    environment.ground_high[1] = 6
    assert staleness.embedding_is_stale(bpy.context.scene)


def test_radius_from_the_character():
    environment = bpy.context.scene.wayfarer.environment
    with pytest.raises(RuntimeError, match="Choose a character first"):
        bpy.ops.wayfarer.fit_radius()
    bpy.ops.wayfarer.add_sample_character()
    environment.radius = 1.0
    assert bpy.ops.wayfarer.fit_radius() == {"FINISHED"}
    assert 0.2 < environment.radius < 0.32


def floor_of(outline):
    """The ground becomes one face with these corners (x, y)."""
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(x, y, 0.0) for x, y in outline], [], [range(len(outline))])
    settings = bpy.context.scene.wayfarer.environment
    settings.ground.data = mesh
    settings.regions.clear()
    settings.obstacles = None
    settings.cell_size = 0.25
    bpy.context.view_layer.update()
    return settings.ground


U_SHAPE = ((-4, -4), (4, -4), (4, 4), (2, 4), (2, -2), (-2, -2), (-2, 4), (-4, 4))


def test_a_ground_is_walked_on_where_it_has_faces(environment):
    ground = floor_of(U_SHAPE)
    made = make_environment(bpy.context.scene, shapes())
    x, y = np.moveaxis(made.grid.positions(np.argwhere(np.ones(made.grid.shape[:2]))).reshape(32, 32, 2), -1, 0)
    assert np.array_equal(made.free_cells(), ~((abs(x) < 2) & (y > -2)))
    # Turned, it leaves the corners of the rectangle that holds it.
    full = floor_of(((-2, -2), (2, -2), (2, 2), (-2, 2)))
    assert shapes().ground is None
    full.rotation_euler.z = np.pi / 4
    bpy.context.view_layer.update()
    free = make_environment(bpy.context.scene, shapes()).free_cells()
    assert free[11, 11] and not free[0, 0] and 0.4 < free.mean() < 0.55
    assert ground is full


def test_another_outline_is_another_environment(environment):
    floor_of(U_SHAPE)
    before = shapes().fingerprint
    floor_of((*U_SHAPE[:4], (2, -3), (-2, -3), *U_SHAPE[6:]))
    assert shapes().fingerprint != before and (shapes().low, shapes().high) == ((-4, -4), (4, 4))


def test_mirrored_instances_are_solid(environment):
    floor_of(((-4, -4), (4, -4), (4, 4), (-4, 4)))
    solid, shown = bpy.data.collections.new("Solid"), bpy.data.collections.new("Shown")
    bpy.context.scene.collection.children.link(shown)
    bpy.ops.mesh.primitive_cube_add(size=2, location=(0.5, 0.5, 1))
    box = bpy.context.active_object
    solid.objects.link(box)
    bpy.context.collection.objects.unlink(box)
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", solid
    shown.objects.link(instance)
    environment.obstacles = shown
    free = []
    for scale in (1, -1):
        instance.scale.x = scale
        bpy.context.view_layer.update()
        free.append(make_environment(bpy.context.scene, shapes()).free_cells())
    assert np.array_equal(free[0], free[1][::-1]) and not free[0][15:20, 15:20].any()


@pytest.mark.parametrize("what", ["Pillar A", "Ground"])
def test_what_is_too_far_away_is_named(environment, what):
    bpy.data.objects[what].location = (500_000, 6_000_000, 1)
    bpy.context.view_layer.update()
    with pytest.raises(SceneError, match=f"'{what}' reaches farther than 1,000 km from the origin; move the scene to"):
        shapes()


@pytest.mark.parametrize(
    ("far", "cell", "told"), [(5e5, 0.1, True), (5e6, 0.1, True), (6e4, 0.1, False), (6e4, 0.05, True)]
)
@pytest.mark.parametrize("source", ["OBJECT", "TYPED", "BOUNDS"])
def test_a_ground_too_far_away_for_blenders_numbers_is_told(environment, source, far, cell, told):
    """Neighbouring numbers of single precision are 3 cm apart 500 km away, and half a metre 5,000 km away."""
    environment.ground_source, environment.cell_size = source, cell
    environment.ground_low, environment.ground_high = (far - 4, -4), (far, 4)
    for obj in (environment.ground, *environment.obstacles.objects):
        obj.location.x += far
    for region in environment.regions:
        region.object.location.x += far
    if told:
        with pytest.raises(SceneError, match="move the scene to the origin") as caught:
            shapes()
        assert far > 1e6 or f"{far / 1000:.0f}" in str(caught.value)
    else:
        assert shapes().high[0] == pytest.approx(far, abs=10)
