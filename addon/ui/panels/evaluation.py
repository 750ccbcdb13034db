"""Evaluation of the embedding: a part of the panel for each topic."""

from typing import Any

import bpy

from ...results.findings import DELETION, METRICS, TOPICS, Topic, find_finding
from ..drawing import (
    FindingPart,
    Sidebar,
    Step,
    any_found,
    any_stale,
    draw_finding,
    draw_finding_numbers,
    draw_next_step,
    split_properties,
)

_PARTS = [topic for topic in TOPICS if topic.columns]
_ICONS: dict[str, Any] = {
    "find_weak_spots": "ZOOM_SELECTED",
    "ablate": "SORTSIZE",
    "find_deletable": "TRASH",
    "direct_capture": "OUTLINER_OB_CAMERA",
    "find_occupancy": "COMMUNITY",
    "sweep_pruning": "FCURVE",
}


class WAYFARER_PT_evaluation(Step, bpy.types.Panel):
    bl_label = "Evaluation"
    bl_options = {"DEFAULT_CLOSED"}

    def result_is_there(self, scene):
        return any_found(scene, (METRICS, *_PARTS))

    def result_is_stale(self, scene):
        return any_stale(scene, (METRICS, *_PARTS))

    def draw(self, context):
        layout, scene = self.layout, context.scene
        if not draw_next_step(context, layout) and not scene.wayfarer.findings:
            return
        layout.operator("wayfarer.measure", icon="DRIVER_DISTANCE")
        draw_finding_numbers(layout, scene, METRICS)


class TopicPart(FindingPart):
    """Mixin: settings of a topic, its button, and what was found."""

    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        # Those of the metrics are also of each clip.
        column, source = layout.column(), self.topic if self.topic.operator else METRICS
        for name in source.settings:
            column.prop(scene.wayfarer.evaluation, name)
        if self.topic.operator:
            layout.operator(f"wayfarer.{self.topic.operator}", icon=_ICONS.get(self.topic.operator, "VIEWZOOM"))
        elif find_finding(scene, self.topic) is None:
            layout.label(text="Measure to see each clip", icon="INFO")
        draw_finding(context, layout, self.topic)
        if self.topic is DELETION and find_finding(scene, DELETION) is not None:
            layout.operator("wayfarer.untick_clips", icon="CHECKBOX_DEHLT")


def topic_part(topic: Topic, parent: str) -> type[bpy.types.Panel]:
    """Make the panel of a topic, inside another panel."""
    members = {"bl_label": topic.part or topic.title, "bl_parent_id": parent, "topic": topic}
    return type(f"WAYFARER_PT_{topic.name.lower()}", (TopicPart, bpy.types.Panel), members)


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
    *(topic_part(topic, "WAYFARER_PT_evaluation") for topic in _PARTS),
    WAYFARER_PT_results,
)
