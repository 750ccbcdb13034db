"""Walks from where the mouse clicks."""

import bpy

from ..state import results
from .asks_embedding import AsksEmbedding
from .pick_place import ground_under, viewport_under


class WAYFARER_OT_pick_walks_from(AsksEmbedding, bpy.types.Operator):
    bl_idname = "wayfarer.pick_walks_from"
    bl_label = "Walks from Here"
    bl_description = "Click a place on the floor: walks that start there are drawn as coloured curves"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        """Without a mouse: from the 3D cursor."""
        return bpy.ops.wayfarer.walks_from(location=context.scene.cursor.location.xy)

    def invoke(self, context, event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "Start this in a 3D viewport")
            return {"CANCELLED"}
        context.window.cursor_modal_set("CROSSHAIR")
        context.workspace.status_text_set("Click: Walks from Here    Esc: Cancel")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self._stop(context)
            return {"CANCELLED"}
        # Another editor may have taken the viewport's place.
        if context.area is None or context.area.type != "VIEW_3D":
            self._stop(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        region = viewport_under(context, event)
        if region is None:
            # A click on the sidebar, or on another editor.
            return {"PASS_THROUGH"}
        mouse = event.mouse_x - region.x, event.mouse_y - region.y
        place = ground_under(region, context.space_data.region_3d, mouse, results(context.scene).ground_height)
        self._stop(context)
        if place is None:
            self.report({"WARNING"}, "That place is above the horizon; click on the floor")
            return {"CANCELLED"}
        # The walks are an operator, and a step of undo, of their own.
        bpy.ops.wayfarer.walks_from("INVOKE_DEFAULT", True, location=place)
        return {"CANCELLED"}

    def cancel(self, context):
        """Called by Blender when it ends the operator itself, for example on opening another file."""
        self._stop(context)

    def _stop(self, context) -> None:
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
