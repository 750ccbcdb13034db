"""The walk as a curve on the floor."""

from typing import cast

import bpy
import numpy as np

from ...core.maps.colors import WALK, linear
from ..bridge.materials import own_material, remove_unused_materials
from ..bridge.owned import OUTPUT, WALK_CURVE, find_collection, find_walk_curve
from ..bridge.versions import node_tree

_RADIUS = 0.018
_ABOVE = 0.03
"""Metres above the floor: free of the painted grid, below the ankles."""


def walk_curve(path: np.ndarray, ground_height: float, collection) -> bpy.types.Object:
    """A tube along (F, 3) x, y (m), heading (rad), in ``collection``; one made before is used again."""
    obj = find_walk_curve(collection)
    if obj is None:
        curve = bpy.data.curves.new(WALK_CURVE, "CURVE")
        curve.materials.append(walk_material(WALK_CURVE, WALK))
        obj = bpy.data.objects.new(WALK_CURVE, curve)
        collection.objects.link(obj)
    lay_tube(obj.data, path, ground_height)
    return obj


def lay_tube(curve, path: np.ndarray, ground_height: float) -> None:
    """Make curve data a tube along (F, 3) x, y (m), heading, a little above the ground at ``ground_height`` (m)."""
    curve.dimensions = "3D"
    # Upright: the tube would otherwise turn, and shrink, at every sharp bend.
    curve.twist_mode = "Z_UP"
    curve.bevel_depth = _RADIUS
    curve.bevel_resolution = 1
    curve.use_fill_caps = True
    curve.splines.clear()
    spline = curve.splines.new("POLY")
    # A standing character leaves many points in one place, which make the tube twist.
    kept = _apart(path[:, :2])
    spline.points.add(len(kept) - 1)
    points = np.ones((len(kept), 4), dtype=np.float32)
    points[:, :2] = kept
    points[:, 2] = ground_height + _ABOVE
    spline.points.foreach_set("co", points.ravel())
    spline.points.foreach_set("radius", np.ones(len(kept), dtype=np.float32))


def remove_walk_curve(scene) -> None:
    """Remove the curve of an earlier walk from the scene, if there is one."""
    collection = find_collection(scene, OUTPUT)
    obj = find_walk_curve(collection) if collection is not None else None
    if obj is not None:
        curve = cast(bpy.types.Curve, obj.data)
        bpy.data.objects.remove(obj)
        if curve.users == 0:
            bpy.data.curves.remove(curve)
        remove_unused_materials([WALK_CURVE])


def _apart(points: np.ndarray, distance: float = 0.02) -> np.ndarray:
    """Those of (F, 2) points that are further than ``distance`` from the one kept before; at least two."""
    kept = [0]
    for i in range(1, len(points)):
        if np.hypot(*(points[i] - points[kept[-1]])) > distance:
            kept.append(i)
    return points[kept if len(kept) > 1 else [0, len(points) - 1]]


def walk_material(name: str, srgb: tuple[float, float, float]):
    """The material of this name, which glows a little; made in this colour if there is none."""

    def furnish(material) -> None:
        color = (*linear(srgb), 1.0)
        material.diffuse_color = color
        shader = node_tree(material).nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = color
        shader.inputs["Emission Color"].default_value = color
        shader.inputs["Emission Strength"].default_value = 0.6

    return own_material(name, furnish)
