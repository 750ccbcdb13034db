"""Questions to the embedding: how long it takes to get somewhere, and where walks lead from a place."""

import bpy

from ...results.findings import REACH, find_finding, finding_is_stale
from ..drawing import Sidebar, Step, draw_finding, draw_next_step, draw_wrapped, split_properties

_CHOICE = {"OBJECT": "object", "REGION": "region", "TAG": "tag", "CLIP": "clip"}
"""The property that names the goal, by its kind."""


class WAYFARER_PT_queries(Step, bpy.types.Panel):
    bl_label = "Queries"
    bl_options = {"DEFAULT_CLOSED"}

    def result_is_there(self, scene):
        return find_finding(scene, REACH) is not None

    def result_is_stale(self, scene):
        return finding_is_stale(scene, REACH)

    def draw(self, context):
        layout, scene = split_properties(self.layout), context.scene
        settings = scene.wayfarer.queries
        if not draw_next_step(context, layout) and find_finding(scene, REACH) is None:
            return
        column = layout.column()
        column.row().prop(settings, "direction", expand=True)
        column.prop(settings, "goal", text="Goal" if settings.direction == "TO" else "Start")
        if settings.goal in _CHOICE:
            column.prop(settings, _CHOICE[settings.goal])
        if settings.goal in ("CURSOR", "OBJECT"):
            column.prop(settings, "radius")
        column.prop(settings, "times")
        layout.operator("wayfarer.find_reach", icon="TIME")
        kept = find_finding(scene, REACH)
        if kept is not None:
            draw_wrapped(context, layout, kept.sentences)
            draw_finding(context, layout, REACH)


class WAYFARER_PT_walks_from(Sidebar, bpy.types.Panel):
    bl_label = "Walks from Here"
    bl_parent_id = "WAYFARER_PT_queries"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer.queries
        column = layout.column()
        column.prop(settings, "n_walks")
        column.prop(settings, "duration")
        column.prop(settings, "style")
        column.prop(settings, "seed")
        row = layout.row(align=True)
        row.operator("wayfarer.pick_walks_from", icon="EYEDROPPER")
        row.operator("wayfarer.clear_walks_from", text="", icon="X")


PANELS = (WAYFARER_PT_queries, WAYFARER_PT_walks_from)
