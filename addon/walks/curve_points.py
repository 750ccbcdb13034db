"""A curve object as the polyline that Blender draws."""

import bpy
import numpy as np

from ...core.errors import WalkError


def curve_points(curve_object) -> np.ndarray:
    """(n, 2) world x, y (m) along the spline of a curve object, at its own resolution; a cyclic one comes back.

    Bevel, extrusion and modifiers make no difference. WalkError unless there is exactly one spline.
    """
    splines = curve_object.data.splines
    if len(splines) != 1:
        raise WalkError(
            f"The curve '{curve_object.name}' has {len(splines)} splines, and a walk follows one; "
            "separate them, or delete all others."
        )
    is_cyclic = splines[0].use_cyclic_u
    bare = curve_object.data.copy()
    bare.bevel_depth = bare.extrude = bare.offset = 0.0
    bare.bevel_object = bare.taper_object = None
    bare.dimensions = "3D"
    # Not in any scene: nothing of the artist's changes.
    carrier = bpy.data.objects.new(curve_object.name, bare)
    try:
        mesh = carrier.to_mesh()
        local = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        mesh.vertices.foreach_get("co", local)
        carrier.to_mesh_clear()
    finally:
        bpy.data.objects.remove(carrier)
        bpy.data.curves.remove(bare)
    matrix = np.array(curve_object.matrix_world)
    points = local.reshape(-1, 3).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
    if is_cyclic and len(points):
        points = np.concatenate([points, points[:1]])
    return points[:, :2]
