"""Ground, obstacles, regions and the body that must fit through."""

import bpy

from ...results.advice import environment_advice, unlisted_advice
from ..drawing import Sidebar, Step, draw_sentences, split_properties


class WAYFARER_PT_environment(Step, bpy.types.Panel):
    bl_label = "Environment"
    presets = "environment"

    def result_is_there(self, scene):
        return scene.wayfarer.environment.has_ground

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.environment
        if not settings.has_ground:
            draw_sentences(context, layout, ["Choose a ground or obstacles, or add a sample scene"], "INFO")
            layout.operator_menu_enum("wayfarer.add_sample_room", "sample", icon="HOME")
        draw_sentences(context, layout, environment_advice(context.scene))
        unlisted = unlisted_advice(context.scene, drawing=True)
        if unlisted:
            draw_sentences(context, layout, unlisted)
            layout.operator("wayfarer.add_obstacles", icon="OUTLINER_COLLECTION")
        split_properties(layout)
        column = layout.column()
        column.prop(settings, "ground_source")
        if settings.ground_source == "OBJECT":
            column.prop(settings, "ground")
        elif settings.ground_source == "TYPED":
            column.prop(settings, "ground_low")
            column.prop(settings, "ground_high")
            column.prop(settings, "ground_height")
        column.prop(settings, "obstacles")
        column = layout.column()
        column.prop(settings, "cell_size")
        column.prop(settings, "n_headings")
        column.prop(settings, "tiled")
        column.prop(context.scene.wayfarer.overlay, "show_environment")


class WAYFARER_PT_body(Sidebar, bpy.types.Panel):
    bl_label = "Body"
    bl_parent_id = "WAYFARER_PT_environment"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer.environment
        row = layout.row(align=True)
        row.prop(settings, "radius")
        row.operator("wayfarer.fit_radius", text="", icon="ARMATURE_DATA")
        layout.prop(settings, "step_height")
        layout.prop(settings, "head_height")


class WAYFARER_PT_regions(Sidebar, bpy.types.Panel):
    bl_label = "Regions"
    bl_parent_id = "WAYFARER_PT_environment"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context):
        regions = context.scene.wayfarer.environment.regions
        if regions:
            self.layout.label(text=str(len(regions)), translate=False)

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.environment
        row = layout.row()
        row.template_list("WAYFARER_UL_regions", "", settings, "regions", settings, "active_region", rows=2)
        column = row.column(align=True)
        column.operator("wayfarer.add_region", text="", icon="ADD")
        column.operator("wayfarer.remove_region", text="", icon="REMOVE")
        if 0 <= settings.active_region < len(settings.regions):
            region = settings.regions[settings.active_region]
            column = split_properties(layout).column()
            column.prop(region, "object")
            column.prop(region, "rule")
            column.prop(region, "tag")
            if region.rule != "CONFINE":
                column.prop(region, "margin")


PANELS = (WAYFARER_PT_environment, WAYFARER_PT_body, WAYFARER_PT_regions)
