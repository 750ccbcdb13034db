"""Find out which clips can be deleted."""

import bpy

from ..findings.ablation import deletion_finding_steps
from ..state import results
from .asks_embedding import FindsOut


class WAYFARER_OT_find_deletable(FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.find_deletable"
    bl_label = "Find Deletable Clips"
    bl_description = "List the clips that can all be deleted together without losing more of the floor than allowed"

    def steps(self, context):
        allowed = context.scene.wayfarer.evaluation.allowed_loss / 100
        return deletion_finding_steps(results(context.scene).embedding, allowed)

    def summary(self, finding):
        return finding.sentences[0].rstrip(".")
