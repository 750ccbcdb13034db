"""Draw the price of local pruning."""

import bpy

from ..render.image_editor import show_in_editor
from ..results.findings.charts import show_chart
from ..results.findings.finding import PRUNING_CURVE
from ..results.findings.pruning import pruning_curve_finding_steps
from ..results.state import whole_of
from .asks_embedding import AsksEmbedding, FindsOut


class WAYFARER_OT_sweep_pruning(AsksEmbedding, FindsOut, bpy.types.Operator):
    bl_idname = "wayfarer.sweep_pruning"
    bl_label = "Sweep K"
    bl_description = (
        "Prune locally with every number of segments per place, and draw what is left of nodes, links and floor as an "
        "image. The embedding stays as it is"
    )

    def steps(self, context):
        return pruning_curve_finding_steps(whole_of(context.scene))

    def summary(self, finding):
        return finding.sentences[0].rstrip(".")

    def apply(self, context, result):
        super().apply(context, result)
        image = show_chart(context.scene, PRUNING_CURVE)
        if image is not None and not show_in_editor(context, image):
            self.report({"INFO"}, f"The chart is the image '{image.name}'; open an Image Editor to see it")
