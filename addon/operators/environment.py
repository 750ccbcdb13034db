"""The body's radius, and the regions."""

import bpy

from ...core.errors import SceneError
from ...core.motion.body_size import body_radius
from ...core.wording import counted, length
from ..bridge.rig import bind_rig
from ..properties.environment import REGION_TYPES
from ..scene.unlisted import unlisted_objects
from .mixins import Needs, NeedsCharacter, reports_errors


class WAYFARER_OT_fit_radius(NeedsCharacter, bpy.types.Operator):
    bl_idname = "wayfarer.fit_radius"
    bl_label = "Radius from Character"
    bl_description = "Set the radius to half the width of the character's shoulders, and what flesh adds to it"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context):
        settings = context.scene.wayfarer
        radius = body_radius(bind_rig(settings.character).skeleton)
        settings.environment.radius = radius
        self.report({"INFO"}, f"The character needs {length(radius)} to each side")


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


class WAYFARER_OT_remove_region(Needs, bpy.types.Operator):
    bl_idname = "wayfarer.remove_region"
    bl_label = "Remove Region"
    bl_description = "Remove the region from the list; its object stays"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def problem(cls, context):
        environment = context.scene.wayfarer.environment
        return "" if 0 <= environment.active_region < len(environment.regions) else "Choose a region first"

    def execute(self, context):
        environment = context.scene.wayfarer.environment
        environment.regions.remove(environment.active_region)
        environment.active_region = max(0, min(environment.active_region, len(environment.regions) - 1))
        return {"FINISHED"}


class WAYFARER_OT_add_obstacles(bpy.types.Operator):
    bl_idname = "wayfarer.add_obstacles"
    bl_label = "Add to Obstacles"
    bl_description = (
        "Put what stands on the ground into the collection of obstacles, a new one if there is none; it stays in its "
        "other collections"
    )
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context):
        scene, environment = context.scene, context.scene.wayfarer.environment
        found = unlisted_objects(scene)
        if not found:
            raise SceneError("Everything that stands on the ground is an obstacle already.")
        if environment.obstacles is None:
            environment.obstacles = bpy.data.collections.new("Obstacles")
            scene.collection.children.link(environment.obstacles)
        if not environment.obstacles.is_editable:
            raise SceneError(
                f"The collection '{environment.obstacles.name}' comes from another file; choose one of this file."
            )
        for obj in found:
            environment.obstacles.objects.link(obj)
        self.report({"INFO"}, f"{counted(len(found), 'object')} added to '{environment.obstacles.name}'")


CLASSES = (WAYFARER_OT_add_obstacles, WAYFARER_OT_fit_radius, WAYFARER_OT_add_region, WAYFARER_OT_remove_region)
