"""Find out where random walkers spend their time."""

import bpy

from ..results.findings.occupancy import occupancy_finding_steps
from ..results.state import embedding_of
from .asks_embedding import AsksEmbedding, FindsOut


class WAYFARER_OT_find_occupancy(AsksEmbedding, FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.find_occupancy"
    bl_label = "Find Occupancy"
    bl_description = (
        "Where walkers that take every link with the same probability spend their time in the long run, and which "
        "segments they play; the map Occupancy paints it"
    )

    def steps(self, context):
        return occupancy_finding_steps(embedding_of(context.scene))

    def summary(self, finding):
        return finding.sentences[2].rstrip(".")
