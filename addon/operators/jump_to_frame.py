"""Show a frame of the walk that is worth looking at."""

import bpy
from bpy.props import IntProperty


class WAYFARER_OT_jump_to_frame(bpy.types.Operator):
    bl_idname = "wayfarer.jump_to_frame"
    bl_label = "Jump to Frame"
    bl_description = "Choose this entry of the list and show its frame"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    worst: IntProperty(name="Worst Frame", description="Place in the list", min=0, options={"SKIP_SAVE"})

    def execute(self, context):
        report = context.scene.wayfarer.walk.report
        if self.worst >= len(report.worst):
            return {"CANCELLED"}
        # Choosing it shows it.
        report.active_worst = self.worst
        return {"FINISHED"}
