"""Looking at a place on the ground."""

import bpy

_AROUND = 3.0
"""Metres of ground that are shown around a place."""


def go_to_place(scene, place: tuple[float, float, float], size: float) -> None:
    """Move the scene's 3D cursor to x, y, z (m), and let the viewports of its windows look at it.

    ``size`` are metres across of what is there. Nothing is selected.
    """
    scene.cursor.location = place
    windows = bpy.context.window_manager.windows if bpy.context.window_manager else ()
    for window in windows:
        if window.scene != scene:
            continue
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                view = area.spaces.active.region_3d
                view.view_location = place
                view.view_distance = 2.0 * (size + _AROUND)
                area.tag_redraw()
