"""The motion graph: its settings, size, dropped frames and hubs."""

import bpy

from ....core.wording import number, of, short, time
from ...results.staleness import graph_changes, graph_is_stale
from ...results.store import results
from ..drawing import Sidebar, Step, draw_numbers, draw_sentences, draw_table, draw_wrapped, split_properties

_MOST_ROWS = 8
"""Rows of each table; what does not fit is summed up in one row."""


class WAYFARER_PT_motion_graph(Step, bpy.types.Panel):
    bl_label = "Motion Graph"
    presets = "graph"

    def result_is_there(self, scene):
        return results(scene).graph is not None

    def result_is_stale(self, scene):
        return graph_is_stale(scene)

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer.graph
        column = layout.column()
        column.prop(settings, "frame_rate")
        column.prop(settings, "min_segment_duration")
        column = layout.column()
        column.prop(settings, "threshold_mode")
        if settings.threshold_mode == "LINKS":
            column.prop(settings, "max_links")
        elif settings.threshold_mode == "COVERAGE":
            column.prop(settings, "min_coverage")
        column.prop(settings, "max_cost")
        column = layout.column(heading="Clips")
        column.prop(settings, "mirror_clips")
        column.prop(settings, "steady_heading")
        layout.operator("wayfarer.build_motion_graph", icon="NODETREE")
        found = results(context.scene)
        if found.problem:
            draw_sentences(context, layout, [found.problem])
        elif found.graph is None:
            draw_sentences(context, layout, _next_step(context.scene), "INFO")
        draw_sentences(context, layout, graph_changes(context.scene))
        if found.graph is not None:
            numbers = found.summary
            draw_numbers(
                layout,
                (
                    ("Segments", number(len(found.graph.segments))),
                    ("Links", number(len(found.graph.links))),
                    ("Highest Cost", short(found.graph.max_cost)),
                    ("Clips", of(numbers.clips_played, numbers.clips)),
                    ("Motion", time(numbers.motion_seconds)),
                    ("Dropped", time(numbers.dropped_seconds)),
                ),
            )


def _next_step(scene) -> list[str]:
    """Return what has to be done before a motion graph can be built."""
    settings = scene.wayfarer
    if settings.character is None:
        return ["Choose a character in Clips"]
    return [] if settings.used_actions() else ["Tick the clips that are to take part"]


class WAYFARER_PT_joint_weights(Sidebar, bpy.types.Panel):
    bl_label = ""
    bl_parent_id = "WAYFARER_PT_motion_graph"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.wayfarer.graph, "use_custom_weights")

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.graph
        layout.active = settings.use_custom_weights
        layout.operator("wayfarer.guess_weights", icon="BONE_DATA")
        if settings.joint_weights:
            layout.template_list(
                "WAYFARER_UL_joint_weights", "", settings, "joint_weights", settings, "active_joint_weight", rows=5
            )


class WAYFARER_PT_dropped(Sidebar, bpy.types.Panel):
    bl_label = "Dropped"
    bl_parent_id = "WAYFARER_PT_motion_graph"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        found = results(context.scene)
        return found.graph is not None and len(found.graph.dropped) > 0

    def draw(self, context):
        by_reason = {}
        graph = results(context.scene).graph
        for dropped in graph.dropped if graph else ():
            by_reason.setdefault(dropped.reason, []).append((dropped.clip, dropped.seconds))
        for reason, clips in sorted(by_reason.items(), key=lambda item: -sum(seconds for _, seconds in item[1])):
            box = self.layout.box()
            draw_wrapped(context, box, reason[:1].upper() + reason[1:])
            clips.sort(key=lambda clip: -clip[1])
            rows = [(name, time(seconds), 0) for name, seconds in clips[:_MOST_ROWS]]
            rest = clips[_MOST_ROWS:]
            if rest:
                rows.append((f"{number(len(rest))} More", time(sum(seconds for _, seconds in rest)), 0))
            draw_table(box, rows)


class WAYFARER_PT_hubs(Sidebar, bpy.types.Panel):
    bl_label = "Hubs"
    bl_parent_id = "WAYFARER_PT_motion_graph"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return results(context.scene).graph is not None

    def draw(self, context):
        found = results(context.scene)
        rows = []
        summary = found.graph_summary
        if found.graph is not None and summary is not None:
            for segment in summary.hubs(_MOST_ROWS).tolist():
                degrees = f"{summary.in_degree[segment]} / {summary.out_degree[segment]}"
                rows.append((found.graph.segments[segment].name, degrees, 0))
        draw_table(self.layout, rows, heading=("Segment", "In / Out"))


PANELS = (WAYFARER_PT_motion_graph, WAYFARER_PT_joint_weights, WAYFARER_PT_dropped, WAYFARER_PT_hubs)
