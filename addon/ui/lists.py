"""Lists of clips, bones and regions."""

import bpy

from ..state import health_of


class WAYFARER_UL_clips(bpy.types.UIList):
    """The character's actions, each with a tick and an icon of its health."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        if item.action is None:
            row.label(text="Deleted Action", icon="ERROR")
            return
        name = row.row(align=True)
        name.active = item.use
        name.label(text=item.action.name, icon="ACTION", translate=False)
        if item.action.pose_markers:
            name.label(text="", icon="BOOKMARKS")
        health = health_of(context.scene, item.action)
        if health is not None:
            icon = "CANCEL" if health.problem else "ERROR" if health.findings else "CHECKMARK"
            row.operator("wayfarer.choose_clip", text="", icon=icon, emboss=False).clip = index

    def filter_items(self, context, data, property_name):
        clips = getattr(data, property_name)
        if not self.filter_name:
            return [], []
        wanted = self.filter_name.lower()
        shown = [
            self.bitflag_filter_item if clip.action and wanted in clip.action.name.lower() else 0 for clip in clips
        ]
        return shown, []


class WAYFARER_UL_joint_weights(bpy.types.UIList):
    """The bones of the character, and how much each counts."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.6)
        split.label(text=item.name, icon="BONE_DATA", translate=False)
        split.prop(item, "weight", text="")


class WAYFARER_UL_regions(bpy.types.UIList):
    """The environment's regions: object, rule and tag."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        if item.object is None:
            row.label(text="No Object", icon="ERROR")
        else:
            row.label(text=item.object.name, icon="MESH_PLANE", translate=False)
        rule = item.bl_rna.properties["rule"].enum_items[item.rule].name
        row.label(text=f"{rule} '{item.tag}'", translate=False)
