"""The sample room, like the one of the paper's figure 1: walls, pillars, furniture, and a step across a passage.

The room spans 7 x 8 m around the world's origin. Its far end is an alcove between the side walls that is reached only
over the step.
"""

from dataclasses import dataclass

import bpy
import numpy as np

from ...core.environment.regions import RegionRule
from ...core.motion.repertoire import STEP_OBSTACLE, STEP_TAG
from ..render.map_colors import OBSTACLE, STEP, linear

SIZE = (7.0, 8.0)
_WALL_THICKNESS, _WALL_HEIGHT = 0.12, 0.55
"""Walls are low, so that the room can be seen from outside."""

_STEP_Y = 1.45
STEP_MARGIN = 0.3
"""Metres by which the step is grown: the planted feet stay off it, and the root's travel in a step over spans it."""

# Name, centre x, y, size x, y, height; metres.
_FURNITURE = (
    ("Pillar A", -1.35, -0.55, 0.36, 0.36, 1.7),
    ("Pillar B", 1.45, -2.05, 0.36, 0.36, 1.7),
    ("Table", -2.2, -2.95, 1.1, 0.7, 0.74),
    ("Crate", 2.85, 0.1, 0.6, 0.6, 0.6),
    ("Cupboard", 0.4, 3.72, 1.3, 0.45, 0.9),
)


@dataclass(frozen=True)
class SampleRoom:
    """The objects of the room that settings refer to."""

    ground: bpy.types.Object
    step: bpy.types.Object


def add_sample_room(room, obstacles, regions) -> SampleRoom:
    """Build the room: the ground in the collection ``room``, what is in the way in ``obstacles``, the step in
    ``regions``.
    """
    width, depth = SIZE
    ground = _add("Ground", _plane(width, depth), room, "Wayfarer Ground", (0.22, 0.23, 0.25))
    outside = width + 2 * _WALL_THICKNESS
    for name, x, y, size_x, size_y in (
        ("Wall Left", -(width + _WALL_THICKNESS) / 2, 0.0, _WALL_THICKNESS, depth),
        ("Wall Right", (width + _WALL_THICKNESS) / 2, 0.0, _WALL_THICKNESS, depth),
        ("Wall Near", 0.0, -(depth + _WALL_THICKNESS) / 2, outside, _WALL_THICKNESS),
        ("Wall Far", 0.0, (depth + _WALL_THICKNESS) / 2, outside, _WALL_THICKNESS),
    ):
        wall = _add(name, _box(size_x, size_y, _WALL_HEIGHT), obstacles, "Wayfarer Obstacle", OBSTACLE)
        wall.location = (x, y, 0.0)
    for name, x, y, size_x, size_y, height in _FURNITURE:
        shape = _cylinder(size_x / 2, height) if name.startswith("Pillar") else _box(size_x, size_y, height)
        obj = _add(name, shape, obstacles, "Wayfarer Obstacle", OBSTACLE)
        obj.location = (x, y, 0.0)
    depth_of_step, height_of_step = STEP_OBSTACLE
    step = _add("Step", _box(width, depth_of_step, height_of_step), regions, "Wayfarer Step", STEP)
    step.location = (0.0, _STEP_Y, 0.0)
    return SampleRoom(ground, step)


def configure(settings, sample: SampleRoom, obstacles) -> None:
    """Make the scene's environment settings refer to the room; regions that were there before are replaced."""
    settings.ground, settings.obstacles = sample.ground, obstacles
    settings.regions.clear()
    region = settings.regions.add()
    region.object, region.rule, region.tag = sample.step, RegionRule.REQUIRE.name, STEP_TAG
    region.margin = STEP_MARGIN


def _add(name: str, shape, collection, material: str, color) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(*shape)
    mesh.materials.append(_material(material, color))
    obj = bpy.data.objects.new(name, mesh)
    collection.objects.link(obj)
    return obj


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


def _material(name: str, color):
    """A plain material in an sRGB colour, made once."""
    material = bpy.data.materials.get(name)
    if material is None:
        material = bpy.data.materials.new(name)
        if material.node_tree is None:  # before 5.0 nodes were optional
            material.use_nodes = True
        rgba = (*linear(color), 1.0)
        material.diffuse_color = rgba
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = rgba
        shader.inputs["Roughness"].default_value = 0.7
    return material
