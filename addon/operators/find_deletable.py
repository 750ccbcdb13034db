"""Find out which clips can be deleted."""

import bpy

from ..results.findings.ablation import deletion_finding_steps
from ..results.state import embedding_of
from .asks_embedding import AsksEmbedding, FindsOut


class WAYFARER_OT_find_deletable(AsksEmbedding, FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.find_deletable"
    bl_label = "Find Deletable Clips"
    bl_description = "List the clips that can all be deleted together without losing more of the floor than allowed"

    def steps(self, context):
        allowed = context.scene.wayfarer.evaluation.allowed_loss / 100
        return deletion_finding_steps(embedding_of(context.scene), allowed)

    def summary(self, finding):
        return finding.sentences[0].rstrip(".")
