"""Bring the whole embedding back."""

import bpy

from ..bridge.text import counted
from ..results.pruned import restore_whole
from ..results.store import embedding_of, results


class WAYFARER_OT_restore_embedding(bpy.types.Operator):
    bl_idname = "wayfarer.restore_embedding"
    bl_label = "Restore"
    bl_description = "Bring back the embedding as it was before it was pruned"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if results(context.scene).pruning is None:
            cls.poll_message_set("The embedding was not pruned")
            return False
        return True

    def execute(self, context):
        restore_whole(context.scene)
        embedding = embedding_of(context.scene)
        self.report(
            {"INFO"},
            f"{counted(embedding.n_nodes, 'node')} and {counted(embedding.n_links, 'link')}, as before pruning",
        )
        return {"FINISHED"}
