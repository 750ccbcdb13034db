"""List the weak spots of the embedding."""

import bpy

from ..bridge.text import counted
from ..results.findings.weak_spots import weak_spots_finding_steps
from ..results.state import embedding_of
from .asks_embedding import AsksEmbedding, FindsOut


class WAYFARER_OT_find_weak_spots(AsksEmbedding, FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.find_weak_spots"
    bl_label = "Find Weak Spots"
    bl_description = (
        "List the connected areas of free floor that the character cannot reach, or passes in few ways only, with the "
        "reason. A click on one moves the 3D cursor there and lets the viewport look at it"
    )

    def steps(self, context):
        settings = context.scene.wayfarer.evaluation.weak_spots()
        return weak_spots_finding_steps(embedding_of(context.scene), settings)

    def summary(self, finding):
        if not finding.sentences:
            return "There are no weak spots"
        return f"{counted(len(finding.sentences), 'weak spot')}; the largest: {finding.sentences[0]}"
