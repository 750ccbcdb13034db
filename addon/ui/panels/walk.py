"""Walking."""

import bpy

from ...state import results, walk_is_stale
from .step import Step, draw_numbers, split_properties


class WAYFARER_PT_walk(Step, bpy.types.Panel):
    bl_label = "Walk"

    def result_is_there(self, scene):
        return results(scene).walk is not None

    def result_is_stale(self, scene):
        return walk_is_stale(scene)

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer.walk
        column = layout.column()
        column.prop(settings, "duration")
        column.prop(settings, "style")
        column.prop(settings, "start")
        column.prop(settings, "seed")
        column.prop(settings, "use_markers")
        layout.operator("wayfarer.random_walk", icon="MOD_DYNAMICPAINT")
        found = results(context.scene)
        if found.walk is not None:
            numbers = found.summary
            draw_numbers(
                layout,
                (
                    ("Duration", f"{numbers['walk_seconds']:.1f} s"),
                    ("Length", f"{numbers['walk_length']:.1f} m"),
                    ("Segments", f"{numbers['walk_segments']:,}"),
                ),
            )


PANELS = (WAYFARER_PT_walk,)
