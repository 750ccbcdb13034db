"""Find out what matters."""

import bpy

from ...core.evaluation.segment_groups import Grouping
from ..results.findings.ablation import ablation_finding_steps
from ..results.state import embedding_of
from .asks_embedding import AsksEmbedding, FindsOut


class WAYFARER_OT_ablate(AsksEmbedding, FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.ablate"
    bl_label = "Find What Matters"
    bl_description = (
        "Take away each clip, segment or tag in turn and list what the character loses without it, in square metres"
    )

    def steps(self, context):
        kind = Grouping[context.scene.wayfarer.evaluation.parts]
        return ablation_finding_steps(embedding_of(context.scene), kind)

    def summary(self, finding):
        return finding.sentences[0].rstrip(".")
