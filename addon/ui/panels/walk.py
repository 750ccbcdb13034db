"""Walking."""

import bpy

from ....core.wording import amount, angle, number, of, share, small, time
from ...bridge.units import scene_length, scene_slide
from ...results.advice import stale_advice
from ...results.shown import find_walk
from ...results.staleness import walk_changes, walk_is_stale
from ...results.store import results
from ..drawing import Sidebar, Step, draw_numbers, draw_sentences, draw_wrapped, split_properties


class WAYFARER_PT_walk(Step, bpy.types.Panel):
    bl_label = "Walk"

    def result_is_there(self, scene):
        return find_walk(scene) is not None

    def result_is_stale(self, scene):
        return walk_is_stale(scene)

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer.walk
        layout.column().prop(settings, "style")
        _draw_style(layout, context.scene)
        column = layout.column()
        column.prop(settings, "output")
        column = layout.column(heading="Add")
        column.prop(settings, "use_markers")
        column.prop(settings, "draw_path")
        layout.operator("wayfarer.random_walk", icon="MOD_DYNAMICPAINT")
        if results(context.scene).embedding is None:
            draw_sentences(context, layout, ["Embed the motion graph first"], "INFO")
        draw_sentences(context, layout, stale_advice(context.scene))
        if find_walk(context.scene) is not None:
            draw_sentences(context, layout, walk_changes(context.scene))
            numbers = results(context.scene).summary.walk
            draw_numbers(
                layout,
                (
                    ("Duration", time(numbers.seconds)),
                    ("Length", scene_length(context.scene, numbers.length)),
                    ("Segments", number(numbers.segments)),
                ),
            )


def _draw_style(layout, scene) -> None:
    """Draw what the chosen style heeds."""
    settings = scene.wayfarer.walk
    for names in settings.shown():
        column = layout.column()
        for name in names:
            if name in ("target_object", "start_object"):
                column.prop(settings, name, text=" ")
            else:
                column.prop(settings, name)
            if name == "weighting" and settings.weighting == "CLIPS":
                _draw_weights(layout, scene)


def _draw_weights(layout, scene) -> None:
    layout.template_list("WAYFARER_UL_clip_weights", "", scene.wayfarer, "clips", scene.wayfarer, "active_clip", rows=4)


class WAYFARER_PT_walk_advanced(Sidebar, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "WAYFARER_PT_walk"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer.walk
        layout.column().prop(settings, "blend_duration")
        layout.column(heading="Clean-Up").prop(settings, "hold_feet")
        column = layout.column()
        column.active = settings.hold_feet
        column.prop(settings, "hold_window")
        column.prop(settings, "hold_shift")
        column.prop(settings, "hold_drop")


class WAYFARER_PT_walk_quality(Sidebar, bpy.types.Panel):
    bl_label = "Quality"
    bl_parent_id = "WAYFARER_PT_walk"

    @classmethod
    def poll(cls, context):
        return context.scene.wayfarer.walk.report.is_there

    def draw(self, context):
        scene = context.scene
        layout, report = split_properties(self.layout), scene.wayfarer.walk.report
        rows = []
        if report.slide_after >= 0:
            rows += [
                ("Feet Slide", scene_slide(scene, report.slide_after)),
                ("Before Holding", scene_slide(scene, report.slide_before)),
                ("In the Clips", scene_slide(scene, report.slide_in_clips)),
            ]
        if report.gap_joint:
            rows += [("Largest Gap", angle(report.gap)), ("at", report.gap_joint)]
        rows += [
            ("Root Edit", f"{small(report.edit)} per m"),
            ("Turn Edit", f"{angle(report.turn_edit)} per m"),
            ("Standing", share(report.idle)),
            ("Turns Back", f"{amount(report.turns_back)} a minute"),
        ]
        draw_numbers(layout, rows)
        draw_sentences(context, layout, [report.feet], "INFO")
        layout.label(text="Worst Frames")
        layout.template_list("WAYFARER_UL_worst_frames", "", report, "worst", report, "active_worst", rows=4)
        if 0 <= report.active_worst < len(report.worst):
            # The list has no room for long names.
            chosen = report.worst[report.active_worst]
            draw_wrapped(context, layout, f"Frame {chosen.frame}: {chosen.what}, {chosen.amount}")


class WAYFARER_PT_crowd(Sidebar, bpy.types.Panel):
    bl_label = "Crowd"
    bl_parent_id = "WAYFARER_PT_walk"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        scene = context.scene
        layout, settings = split_properties(self.layout), scene.wayfarer.walk.crowd
        column = layout.column()
        column.prop(settings, "n_walkers")
        column.prop(settings, "spacing")
        column.prop(settings, "weighting")
        if settings.weighting == "CLIPS":
            _draw_weights(layout, scene)
        column = layout.column()
        column.prop(settings, "duration")
        column.prop(settings, "seed")
        row = layout.row(align=True)
        row.operator("wayfarer.crowd", icon="COMMUNITY")
        row.operator("wayfarer.remove_crowd", text="", icon="TRASH")
        if settings.n_wanted:
            rows = [("Walking", of(settings.n_walking, settings.n_wanted))]
            if settings.closest > 0:
                rows.append(("Closest", scene_length(scene, settings.closest)))
            draw_numbers(layout, rows)
            draw_sentences(context, layout, settings.unserved.splitlines())


# What is open at first, and long, comes last.
PANELS = (WAYFARER_PT_walk, WAYFARER_PT_walk_advanced, WAYFARER_PT_crowd, WAYFARER_PT_walk_quality)
