"""Making the embedding smaller."""

import bpy

from ...results.findings import PRUNING, PRUNING_CURVE, find_finding
from ...results.store import results
from ..drawing import Step, draw_finding_numbers, draw_next_step, draw_sentences, split_properties
from .evaluation import topic_part


class WAYFARER_PT_tuning(Step, bpy.types.Panel):
    bl_label = "Tuning"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context):
        if results(context.scene).pruning is not None:
            self.layout.label(text="Pruned", icon="MOD_DECIM")

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        settings, pruning = scene.wayfarer.tuning, results(scene).pruning
        if pruning is None and not draw_next_step(context, layout):
            return
        column = layout.column()
        column.prop(settings, "method")
        if settings.method == "LOCAL":
            column.prop(settings, "k")
        elif settings.method == "GLOBAL":
            column.prop(settings, "n_segments")
        else:
            column.prop(settings, "limit")
            column.prop(settings, "max_links" if settings.limit == "LINKS" else "max_megabytes")
            column.prop(settings, "places")
            column.prop(settings, "coverage_loss")
        row = layout.row(align=True)
        row.operator("wayfarer.prune", icon="MOD_DECIM")
        row.operator("wayfarer.restore_embedding", icon="LOOP_BACK")
        if pruning is None:
            return
        draw_sentences(context, layout, [f"Pruned: {pruning.words}"], "INFO")
        if not pruning.met:
            draw_sentences(context, layout, pruning.sentences)
        if find_finding(scene, PRUNING) is not None:
            draw_finding_numbers(layout, scene, PRUNING)


PANELS = (WAYFARER_PT_tuning, topic_part(PRUNING_CURVE, "WAYFARER_PT_tuning"))
