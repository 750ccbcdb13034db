"""Make the embedding smaller."""

import bpy

from ...core.report.topics.pruning import pruning_finding
from ...core.tuning.pruning import prune_steps
from ..bridge.text import amount, area, counted, share_of
from ..jobs import LongOperator
from ..results.findings import keep_finding
from ..results.pruned import keep_pruning
from ..results.store import results, whole_of
from .asks_embedding import AsksEmbedding


class WAYFARER_OT_prune(AsksEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.prune"
    bl_label = "Prune"
    bl_description = (
        "Make the embedding smaller. Maps, walks and questions use what is left; the whole embedding is kept, and "
        "every pruning starts from it"
    )

    @classmethod
    def poll(cls, context):
        # What was pruned to nothing can be pruned anew: from the whole.
        return results(context.scene).pruning is not None or super().poll(context)

    def steps(self, context):
        return prune_steps(whole_of(context.scene), context.scene.wayfarer.tuning.to_settings())

    def apply(self, context, result):
        scene = context.scene
        keep_finding(scene, pruning_finding(result))
        if not result.met:
            self.report({"WARNING"}, result.sentences[0])
        if result.after.nodes == 0:
            self.report({"WARNING"}, "Nothing is left: keep more, or press Restore")
        keep_pruning(scene, result)
        if result.pruned is result.whole:
            self.report({"INFO"}, "Nothing has to go: the embedding stays whole")
        else:
            before, after = result.before, result.after
            self.report(
                {"INFO"},
                f"Left of the embedding: {share_of(after.nodes, before.nodes)} of the nodes, "
                f"{share_of(after.links, before.links)} of the links ({counted(after.links, 'link')}), "
                f"{amount(after.floor)} of {area(before.floor)} of covered floor",
            )
        self.warn_if_stale(scene)
