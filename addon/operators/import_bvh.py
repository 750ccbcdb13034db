"""Import a folder of motion capture onto one armature."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ...core.errors import ClipError, MotionGraphError
from ...core.motion.airborne import jump_mask
from ..bridge.body import add_body
from ..bridge.import_bvh import import_bvh_folder
from ..bridge.read_actions import read_clips
from ..bridge.tags import write_tags
from ..scene_collections import CHARACTER, ensure_collection


class WAYFARER_OT_import_bvh(bpy.types.Operator):
    bl_idname = "wayfarer.import_bvh"
    bl_label = "Import BVH Folder"
    bl_description = "Import all BVH files of a folder as actions of one new character"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(
        name="Folder", description="All BVH files in it are imported", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )
    filter_glob: StringProperty(default="*.bvh", options={"HIDDEN"})
    scale: FloatProperty(
        name="Scale",
        description="Metres per unit of the files; 0 guesses it from the size of the character",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=4,
    )
    jump_tag: StringProperty(
        name="Tag Jumps As",
        description="Tag the frames of jumps in which both feet clear the jump height; empty for no tags",
        default="step",
    )
    jump_height: FloatProperty(
        name="Jump Height",
        description="Height that both feet clear in a jump that is tagged",
        subtype="DISTANCE",
        default=0.25,
        min=0.05,
        soft_max=0.6,
    )
    use_body: BoolProperty(name="Add Body", description="Add a simple body that shows the motion", default=True)

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Switch to Object Mode first")
            return False
        return True

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        folder = Path(bpy.path.abspath(self.directory))
        try:
            if not folder.is_dir():
                raise ClipError(f"There is no folder '{folder}'; choose one with BVH files in it.")
            armature, actions, problems = import_bvh_folder(folder, self.scale or None)
            tagged = self._tag_jumps(armature, actions)
        except MotionGraphError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        collection = ensure_collection(context.scene, CHARACTER)
        for other in armature.users_collection:
            other.objects.unlink(armature)
        collection.objects.link(armature)
        armature.data.display_type = "STICK"
        if self.use_body:
            add_body(armature)
        settings = context.scene.wayfarer
        settings.character = armature
        settings.refresh_clips()
        for name, reason in problems:
            self.report({"WARNING"}, f"Left out '{name}': {reason}")
        jumps = f", {tagged} of them with jumps" if tagged else ""
        self.report({"INFO"}, f"{len(actions)} clips imported{jumps}")
        return {"FINISHED"}

    def _tag_jumps(self, armature, actions) -> int:
        """Tag the jumps of the actions; returns how many actions hold any."""
        tag = self.jump_tag.strip()
        if not tag:
            return 0
        clips, _ = read_clips(armature, actions)
        tagged = 0
        for clip in clips:
            mask = jump_mask(clip, self.jump_height)
            if mask.any():
                write_tags(bpy.data.actions[clip.name], {**clip.tags, tag: mask}, int(clip.first_frame))
                tagged += 1
        return tagged
