"""The embedding, and the links that the scene cost."""

import bpy

from ...core.evaluation.why_not import lost_links_steps
from ...core.wording import counted, share, share_of
from ..jobs import LongOperator
from ..results.advice import embedding_advice, unlisted_advice
from ..results.store import embedding_of, results
from ..results.workflow import embed_scene_steps, keep_embedded
from .mixins import LooksAtEmbedding, Needs


class WAYFARER_OT_embed(Needs, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.embed"
    bl_label = "Embed"
    bl_description = "Find out where in the scene the character can go, and by which segments"

    @classmethod
    def problem(cls, context):
        if results(context.scene).graph is None:
            return "Build the motion graph first"
        has_ground = context.scene.wayfarer.environment.has_ground
        return "" if has_ground else "Choose a ground or obstacles in the Environment panel first"

    def steps(self, context):
        return embed_scene_steps(context.scene, context.evaluated_depsgraph_get())

    def apply(self, context, result):
        keep_embedded(context.scene, result)
        embedding = result.embedding
        for sentence in (*unlisted_advice(context.scene), *embedding_advice(context.scene)):
            self.report({"WARNING"}, sentence)
        if embedding.n_nodes > 0:
            self.report(
                {"INFO"},
                f"{counted(embedding.n_nodes, 'node')}, {counted(embedding.n_links, 'link')}, {share(result.share)} of "
                "the free floor covered",
            )


class WAYFARER_OT_count_lost_links(LooksAtEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.count_lost_links"
    bl_label = "Count Lost Links"
    bl_description = "Count the links that obstacles block and that regions forbid; takes about as long as embedding"

    def steps(self, context):
        embedding = embedding_of(context.scene)
        return embedding, (yield from lost_links_steps(embedding))

    def apply(self, context, result):
        embedding, lost = result
        results(context.scene).lost_links = embedding, lost
        self.report(
            {"INFO"},
            f"Of {counted(lost.possible, 'link')} on an empty ground, obstacles block "
            f"{share_of(lost.obstacles, lost.possible)} and regions forbid {share_of(lost.regions, lost.possible)}; "
            f"{share_of(lost.embedded, lost.possible)} are in the embedding",
        )


CLASSES = (WAYFARER_OT_embed, WAYFARER_OT_count_lost_links)
