"""Write embedding and clips for game engines."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty

from ...core.errors import MotionGraphError
from ..engine_folder import write_engine_folder
from ..state import embedding_of
from .needs_embedding import NeedsEmbedding


class WAYFARER_OT_export_engine(NeedsEmbedding, bpy.types.Operator):
    bl_idname = "wayfarer.export_engine"
    bl_label = "Export for Engines"
    bl_description = (
        "Write the embedding, in a documented format, and the clips, as glTF, into a folder, with a reader in Python "
        "that walks and plans without Wayfarer"
    )
    bl_options = {"REGISTER", "UNDO"}

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

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        if not self.directory:
            self.report({"ERROR"}, "Choose a folder to write to")
            return {"CANCELLED"}
        folder = Path(bpy.path.abspath(self.directory))
        try:
            written = write_engine_folder(
                context.scene, embedding_of(context.scene), folder, self.use_clips, self.use_table
            )
        except MotionGraphError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(written)} files in '{folder}'")
        self.warn_if_stale(context.scene)
        return {"FINISHED"}
