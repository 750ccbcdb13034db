"""Looking at a place on the ground."""

import bpy

from .state import results

_AROUND = 3.0
"""Metres of ground that are shown around a place."""


def go_to_place(scene, place: tuple[float, float], size: float) -> None:
    """Move the scene's 3D cursor to x, y (m) on the ground, and let the viewports of its windows look at it.

    ``size`` are metres across of what is there. Nothing is selected.
    """
    location = (*place, results(scene).ground_height)
    scene.cursor.location = location
    windows = bpy.context.window_manager.windows if bpy.context.window_manager else ()
    for window in windows:
        if window.scene != scene:
            continue
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                view = area.spaces.active.region_3d
                view.view_location = location
                view.view_distance = 2.0 * (size + _AROUND)
                area.tag_redraw()
