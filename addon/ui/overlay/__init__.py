"""Drawing over the 3D viewport: the legend of the map, and the environment.

Draw handlers run at every redraw: they compute nothing, hold no reference to Blender's data, and never raise.
"""

import bpy

from ...render.screen_box import guarded
from .environment import draw_environment
from .legend import draw_legend

_handles = []


def register():
    # Without a window nothing is drawn, and there is nothing to draw with.
    if bpy.app.background:
        return
    for draw, region, moment in (
        (draw_legend, "WINDOW", "POST_PIXEL"),
        (draw_environment, "WINDOW", "POST_VIEW"),
    ):
        handle = bpy.types.SpaceView3D.draw_handler_add(guarded(draw), (), region, moment)
        _handles.append((handle, region))


def unregister():
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(*_handles.pop())
