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
