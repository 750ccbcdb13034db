"""Choose a clip in the list by the icon of its health."""

import bpy
from bpy.props import IntProperty

from ..results.state import health_of


class WAYFARER_OT_choose_clip(bpy.types.Operator):
    bl_idname = "wayfarer.choose_clip"
    bl_label = "Show Findings"
    bl_description = "Choose this clip and show what was found in it"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    clip: IntProperty(name="Clip", description="Place in the list", min=0, options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        clips = context.scene.wayfarer.clips
        action = clips[properties.clip].action if properties.clip < len(clips) else None
        health = health_of(context.scene, action) if action else None
        if health is None:
            return cls.bl_description
        return "\n".join(health.sentences).removesuffix(".") or "Nothing is wrong with this clip"

    def execute(self, context):
        settings = context.scene.wayfarer
        if self.clip >= len(settings.clips):
            return {"CANCELLED"}
        settings.active_clip = self.clip
        return {"FINISHED"}
