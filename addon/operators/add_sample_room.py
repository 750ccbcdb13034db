"""Add a room to walk in."""

import bpy

from ..sample.room import SIZE, add_sample_room, configure
from ..scene_collections import OBSTACLES, REGIONS, ROOM, ensure_collection


class WAYFARER_OT_add_sample_room(bpy.types.Operator):
    bl_idname = "wayfarer.add_sample_room"
    bl_label = "Add Sample Room"
    bl_description = "Add a room with walls, pillars, furniture and a step, and use it as the environment"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Switch to Object Mode first")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        obstacles = ensure_collection(scene, OBSTACLES)
        sample = add_sample_room(ensure_collection(scene, ROOM), obstacles, ensure_collection(scene, REGIONS))
        configure(scene.wayfarer.environment, sample, obstacles)
        self.report({"INFO"}, f"A room of {SIZE[0]:g} x {SIZE[1]:g} m; only steps over lead into its far end")
        return {"FINISHED"}
