"""List the actions that animate the character."""

import bpy

from ..bridge.clip_actions import character_problem
from ..bridge.text import counted


class WAYFARER_OT_refresh_clips(bpy.types.Operator):
    bl_idname = "wayfarer.refresh_clips"
    bl_label = "Refresh Clips"
    bl_description = "Find all actions that animate the character"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        problem = character_problem(context.scene)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def execute(self, context):
        settings = context.scene.wayfarer
        new = settings.refresh_clips()
        if len(settings.clips) == 0:
            self.report({"WARNING"}, f"No action animates '{settings.character.name}'")
        else:
            self.report({"INFO"}, f"{counted(len(settings.clips), 'clip')}, {new} new")
        return {"FINISHED"}
