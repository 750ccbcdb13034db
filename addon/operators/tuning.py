"""Making the embedding smaller, and whole again."""

import bpy

from ...core.report.topics.pruning import pruning_finding
from ...core.tuning.pruning import prune_steps
from ...core.wording import amount, area, counted, share_of
from ..jobs import LongOperator
from ..results.findings import keep_finding
from ..results.pruned import keep_pruning, restore_whole
from ..results.store import embedding_of, results, whole_of
from .mixins import AsksEmbedding, Needs


class WAYFARER_OT_prune(AsksEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.prune"
    bl_label = "Prune"
    bl_description = (
        "Make the embedding smaller. Maps, walks and questions use what is left; the whole embedding is kept, and "
        "every pruning starts from it"
    )

    @classmethod
    def problem(cls, context):
        # What was pruned to nothing can be pruned anew: from the whole.
        return super().problem(context) if results(context.scene).pruning is None else ""

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


class WAYFARER_OT_restore_embedding(Needs, bpy.types.Operator):
    bl_idname = "wayfarer.restore_embedding"
    bl_label = "Restore"
    bl_description = "Bring back the embedding as it was before it was pruned"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def problem(cls, context):
        return "The embedding was not pruned" if results(context.scene).pruning is None else ""

    def execute(self, context):
        restore_whole(context.scene)
        embedding = embedding_of(context.scene)
        self.report(
            {"INFO"},
            f"{counted(embedding.n_nodes, 'node')} and {counted(embedding.n_links, 'link')}, as before pruning",
        )
        return {"FINISHED"}


CLASSES = (WAYFARER_OT_prune, WAYFARER_OT_restore_embedding)
