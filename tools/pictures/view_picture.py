"""The scene in perspective, with the character at several moments of its walk."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...addon.bridge.versions import node_tree
from ...addon.bridge.write_colors import ATTRIBUTE
from .map_picture import MapScene
from .picture_scene import PictureScene, opaque, picture_scene

_BACKDROP = (0.13, 0.14, 0.16)
_SIZE = (1280, 800)
_SAMPLES = 10
_FILLED = 0.94
"""Part of the picture's width or height that the ground takes up."""
_MOMENTS = 9
_APART = 1.15
"""Metres between two figures, so that each can be seen on its own."""


def choose_moments(path: np.ndarray, preferred: np.ndarray | None = None, n: int = _MOMENTS) -> list[int]:
    """Frames of a walk's (F, 3) path at which figures do not stand in each other's way, in order of time.

    One frame in the middle of the stretches marked in ``preferred`` (F,) comes first, then others that lie as far
    from all chosen ones as possible.
    """
    chosen: list[int] = []
    if preferred is not None and preferred.any():
        marked = np.flatnonzero(preferred)
        first_stretch = marked[: np.flatnonzero(np.diff(np.append(marked, marked[-1] + 9)) > 1)[0] + 1]
        chosen.append(int(first_stretch[len(first_stretch) // 2]))
    else:
        chosen.append(0)
    distance = np.linalg.norm(path[:, :2] - path[chosen[0], :2], axis=1)
    while len(chosen) < n:
        farthest = int(np.argmax(distance))
        if distance[farthest] < _APART:
            break
        chosen.append(farthest)
        distance = np.minimum(distance, np.linalg.norm(path[:, :2] - path[farthest, :2], axis=1))
    return sorted(chosen)


def draw_view(path: Path, shown: MapScene, bodies: Sequence, frames: Sequence[int]) -> None:
    """Write ``path`` as PNG: the scene and frozen copies of ``bodies`` (objects) at the scene's ``frames``."""
    scene = bpy.context.scene
    before = scene.frame_current
    with picture_scene("Wayfarer View Picture") as picture:
        picture.show([*shown.obstacles, *shown.regions, shown.walk])
        _add_lit_floor(picture, shown.floor)
        for frame in frames:
            scene.frame_set(frame)
            depsgraph = bpy.context.evaluated_depsgraph_get()
            for body in bodies:
                evaluated = body.evaluated_get(depsgraph)
                frozen = bpy.data.meshes.new_from_object(evaluated)
                picture.add("Moment", frozen).matrix_world = evaluated.matrix_world
        scene.frame_set(before)
        _light(picture, shown)
        aim(picture.camera(), shown)
        picture.scene.render.engine = "CYCLES"
        cycles: Any = picture.scene.cycles
        cycles.samples, cycles.max_bounces = _SAMPLES, 3
        # Few samples and a quick filter: seconds on a processor instead of minutes.
        cycles.use_denoising, cycles.denoising_quality, cycles.denoising_prefilter = True, "FAST", "FAST"
        picture.render(path, *_SIZE)


def _add_lit_floor(picture: PictureScene, floor) -> None:
    """The painted floor in a material that takes shadows; the scene's own glows."""
    copy = picture.add("Floor", floor.data)
    copy.matrix_world = floor.matrix_world
    material = picture.material("Wayfarer Map Lit")
    tree = node_tree(material)
    nodes, links = tree.nodes, tree.links
    nodes.clear()
    output, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    color = nodes.new("ShaderNodeVertexColor")
    color.layer_name = ATTRIBUTE
    links.new(color.outputs["Color"], shader.inputs["Color"])
    links.new(shader.outputs[0], output.inputs["Surface"])
    copy.material_slots[0].link = "OBJECT"
    copy.material_slots[0].material = material


def _light(picture: PictureScene, shown: MapScene) -> None:
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle, sun.color = 2.4, np.radians(6), (1.0, 0.96, 0.90)
    picture.add("Sun", sun).rotation_euler = np.radians([38, -12, -35])
    world = bpy.data.worlds.new("Wayfarer Picture")
    picture.scene.world = world
    tree = node_tree(world)
    nodes, links = tree.nodes, tree.links
    nodes.clear()
    # The sky lights the scene, but behind it lies a dark backdrop.
    rays, mix = nodes.new("ShaderNodeLightPath"), nodes.new("ShaderNodeMixShader")
    sky, backdrop = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeBackground")
    sky.inputs["Color"].default_value = (0.80, 0.88, 1.0, 1.0)
    sky.inputs["Strength"].default_value = 0.5
    backdrop.inputs["Color"].default_value = opaque(_BACKDROP)
    output = nodes.new("ShaderNodeOutputWorld")
    links.new(rays.outputs["Is Camera Ray"], mix.inputs[0])
    links.new(sky.outputs[0], mix.inputs[1])
    links.new(backdrop.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])


def aim(camera, shown: MapScene) -> None:
    """Look down at the whole ground from a corner, as near as it and the figures standing on it allow."""
    camera.data.lens = 50.0
    camera.data.clip_end = 1000.0
    direction = Vector((0.62, -0.95, 0.88)).normalized()
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    right, up, back = (np.array(axis) for axis in camera.rotation_euler.to_matrix().transposed())
    corners = np.array(
        [
            (x, y, shown.ground_height + z)
            for x in (shown.low[0], shown.high[0])
            for y in (shown.low[1], shown.high[1])
            for z in (0.0, 1.5)
        ]
    )
    half_width = camera.data.sensor_width / 2 / camera.data.lens * _FILLED
    half_height = half_width * _SIZE[1] / _SIZE[0]
    position = corners.mean(axis=0) + 10 * np.ptp(corners, axis=0).max() * back
    # Perspective shifts the middle of what is seen with every change of distance: a few rounds settle it.
    for _ in range(12):
        away = (position - corners) @ back
        x, y = (corners - position) @ right / away, (corners - position) @ up / away
        position = position + away.mean() * ((x.min() + x.max()) / 2 * right + (y.min() + y.max()) / 2 * up)
        excess = max(np.ptp(x) / 2 / half_width, np.ptp(y) / 2 / half_height)
        position = position + (excess - 1) * away.mean() * back
    camera.location = position
