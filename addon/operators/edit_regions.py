"""Add regions to the environment and remove them."""

import bpy

from ..properties.environment import REGION_TYPES


class WAYFARER_OT_add_region(bpy.types.Operator):
    bl_idname = "wayfarer.add_region"
    bl_label = "Add Region"
    bl_description = "Make the active object a region, or add one without an object"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        environment = context.scene.wayfarer.environment
        region = environment.regions.add()
        obj = context.active_object
        if obj is not None and obj.type in REGION_TYPES and obj != environment.ground:
            region.object = obj
        environment.active_region = len(environment.regions) - 1
        return {"FINISHED"}


class WAYFARER_OT_remove_region(bpy.types.Operator):
    bl_idname = "wayfarer.remove_region"
    bl_label = "Remove Region"
    bl_description = "Remove the region from the list; its object stays"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        environment = context.scene.wayfarer.environment
        if not 0 <= environment.active_region < len(environment.regions):
            cls.poll_message_set("Choose a region first")
            return False
        return True

    def execute(self, context):
        environment = context.scene.wayfarer.environment
        environment.regions.remove(environment.active_region)
        environment.active_region = max(0, min(environment.active_region, len(environment.regions) - 1))
        return {"FINISHED"}
