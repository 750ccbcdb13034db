"""A saved file that shows its map when it is opened: painted floor visible, everything in view."""

from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...addon.bridge.versions import keep_material_colors
from .map_picture import MapScene
from .view_picture import aim


def set_up_viewports(shown: MapScene) -> None:
    """Let all 3D viewports colour by attribute, so that solid mode shows the map, and look at the ground."""
    centre = Vector(((shown.low[0] + shown.high[0]) / 2, (shown.low[1] + shown.high[1]) / 2, shown.ground_height))
    keep_material_colors(bpy.data.objects)
    extent = float(np.hypot(shown.high[0] - shown.low[0], shown.high[1] - shown.low[1]))
    for screen in bpy.data.screens:
        for area in screen.areas:
            if area.type != "VIEW_3D":
                continue
            space: Any = area.spaces.active
            space.shading.type = "SOLID"
            space.shading.color_type = "VERTEX"
            # Without the outlines of cameras and lights, and the lines between parents and children.
            space.overlay.show_extras = space.overlay.show_relationship_lines = False
            space.show_region_ui = True
            view = space.region_3d
            view.view_perspective = "PERSP"
            view.view_location, view.view_distance = centre, 1.1 * extent
            view.view_rotation = Vector((0.62, -0.95, 0.88)).to_track_quat("Z", "Y")


def add_camera_and_sun(scene, shown: MapScene) -> None:
    """Add a camera and a sun to a scene that has no camera yet."""
    if scene.camera is not None:
        return
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    aim(camera, shown)
    scene.camera = camera
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 2.4, np.radians(6)
    light = bpy.data.objects.new("Sun", sun)
    light.rotation_euler = np.radians([38, -12, -35])
    light.location = (0.0, 0.0, 5.0)
    scene.collection.objects.link(light)
