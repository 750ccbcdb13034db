"""A sample scene as Blender objects, and what the environment settings must say about them.

The settings lie on the objects themselves, as custom properties, so that they come along wherever these are appended.
"""

import json

import bpy
import numpy as np

from ...core.environment.regions import RegionRule
from ...core.maps.colors import OBSTACLE, STEP, linear
from ...core.motion.repertoire import STEP_OBSTACLE, STEP_TAG
from ..bridge.materials import own_material
from ..bridge.versions import node_tree
from .layouts import STEP_MARGIN, Block, SceneLayout

GRID_PROPERTY = "wayfarer_grid"
"""On the ground: cell size (m), headings and whether it is tiled, as JSON."""

REGION_PROPERTY = "wayfarer_region"
"""On a region: rule, tag and margin (m), as JSON."""

SAMPLE_PROPERTY = "wayfarer_sample"
"""On every object: the key of the scene that it belongs to."""

MATERIALS = {"Wayfarer Ground": (0.22, 0.23, 0.25), "Wayfarer Obstacle": OBSTACLE, "Wayfarer Step": STEP}
"""sRGB colours."""

_GROUND, _OBSTACLE, _STEP = MATERIALS


def add_scene_objects(layout: SceneLayout, room, obstacles, regions) -> None:
    """Build a scene: the ground in the collection ``room``, what is in the way in ``obstacles``, steps in
    ``regions``."""
    ground = _add("Ground", _plane(*layout.size), room, _GROUND)
    ground[GRID_PROPERTY] = json.dumps(
        {"cell_size": layout.cell_size, "n_headings": layout.n_headings, "tiled": layout.is_tiled}
    )
    for block in layout.all_blocks():
        _add(block.name, _shape(block), obstacles, _OBSTACLE).location = (block.x, block.y, 0.0)
    depth, height = STEP_OBSTACLE
    for number, y in enumerate(layout.steps):
        name = "Step" if len(layout.steps) == 1 else f"Step {'AB'[number]}"
        step = _add(name, _box(layout.size[0], depth, height), regions, _STEP)
        step.location = (0.0, y, 0.0)
        step[REGION_PROPERTY] = json.dumps({"rule": RegionRule.REQUIRE.name, "tag": STEP_TAG, "margin": STEP_MARGIN})
    for collection in (room, obstacles, regions):
        for obj in collection.objects:
            obj[SAMPLE_PROPERTY] = layout.key


def configure(settings, room, obstacles, regions) -> None:
    """Make a scene's environment settings refer to the objects of these collections; regions that were there before
    are replaced."""
    # A painted floor has a property of this name, too, which is no text.
    settings.ground = next(obj for obj in room.objects if isinstance(obj.get(GRID_PROPERTY), str))
    settings.ground_source, settings.obstacles = "OBJECT", obstacles
    for name, value in json.loads(settings.ground[GRID_PROPERTY]).items():
        setattr(settings, name, value)
    settings.regions.clear()
    for obj in regions.objects:
        if REGION_PROPERTY in obj:
            region = settings.regions.add()
            region.object = obj
            for name, value in json.loads(obj[REGION_PROPERTY]).items():
                setattr(region, name, value)


def _add(name: str, shape, collection, material: str) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(*shape)
    mesh.materials.append(_material(material))
    obj = bpy.data.objects.new(name, mesh)
    collection.objects.link(obj)
    return obj


def _shape(block: Block):
    if block.is_round:
        return _cylinder(block.width / 2, block.height)
    return _box(block.width, block.depth, block.height)


def _plane(width: float, depth: float):
    x, y = width / 2, depth / 2
    return [(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [], [(0, 1, 2, 3)]


def _box(width: float, depth: float, height: float):
    """A box that stands on the origin."""
    bottom, _, _ = _plane(width, depth)
    vertices = bottom + [(x, y, height) for x, y, _ in bottom]
    sides = [(k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4)]
    return vertices, [], [(3, 2, 1, 0), (4, 5, 6, 7), *sides]


def _cylinder(radius: float, height: float, n: int = 32):
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    vertices = [(x, y, z) for z in (0.0, height) for x, y in ring.tolist()]
    sides = [(k, (k + 1) % n, (k + 1) % n + n, k + n) for k in range(n)]
    return vertices, [], [tuple(range(n - 1, -1, -1)), tuple(range(n, 2 * n)), *sides]


def _material(name: str):
    """A plain material in its colour, made once."""

    def furnish(material) -> None:
        rgba = (*linear(MATERIALS[name]), 1.0)
        material.diffuse_color = rgba
        shader = node_tree(material).nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = rgba
        shader.inputs["Roughness"].default_value = 0.7

    return own_material(name, furnish)
