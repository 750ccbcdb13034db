"""Unroll the motion graph into the scene."""

import bpy

from ..bridge.text import counted, share
from ..jobs import LongOperator
from ..results.advice import embedding_advice
from ..results.state import results
from ..results.workflow import embed_scene_steps, keep_embedded


class WAYFARER_OT_embed(LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.embed"
    bl_label = "Embed"
    bl_description = "Find out where in the scene the character can go, and by which segments"

    @classmethod
    def poll(cls, context):
        environment = context.scene.wayfarer.environment
        if results(context.scene).graph is None:
            cls.poll_message_set("Build the motion graph first")
        elif not environment.has_ground:
            cls.poll_message_set("Choose a ground or obstacles in the Environment panel first")
        else:
            return True
        return False

    def steps(self, context):
        return embed_scene_steps(context.scene, context.evaluated_depsgraph_get())

    def apply(self, context, result):
        keep_embedded(context.scene, result)
        embedding = result.embedding
        for sentence in embedding_advice(context.scene):
            self.report({"WARNING"}, sentence)
        if embedding.n_nodes > 0:
            self.report(
                {"INFO"},
                f"{counted(embedding.n_nodes, 'node')}, {counted(embedding.n_links, 'link')}, {share(result.share)} of "
                "the free floor covered",
            )
