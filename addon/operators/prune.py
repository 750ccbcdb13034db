"""Make the embedding smaller."""

import bpy

from ..findings.finding import keep_finding
from ..findings.pruning import pruning_finding
from ..jobs import LongOperator
from ..pruned_embedding import keep_pruning
from ..pruning import prune_steps
from ..state import results
from ..text import counted
from .asks_embedding import AsksEmbedding


class WAYFARER_OT_prune(AsksEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.prune"
    bl_label = "Prune"
    bl_description = (
        "Make the embedding smaller. Maps, walks and questions use what is left; the whole embedding is kept, and "
        "every pruning starts from it"
    )

    def steps(self, context):
        return prune_steps(results(context.scene).whole, context.scene.wayfarer.tuning.to_settings())

    def apply(self, context, result):
        scene = context.scene
        keep_finding(scene, pruning_finding(result))
        if not result.met:
            self.report({"WARNING"}, result.sentences[0])
        if result.after.nodes == 0:
            self.report({"WARNING"}, "Nothing is left: allow more segments, or restore the embedding")
        if result.pruned is result.whole:
            self.report({"INFO"}, "Nothing has to go: the embedding stays whole")
        keep_pruning(scene, result)
        share = result.after.links / max(result.before.links, 1)
        self.report(
            {"INFO"},
            f"{counted(result.after.nodes, 'node')} and {counted(result.after.links, 'link')} ({share:.1%}) are left, "
            f"{result.after.floor:.1f} of {result.before.floor:.1f} m² of the floor",
        )
