"""Lists that belong to walks."""

from typing import Any

import bpy


class WAYFARER_UL_worst_frames(bpy.types.UIList):
    """Frames of the last walk that are worth looking at, the worst first; a click shows one."""

    def draw_item(self, context, layout, data, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.17, align=True)
        jump = split.operator("wayfarer.jump_to_frame", text=f"{item.frame}", emboss=False, translate=False)
        jump.worst = index
        # Numbers are told only by all of their digits.
        split = split.split(factor=0.54, align=True)
        split.label(text=item.what, translate=False)
        right = split.row(align=True)
        right.alignment = "RIGHT"
        right.active = item.severity >= 1.0
        right.label(text=item.amount, translate=False)

    def draw_filter(self, context, layout):
        layout.prop(self, "filter_name", text="")

    def filter_items(self, context, data, property_name):
        wanted = self.filter_name.lower()
        return [
            self.bitflag_filter_item if wanted in f"{entry.frame} {entry.what}".lower() else 0
            for entry in getattr(data, property_name)
        ], []


class WAYFARER_UL_clip_weights(bpy.types.UIList):
    """The clips in use, and how much each weighs."""

    def draw_item(self, context, layout, data, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.7)
        if item.action is None:
            split.label(text="Deleted Action", icon="ERROR")
            return
        split.label(text=item.action.name, translate=False)
        split.prop(item, "weight", text="", emboss=False)

    def filter_items(self, context, data, property_name):
        wanted = self.filter_name.lower()
        return [
            self.bitflag_filter_item
            if clip.use and clip.action is not None and wanted in clip.action.name.lower()
            else 0
            for clip in getattr(data, property_name)
        ], []


WALK_LISTS = (WAYFARER_UL_worst_frames, WAYFARER_UL_clip_weights)
