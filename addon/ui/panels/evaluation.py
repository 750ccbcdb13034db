"""How good is the embedding: metrics, weak spots, what matters, what is missing."""

import bpy

from ...results.findings.finding import (
    ABLATION,
    ACTIONS,
    CAPTURE,
    DELETION,
    METRICS,
    OCCUPANCY,
    WEAK_SPOTS,
    find_finding,
)
from ..text import draw_wrapped
from .found import (
    FindingPart,
    any_found,
    any_stale,
    draw_chart_button,
    draw_finding_numbers,
    draw_finding_rows,
    draw_next_step,
)
from .step import Sidebar, Step, split_properties

_KINDS = (METRICS, WEAK_SPOTS, ABLATION, DELETION, CAPTURE, OCCUPANCY)


class WAYFARER_PT_evaluation(Step, bpy.types.Panel):
    bl_label = "Evaluation"
    bl_options = {"DEFAULT_CLOSED"}

    def result_is_there(self, scene):
        return any_found(scene, _KINDS)

    def result_is_stale(self, scene):
        return any_stale(scene, _KINDS)

    def draw(self, context):
        layout, scene = self.layout, context.scene
        if not draw_next_step(context, layout) and not scene.wayfarer.findings:
            return
        layout.operator("wayfarer.measure", icon="DRIVER_DISTANCE")
        draw_finding_numbers(layout, scene, METRICS)


class _EvaluationPart(FindingPart):
    bl_parent_id = "WAYFARER_PT_evaluation"


class WAYFARER_PT_metrics(_EvaluationPart, bpy.types.Panel):
    bl_label = "Clips in Numbers"
    bl_options = {"DEFAULT_CLOSED"}
    finding = ACTIONS

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        column = layout.column(align=True)
        column.prop(scene.wayfarer.evaluation, "n_pairs")
        column.prop(scene.wayfarer.evaluation, "seed")
        if find_finding(scene, ACTIONS) is None:
            layout.label(text="Measure to see each clip", icon="INFO")
            return
        draw_finding_rows(context, layout, ACTIONS, "Can Begin On, After on Average")
        draw_chart_button(layout, scene, ACTIONS)


class WAYFARER_PT_weak_spots(_EvaluationPart, bpy.types.Panel):
    bl_label = "Weak Spots"
    bl_options = {"DEFAULT_CLOSED"}
    finding = WEAK_SPOTS

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        settings = scene.wayfarer.evaluation
        column = layout.column()
        column.prop(settings, "domain")
        column.prop(settings, "few_ways")
        column.prop(settings, "min_area")
        layout.operator("wayfarer.find_weak_spots", icon="ZOOM_SELECTED")
        draw_finding_numbers(layout, scene, WEAK_SPOTS)
        draw_finding_rows(context, layout, WEAK_SPOTS, "Area (m²), Place (m), Reason", rows=5)
        draw_chart_button(layout, scene, WEAK_SPOTS)


class WAYFARER_PT_ablation(_EvaluationPart, bpy.types.Panel):
    bl_label = "What Matters"
    bl_options = {"DEFAULT_CLOSED"}
    finding = ABLATION

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        settings = scene.wayfarer.evaluation
        layout.prop(settings, "parts")
        layout.operator("wayfarer.ablate", icon="SORTSIZE")
        draw_finding_numbers(layout, scene, ABLATION)
        draw_finding_rows(context, layout, ABLATION, "Floor Lost Without It", rows=5)
        draw_chart_button(layout, scene, ABLATION)


class WAYFARER_PT_deletion(_EvaluationPart, bpy.types.Panel):
    bl_label = "Deletable Clips"
    bl_options = {"DEFAULT_CLOSED"}
    finding = DELETION

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        layout.prop(scene.wayfarer.evaluation, "allowed_loss")
        layout.operator("wayfarer.find_deletable", icon="TRASH")
        draw_finding_numbers(layout, scene, DELETION)
        draw_finding_rows(context, layout, DELETION, "Floor Lost, with Those Above")
        if find_finding(scene, DELETION) is not None:
            layout.operator("wayfarer.untick_clips", icon="CHECKBOX_DEHLT")


class WAYFARER_PT_capture(_EvaluationPart, bpy.types.Panel):
    bl_label = "What Is Missing"
    bl_options = {"DEFAULT_CLOSED"}
    finding = CAPTURE

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        layout.prop(scene.wayfarer.evaluation, "n_candidates")
        layout.operator("wayfarer.direct_capture", icon="OUTLINER_OB_CAMERA")
        kept = find_finding(scene, CAPTURE)
        if kept is None:
            return
        draw_finding_numbers(layout, scene, CAPTURE)
        if not kept.rows:
            draw_wrapped(context, layout, kept.sentences)
            return
        draw_finding_rows(context, layout, CAPTURE, "Floor Gained", rows=5)
        draw_chart_button(layout, scene, CAPTURE)


class WAYFARER_PT_occupancy(_EvaluationPart, bpy.types.Panel):
    bl_label = "Occupancy"
    bl_options = {"DEFAULT_CLOSED"}
    finding = OCCUPANCY

    def draw(self, context):
        layout, scene = self.layout, context.scene
        layout.operator("wayfarer.find_occupancy", icon="COMMUNITY")
        draw_finding_numbers(layout, scene, OCCUPANCY)
        draw_finding_rows(context, layout, OCCUPANCY, "Share of the Time")
        draw_chart_button(layout, scene, OCCUPANCY)


class WAYFARER_PT_results(Sidebar, bpy.types.Panel):
    bl_label = "Results"
    bl_parent_id = "WAYFARER_PT_evaluation"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.layout.column(align=True)
        column.operator("wayfarer.write_report", icon="TEXT")
        column.operator("wayfarer.export_results", icon="EXPORT")


PANELS = (
    WAYFARER_PT_evaluation,
    WAYFARER_PT_metrics,
    WAYFARER_PT_weak_spots,
    WAYFARER_PT_ablation,
    WAYFARER_PT_deletion,
    WAYFARER_PT_capture,
    WAYFARER_PT_occupancy,
    WAYFARER_PT_results,
)
