"""Walks from where the mouse clicks."""

import bpy

from ..results.store import results
from .asks_embedding import AsksEmbedding
from .mixins import PicksOnFloor, clicked, ground_under, viewport_under


class WAYFARER_OT_pick_walks_from(PicksOnFloor, AsksEmbedding, bpy.types.Operator):
    bl_idname = "wayfarer.pick_walks_from"
    bl_label = "Walks from Here"
    bl_description = "Click a place on the floor: walks that start there are drawn as coloured curves"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        """Without a mouse: from the 3D cursor."""
        return bpy.ops.wayfarer.walks_from(location=context.scene.cursor.location.xy)

    def begin(self, context):
        context.workspace.status_text_set("Click: Walks from Here    Esc: Cancel")

    def handle(self, context, event):
        region = viewport_under(context, event) if clicked(event) else None
        if region is None:
            # A click on the sidebar, or on another editor, is theirs.
            return {"PASS_THROUGH"}
        mouse = event.mouse_x - region.x, event.mouse_y - region.y
        place = ground_under(region, context.space_data.region_3d, mouse, results(context.scene).ground_height)
        self.stop(context)
        if place is None:
            self.report({"WARNING"}, "That place is above the horizon; click on the floor")
            return {"CANCELLED"}
        # The walks are an operator, and a step of undo, of their own.
        bpy.ops.wayfarer.walks_from("INVOKE_DEFAULT", True, location=place)
        return {"CANCELLED"}
