"""Making the embedding smaller."""

import bpy

from ...results.findings.finding import PRUNING, PRUNING_CURVE, find_finding
from ...results.state import results
from .found import FindingPart, draw_chart_button, draw_finding_numbers, draw_next_step
from .step import Step, draw_sentences, split_properties


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


class WAYFARER_PT_pruning_curve(FindingPart, bpy.types.Panel):
    bl_label = "Price of Pruning"
    bl_parent_id = "WAYFARER_PT_tuning"
    bl_options = {"DEFAULT_CLOSED"}
    finding = PRUNING_CURVE

    def draw(self, context):
        layout, scene = self.layout, context.scene
        layout.operator("wayfarer.sweep_pruning", icon="FCURVE")
        draw_finding_numbers(layout, scene, PRUNING_CURVE)
        draw_chart_button(layout, scene, PRUNING_CURVE)


PANELS = (WAYFARER_PT_tuning, WAYFARER_PT_pruning_curve)
