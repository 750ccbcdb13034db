"""The map on the floor."""

import bpy

from ...live.live import status
from ...render.floor import find_floor, floor_legend
from ...results.advice import stale_advice
from ...results.shown import find_painted
from ...results.staleness import map_is_stale
from ...results.store import embedded_graph, results
from ..drawing import Sidebar, Step, draw_numbers, draw_sentences, draw_table, draw_wrapped, split_properties
from ..swatches import swatch


class WAYFARER_PT_map(Step, bpy.types.Panel):
    bl_label = "Map"

    def result_is_there(self, scene):
        return find_painted(scene) is not None

    def result_is_stale(self, scene):
        return map_is_stale(scene)

    def draw(self, context):
        scene = context.scene
        layout, settings = self.layout, scene.wayfarer.map
        heeds = settings.kind.heeds
        column = split_properties(layout).column()
        column.prop(settings, "quantity")
        if "palette" in heeds:
            column.prop(settings, "palette")
        if "segment" in heeds:
            # Without one, the first is shown.
            graph = embedded_graph(scene)
            first = graph.segments[0].name if graph is not None and graph.segments else ""
            column.prop(settings, "segment", icon="ANIM_DATA", placeholder=first)
        if "goal" in heeds:
            column.prop(settings, "goal")
        if "bands" in heeds:
            column.prop(settings, "bands")
        if "few_ways" in heeds:
            column.prop(settings, "few_ways")
        if "heading" in heeds:
            row = column.row(heading="Single Heading")
            row.prop(settings, "use_heading", text="")
            value = row.row()
            value.active = settings.use_heading
            value.prop(settings, "heading", text="")
        row = layout.row(align=True)
        row.use_property_split = False
        row.operator("wayfarer.paint_map", icon="BRUSH_DATA")
        row.prop(scene.wayfarer, "live", icon="PLAY", toggle=True)
        if results(scene).embedding is None:
            draw_sentences(context, layout, ["Embed the motion graph first"], "INFO")
        else:
            text, icon = status(scene)
            # Without live evaluation, too, the map follows its settings; only what hinders it is of interest then.
            if text and (scene.wayfarer.live or (icon == "ERROR" and map_is_stale(scene))):
                draw_sentences(context, layout, [text], icon)
            if not scene.wayfarer.live:
                draw_sentences(context, layout, stale_advice(scene))
        floor = find_floor(scene)
        legend = floor_legend(floor) if floor is not None else None
        if legend is None:
            return
        if any(entry.value for entry in legend.swatches):
            draw_table(layout, [(s.text, s.value, swatch(s.color)) for s in legend.swatches], factor=0.8)
        if legend.numbers:
            draw_numbers(layout, legend.numbers)


class WAYFARER_PT_place(Sidebar, bpy.types.Panel):
    bl_label = "Place"
    bl_parent_id = "WAYFARER_PT_map"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return results(context.scene).embedding is not None

    def draw(self, context):
        layout = self.layout
        layout.operator("wayfarer.pick_place", icon="EYEDROPPER")
        for line in context.scene.wayfarer.overlay.place.splitlines():
            draw_wrapped(context, layout, line)


class WAYFARER_PT_map_display(Sidebar, bpy.types.Panel):
    bl_label = "Display"
    bl_parent_id = "WAYFARER_PT_map"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer
        layout.prop(settings.overlay, "show_legend")
        layout.prop(settings.map, "offset")


PANELS = (WAYFARER_PT_map, WAYFARER_PT_place, WAYFARER_PT_map_display)
