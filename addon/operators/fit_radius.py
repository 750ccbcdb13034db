"""How wide the character is."""

import bpy

from ...core.errors import MotionGraphError
from ...core.motion.body_size import body_radius
from ..bridge.rig import bind_rig
from ..bridge.text import length
from .needs_character import NeedsCharacter


class WAYFARER_OT_fit_radius(NeedsCharacter, bpy.types.Operator):
    bl_idname = "wayfarer.fit_radius"
    bl_label = "Radius from Character"
    bl_description = "Set the radius to half the width of the character's shoulders, and what flesh adds to it"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        settings = context.scene.wayfarer
        try:
            radius = body_radius(bind_rig(settings.character).skeleton)
        except MotionGraphError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        settings.environment.radius = radius
        self.report({"INFO"}, f"The character needs {length(radius)} to each side")
        return {"FINISHED"}
