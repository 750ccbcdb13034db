"""List the actions that animate the character."""

import bpy


class WAYFARER_OT_refresh_clips(bpy.types.Operator):
    bl_idname = "wayfarer.refresh_clips"
    bl_label = "Refresh Clips"
    bl_description = "Find all actions that animate the character"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.scene.wayfarer.character is None:
            cls.poll_message_set("Choose a character first")
            return False
        return True

    def execute(self, context):
        settings = context.scene.wayfarer
        new = settings.refresh_clips()
        if len(settings.clips) == 0:
            self.report({"WARNING"}, f"No action animates '{settings.character.name}'")
        else:
            self.report({"INFO"}, f"{len(settings.clips)} clips, {new} of them new")
        return {"FINISHED"}
