"""Write embedding and clips for game engines."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty

from ..exports.engine import engine_folder_steps, write_engine_folder
from ..jobs import LongOperator
from ..results.store import embedding_of
from .needs_embedding import NeedsEmbedding


class WAYFARER_OT_export_engine(NeedsEmbedding, LongOperator, bpy.types.Operator):
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
    browsed: BoolProperty(default=False, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context, event):
        if not self.directory:
            self.browsed = True
            context.window_manager.fileselect_add(self)
            return {"RUNNING_MODAL"}
        return super().invoke(context, event)

    def execute(self, context):
        if not self.directory:
            self.report({"ERROR"}, "Choose a folder to write to")
            return {"CANCELLED"}
        if self.browsed:
            # From the file browser, which would stand still until all was done; as a step of undo of its own.
            options = {"use_clips": self.use_clips, "use_table": self.use_table}
            bpy.ops.wayfarer.export_engine("INVOKE_DEFAULT", True, directory=self.directory, **options)
            return {"CANCELLED"}
        return super().execute(context)

    def steps(self, context):
        return engine_folder_steps(
            context.scene, embedding_of(context.scene), self._folder(), self.use_clips, self.use_table
        )

    def apply(self, context, result):
        folder = self._folder()
        write_engine_folder(folder, result)
        self.report({"INFO"}, f"{len(result)} files in '{folder}'")
        self.warn_if_stale(context.scene)

    def _folder(self) -> Path:
        return Path(bpy.path.abspath(self.directory))
