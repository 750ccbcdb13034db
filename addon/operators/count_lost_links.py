"""Count the links that the scene cost."""

import bpy

from ...core.evaluation.why_not import lost_links_steps
from ..bridge.text import counted, share_of
from ..jobs import LongOperator
from ..results.state import embedding_of, results
from .asks_embedding import LooksAtEmbedding


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
