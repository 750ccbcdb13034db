"""The panels, in the order of the work."""

import bpy

from ..properties import MapQuantity
from ..state import embedding_is_stale, graph_is_stale, map_is_stale, results, walk_is_stale


class _Step:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Wayfarer"

    def result_is_there(self, scene) -> bool:
        """Whether this step has been done."""
        return False

    def result_is_stale(self, scene) -> bool:
        """Whether what it was done with has changed since."""
        return False

    def draw_header_preset(self, context):
        scene = context.scene
        if self.result_is_stale(scene):
            self.layout.label(text="Changed", icon="ERROR")
        elif self.result_is_there(scene):
            self.layout.label(text="", icon="CHECKMARK")


def _numbers(layout, rows) -> None:
    """Names and values in two columns."""
    grid = layout.column(align=True)
    for name, value in rows:
        split = grid.split(factor=0.55, align=True)
        left = split.row()
        left.alignment = "RIGHT"
        left.active = False
        left.label(text=name)
        split.label(text=value, translate=False)


class WAYFARER_PT_clips(_Step, bpy.types.Panel):
    bl_label = "Clips"

    def result_is_there(self, scene):
        return any(clip.use for clip in scene.wayfarer.clips)

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer
        layout.prop(settings, "character", text="", icon="OUTLINER_OB_ARMATURE")
        if settings.character is None:
            column = layout.column(align=True)
            column.operator("wayfarer.add_sample_character", icon="ARMATURE_DATA")
            column.operator("wayfarer.import_bvh", icon="IMPORT")
            return
        row = layout.row()
        row.template_list("WAYFARER_UL_clips", "", settings, "clips", settings, "active_clip", rows=4, maxrows=8)
        column = row.column(align=True)
        column.operator("wayfarer.refresh_clips", text="", icon="FILE_REFRESH")
        column.operator("wayfarer.import_bvh", text="", icon="IMPORT")
        used = sum(clip.use for clip in settings.clips)
        layout.label(text=f"{used} of {len(settings.clips)} clips in use")


class WAYFARER_PT_motion_graph(_Step, bpy.types.Panel):
    bl_label = "Motion Graph"

    def result_is_there(self, scene):
        return results(scene).graph is not None

    def result_is_stale(self, scene):
        return graph_is_stale(scene)

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.graph
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(settings, "frame_rate")
        column.prop(settings, "min_segment_duration")
        column.prop(settings, "max_cost")
        layout.operator("wayfarer.build_motion_graph", icon="NODETREE")
        found = results(context.scene)
        if found.graph is not None:
            numbers = found.summary
            _numbers(
                layout,
                (
                    ("Segments", f"{len(found.graph.segments):,}"),
                    ("Links", f"{len(found.graph.links):,}"),
                    ("Clips", f"{numbers['clips_played']} of {numbers['clips']}"),
                    ("Motion", f"{numbers['motion_seconds']:.1f} s"),
                    ("Dropped", f"{numbers['dropped_seconds']:.1f} s"),
                ),
            )


class WAYFARER_PT_environment(_Step, bpy.types.Panel):
    bl_label = "Environment"

    def result_is_there(self, scene):
        environment = scene.wayfarer.environment
        return environment.ground is not None or environment.obstacles is not None

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.environment
        if settings.ground is None and settings.obstacles is None:
            layout.operator("wayfarer.add_sample_room", icon="HOME")
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(settings, "ground")
        column.prop(settings, "obstacles")
        column = layout.column()
        column.prop(settings, "cell_size")
        column.prop(settings, "n_headings")
        column.prop(settings, "tiled")


class WAYFARER_PT_body(bpy.types.Panel):
    bl_label = "Body"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_parent_id = "WAYFARER_PT_environment"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.environment
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "radius")
        layout.prop(settings, "step_height")
        layout.prop(settings, "head_height")


class WAYFARER_PT_regions(bpy.types.Panel):
    bl_label = "Regions"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_parent_id = "WAYFARER_PT_environment"

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.environment
        row = layout.row()
        row.template_list("WAYFARER_UL_regions", "", settings, "regions", settings, "active_region", rows=2)
        column = row.column(align=True)
        column.operator("wayfarer.add_region", text="", icon="ADD")
        column.operator("wayfarer.remove_region", text="", icon="REMOVE")
        if 0 <= settings.active_region < len(settings.regions):
            region = settings.regions[settings.active_region]
            layout.use_property_split = True
            layout.use_property_decorate = False
            column = layout.column()
            column.prop(region, "object")
            column.prop(region, "rule")
            column.prop(region, "tag")
            if region.rule != "CONFINE":
                column.prop(region, "margin")


class WAYFARER_PT_embedding(_Step, bpy.types.Panel):
    bl_label = "Embedding"

    def result_is_there(self, scene):
        return results(scene).embedding is not None

    def result_is_stale(self, scene):
        return embedding_is_stale(scene)

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.embedding
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(settings, "footprint_rule")
        column.prop(settings, "position_rate")
        column.prop(settings, "heading_rate")
        layout.operator("wayfarer.embed", icon="LIGHTPROBE_VOLUME")
        found = results(context.scene)
        if found.embedding is not None:
            nx, ny, n_headings, _ = found.embedding.shape
            numbers = found.summary
            _numbers(
                layout,
                (
                    ("Grid", f"{nx} x {ny} x {n_headings}"),
                    ("Nodes", f"{numbers['nodes']:,}"),
                    ("Links", f"{numbers['links']:,}"),
                    ("Floor Covered", f"{numbers['coverage']:.0%}"),
                ),
            )


class WAYFARER_PT_map(_Step, bpy.types.Panel):
    bl_label = "Map"

    def result_is_there(self, scene):
        return results(scene).painted is not None

    def result_is_stale(self, scene):
        return map_is_stale(scene)

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.map
        layout.row().prop(settings, "quantity", expand=True)
        layout.operator("wayfarer.paint_map", icon="BRUSH_DATA")
        found = results(context.scene)
        if found.painted is not None:
            _, quantity = found.painted
            unit = "ways" if quantity == MapQuantity.VARIABILITY.name else "headings"
            numbers = found.summary
            _numbers(
                layout,
                (
                    ("Cells Covered", f"{numbers['map_cells']:,}"),
                    ("Most in a Cell", f"{numbers['map_highest']:,} {unit}"),
                ),
            )


class WAYFARER_PT_walk(_Step, bpy.types.Panel):
    bl_label = "Walk"

    def result_is_there(self, scene):
        return results(scene).walk is not None

    def result_is_stale(self, scene):
        return walk_is_stale(scene)

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.walk
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(settings, "duration")
        column.prop(settings, "start")
        column.prop(settings, "seed")
        column.prop(settings, "n_walks")
        column.prop(settings, "use_markers")
        layout.operator("wayfarer.random_walk", icon="MOD_DYNAMICPAINT")
        found = results(context.scene)
        if found.walk is not None:
            numbers = found.summary
            _numbers(
                layout,
                (
                    ("Duration", f"{numbers['walk_seconds']:.1f} s"),
                    ("Length", f"{numbers['walk_length']:.1f} m"),
                    ("Segments", f"{numbers['walk_segments']:,}"),
                ),
            )


PANELS = (
    WAYFARER_PT_clips,
    WAYFARER_PT_motion_graph,
    WAYFARER_PT_environment,
    WAYFARER_PT_body,
    WAYFARER_PT_regions,
    WAYFARER_PT_embedding,
    WAYFARER_PT_map,
    WAYFARER_PT_walk,
)
