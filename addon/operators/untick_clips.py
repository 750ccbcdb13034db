"""Take deletable clips out of the list."""

import bpy

from ..bridge.text import counted
from ..results.clips import deletable_actions
from ..results.findings import DELETION, find_finding


class WAYFARER_OT_untick_clips(bpy.types.Operator):
    bl_idname = "wayfarer.untick_clips"
    bl_label = "Untick These Clips"
    bl_description = (
        "Untick the deletable clips in the list of clips; then build the motion graph and embed again. The actions "
        "themselves stay"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        found = find_finding(context.scene, DELETION)
        if found is None or not found.rows:
            cls.poll_message_set("Find deletable clips first" if found is None else "No clip can be deleted")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        names, kept = deletable_actions(scene)
        ticked = [clip for clip in scene.wayfarer.clips if clip.use and clip.action and clip.action.name in names]
        for clip in ticked:
            clip.use = False
        if not ticked:
            self.report({"WARNING"}, "None of these clips is ticked any longer")
            return {"CANCELLED"}
        if kept:
            self.report({"WARNING"}, f"Only one of the clip and its mirror image can go: {', '.join(kept)} stay ticked")
        self.report({"INFO"}, f"{counted(len(ticked), 'clip')} unticked; build the motion graph and embed again")
        return {"FINISHED"}
