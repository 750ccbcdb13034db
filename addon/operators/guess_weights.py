"""Fill the list of joint weights."""

import bpy

from ...core.errors import MotionGraphError
from ...core.motion.joint_roles import joint_weights
from ..bridge.rig import bind_rig
from ..bridge.text import counted
from .needs_character import NeedsCharacter


class WAYFARER_OT_guess_weights(NeedsCharacter, bpy.types.Operator):
    bl_idname = "wayfarer.guess_weights"
    bl_label = "Guess Weights"
    bl_description = (
        "Fill the list with all bones of the character and the weights guessed from their names: one for hips, "
        "spine, legs and arms, zero for the rest"
    )
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        settings = context.scene.wayfarer
        try:
            skeleton = bind_rig(settings.character).skeleton
            weights = joint_weights(skeleton)
        except MotionGraphError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        settings.graph.set_weights(dict(zip(skeleton.names, weights.tolist(), strict=True)))
        self.report({"INFO"}, f"{(weights > 0).sum()} of {counted(len(weights), 'bone')} count when poses are compared")
        return {"FINISHED"}
