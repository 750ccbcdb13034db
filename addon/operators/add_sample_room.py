"""Add a scene to walk in."""

import bpy
from bpy.props import EnumProperty

from ...core.errors import SceneError
from ..sample.layouts import LAYOUTS, layout_of
from ..sample.scene_file import SCENES, append_scene_file


class WAYFARER_OT_add_sample_room(bpy.types.Operator):
    bl_idname = "wayfarer.add_sample_room"
    bl_label = "Add Sample Scene"
    bl_description = (
        "Add a scene with obstacles and use it as the environment; a sample scene that was added before is replaced"
    )
    bl_options = {"REGISTER", "UNDO"}

    sample: EnumProperty(
        items=[(layout.key, layout.label, layout.description) for layout in LAYOUTS],
        name="Scene",
        description="Which scene to add",
        default=LAYOUTS[0].key,
    )

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Switch to Object Mode first")
            return False
        return True

    def execute(self, context):
        layout = layout_of(self.sample)
        try:
            append_scene_file(context.scene, SCENES / layout.file_name)
        except SceneError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, layout.description)
        return {"FINISHED"}
