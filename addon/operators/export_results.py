"""Write what was found out to files."""

from pathlib import Path
from typing import cast

import bpy
from bpy.props import BoolProperty, StringProperty

from ...core.errors import MotionGraphError
from ..bridge.text import counted
from ..exports.results import export_results


class WAYFARER_OT_export_results(bpy.types.Operator):
    bl_idname = "wayfarer.export_results"
    bl_label = "Export Results"
    bl_description = "Write everything that was found out, and the painted map, to a folder"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(
        name="Folder", description="The folder to write to", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        if not context.scene.wayfarer.findings:
            cls.poll_message_set("Find something out first: measure, or look for weak spots")
            return False
        return True

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def draw(self, context):
        settings = context.scene.wayfarer.evaluation
        for name in ("use_json", "use_csv", "use_pictures"):
            cast(bpy.types.UILayout, self.layout).prop(settings, name)

    def execute(self, context):
        settings = context.scene.wayfarer.evaluation
        folder = Path(bpy.path.abspath(self.directory)) if self.directory else None
        if folder is None or not folder.is_dir():
            self.report({"ERROR"}, f"There is no folder '{self.directory}'; choose one that exists")
            return {"CANCELLED"}
        try:
            files = export_results(context.scene, folder, settings.use_json, settings.use_csv, settings.use_pictures)
        except MotionGraphError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{counted(len(files), 'file')} in '{folder}'")
        return {"FINISHED"}
