"""The report of a scene, as a page in the browser."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty

from ...core.report.scene_report import report_files
from ..bridge.text import counted
from ..exports.folder import write_files
from ..exports.report import scene_report_steps, show_page
from ..jobs import LongOperator
from .asks_embedding import AsksEmbedding


class WAYFARER_OT_write_report(AsksEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.write_report"
    bl_label = "Write Report"
    bl_description = (
        "Write a page on what the character can reach, what is weak, what matters and what is missing, with its tables "
        "and pictures, to a folder inside the one that is chosen, and open it in the browser"
    )

    directory: StringProperty(
        name="Folder", description="The folder to write to", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})
    thorough: BoolProperty(
        name="Thorough",
        description="Look at every segment, every motion that might be captured and at many places, which takes longer",
        default=False,
    )
    open_page: BoolProperty(name="Open", description="Open the page in the browser", default=True)
    browsed: BoolProperty(default=False, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context, event):
        if not self.directory:
            self.browsed = True
            context.window_manager.fileselect_add(self)
            return {"RUNNING_MODAL"}
        return super().invoke(context, event)

    def execute(self, context):
        folder = Path(bpy.path.abspath(self.directory)) if self.directory else None
        if folder is None or not folder.is_dir():
            self.report({"ERROR"}, f"There is no folder '{self.directory}'; choose one that exists")
            return {"CANCELLED"}
        if self.browsed:
            # From the file browser, which would stand still until all was done; as a step of undo of its own.
            options = {"thorough": self.thorough, "open_page": self.open_page}
            bpy.ops.wayfarer.write_report("INVOKE_DEFAULT", True, directory=self.directory, **options)
            return {"CANCELLED"}
        return super().execute(context)

    def steps(self, context):
        return scene_report_steps(context.scene, self.thorough)

    def apply(self, context, result):
        # A folder of its own: it is many files, with names that others may have.
        folder = Path(bpy.path.abspath(self.directory)) / f"{bpy.path.clean_name(context.scene.name)}_report"
        files = report_files(result)
        write_files(folder, files)
        page = folder / next(iter(files))
        if self.open_page:
            show_page(page)
        self.report({"INFO"}, f"Wrote '{page}' and {counted(len(files) - 1, 'file')} beside it")
        self.warn_if_stale(context.scene)
