"""Files for others: results, the report, engines."""

from pathlib import Path
from typing import cast

import bpy
from bpy.props import BoolProperty, StringProperty

from ...core.errors import ExportError
from ...core.files import write_files
from ...core.report.scene_report import report_files
from ...core.wording import counted
from ..exports.engine import engine_folder_steps, write_engine_folder
from ..exports.report import scene_report_steps, show_page
from ..exports.results import export_results
from ..results.store import embedding_of
from .mixins import AsksEmbedding, Browses, Needs, NeedsEmbedding, reports_errors


class WAYFARER_OT_export_results(Needs, bpy.types.Operator):
    bl_idname = "wayfarer.export_results"
    bl_label = "Export Results"
    bl_description = "Write everything that was found out, and the painted map, to a folder"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(
        name="Folder", description="The folder to write to", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})

    @classmethod
    def problem(cls, context):
        found = context.scene.wayfarer.findings
        return "" if found else "Find something out first: measure, or look for weak spots"

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def draw(self, context):
        settings = context.scene.wayfarer.evaluation
        for name in ("use_json", "use_csv", "use_pictures"):
            cast(bpy.types.UILayout, self.layout).prop(settings, name)

    @reports_errors
    def execute(self, context):
        settings = context.scene.wayfarer.evaluation
        folder = _existing_folder(self.directory)
        files = export_results(context.scene, folder, settings.use_json, settings.use_csv, settings.use_pictures)
        self.report({"INFO"}, f"{counted(len(files), 'file')} in '{folder}'")


def _existing_folder(directory: str) -> Path:
    folder = Path(bpy.path.abspath(directory))
    if not directory or not folder.is_dir():
        raise ExportError(f"There is no folder '{directory}'; choose one that exists")
    return folder


class WAYFARER_OT_write_report(AsksEmbedding, Browses, bpy.types.Operator):
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

    def steps(self, context):
        _existing_folder(self.directory)
        return (yield from scene_report_steps(context.scene, self.thorough))

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


class WAYFARER_OT_export_engine(NeedsEmbedding, Browses, bpy.types.Operator):
    bl_idname = "wayfarer.export_engine"
    bl_label = "Export for Engines"
    bl_description = (
        "Write the embedding, in a documented format, and the clips, as glTF, into a folder, with a reader in Python "
        "that walks and plans without Wayfarer"
    )

    directory: StringProperty(
        name="Folder", description="Where the files are written", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})
    use_clips: BoolProperty(
        name="Clips", description="Also write the character and its clips as clips.glb", default=True
    )
    use_table: BoolProperty(
        name="Table",
        description="Also write nodes and links as a plain table: 12 bytes for each node, 4 for each link",
        default=True,
    )

    def steps(self, context):
        if not self.directory:
            raise ExportError("Choose a folder to write to")
        embedding, folder = embedding_of(context.scene), self._folder()
        steps = engine_folder_steps(context.scene, embedding, folder, self.use_clips, self.use_table)
        return (yield from steps)

    def apply(self, context, result):
        folder = self._folder()
        write_engine_folder(folder, result)
        self.report({"INFO"}, f"{len(result)} files in '{folder}'")
        self.warn_if_stale(context.scene)

    def _folder(self) -> Path:
        return Path(bpy.path.abspath(self.directory))


CLASSES = (WAYFARER_OT_export_results, WAYFARER_OT_write_report, WAYFARER_OT_export_engine)
