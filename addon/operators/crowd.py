"""Let many copies of the character walk at the same time, and remove them."""

import bpy

from ..bridge.copies import find_copies
from ..bridge.text import counted, length
from ..jobs import LongOperator
from ..results.shown import find_walk
from ..walks.crowd import CROWD_COLLECTION, crowd_walk_steps, keep_crowd, remove_crowd
from .needs_embedding import NeedsEmbedding


class WAYFARER_OT_crowd(NeedsEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.crowd"
    bl_label = "Crowd"
    bl_description = (
        "Let copies of the character walk at the same time without meeting one another, in place of an earlier crowd; "
        "the character itself stays as it is"
    )

    def steps(self, context):
        return crowd_walk_steps(context.scene)

    def apply(self, context, result):
        keep_crowd(context.scene, result)
        crowd = result.crowd
        if crowd.unserved:
            left_out = f"{len(crowd.unserved)} of {counted(result.n_wanted, 'walker')} got no walk"
            self.report({"WARNING"}, f"{left_out}. {crowd.unserved[0].reason}")
        character = context.scene.wayfarer.character
        if find_walk(context.scene) is not None and character.visible_get():
            walks_on = f"'{character.name}' plays a walk of its own, and keeps no distance from the crowd; hide it"
            self.report({"WARNING"}, walks_on)
        apart = f", at least {length(crowd.closest)} apart" if len(crowd.walks) > 1 else ""
        self.report({"INFO"}, f"{counted(len(crowd.walks), 'walker')}{apart}")
        self.warn_if_stale(context.scene)


class WAYFARER_OT_remove_crowd(bpy.types.Operator):
    bl_idname = "wayfarer.remove_crowd"
    bl_label = "Remove Crowd"
    bl_description = (
        "Remove the walkers of the crowd and their actions; those that were moved to other collections stay"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        # Whoever deleted the walkers by hand still sees what was said of them.
        if not find_copies(context.scene, CROWD_COLLECTION) and not context.scene.wayfarer.walk.crowd.n_wanted:
            cls.poll_message_set("There is no crowd")
            return False
        return True

    def execute(self, context):
        self.report({"INFO"}, f"{counted(remove_crowd(context.scene), 'walker')} removed")
        return {"FINISHED"}
