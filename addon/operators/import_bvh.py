"""Import a folder of motion capture onto one armature."""

from pathlib import Path
from typing import cast

import bpy
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, StringProperty

from ...core.errors import ClipError
from ...core.motion.airborne import jump_mask
from ...core.progress import Progress, portion
from ..bridge.body import add_body
from ..bridge.import_bvh import bvh_files, import_bvh_files_steps, restore, what_is_there
from ..bridge.owned import CHARACTER, ensure_collection
from ..bridge.read_actions import read_clip
from ..bridge.tags import write_tags
from ..bridge.text import counted
from ..jobs import LongOperator


class WAYFARER_OT_import_bvh(LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.import_bvh"
    bl_label = "Import BVH Folder"
    bl_description = "Import BVH files as actions of one new character: those that are selected, or all of a folder"

    directory: StringProperty(
        name="Folder", description="All BVH files in it are imported", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
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

    _in_window = False

    def invoke(self, context, event):
        self._in_window = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        # The file selector ends here, too: from now on it is long work like any other.
        return super().invoke(context, None) if self._in_window else super().execute(context)

    def steps(self, context):
        folder = Path(bpy.path.abspath(self.directory))
        if not folder.is_dir():
            raise ClipError(f"There is no folder '{folder}'; choose one with BVH files in it.")
        # Where nothing is selected, the file browser gives the name in its text field: often that of the .blend file.
        chosen = [folder / file.name for file in self.files if file.name.lower().endswith(".bvh")]
        missing = [path.name for path in chosen if not path.is_file()]
        if missing:
            raise ClipError(
                f"There is no file '{missing[0]}' in '{folder}'; choose files that are there, or none to import all."
            )
        paths = chosen or bvh_files(folder)
        before, complete = what_is_there(), False
        try:
            armature, actions, problems = yield from portion(
                import_bvh_files_steps(paths, self.scale or None), 0.0, 0.8
            )
            uid, uids = armature.session_uid, {action.session_uid for action in actions}
            tags, unknown = yield from portion(self._jump_steps(uid, uids), 0.8, 1.0)
            complete = True
        finally:
            if not complete:
                restore(before)
        return before, uid, uids, problems, tags, unknown

    def apply(self, context, result):
        before, *imported = result
        try:
            self._add(context, *imported)
        except BaseException:
            restore(before)
            raise

    def _add(self, context, uid: int, uids: set[int], problems, tags, unknown: str) -> None:
        armature = next(obj for obj in bpy.data.objects if obj.session_uid == uid)
        actions = {action.session_uid: action for action in bpy.data.actions if action.session_uid in uids}
        for action_uid, (masks, first_frame) in tags.items():
            write_tags(actions[action_uid], masks, first_frame)
        collection = ensure_collection(context.scene, CHARACTER)
        for other in armature.users_collection:
            other.objects.unlink(armature)
        collection.objects.link(armature)
        cast(bpy.types.Armature, armature.data).display_type = "STICK"
        bodiless = self.use_body and add_body(armature) is None
        settings = context.scene.wayfarer
        settings.character = armature
        settings.refresh_clips()
        for name, reason in problems:
            self.report({"WARNING"}, f"Left out '{name}': {reason}")
        if unknown:
            self.report({"WARNING"}, f"No jumps were tagged: {unknown}")
        if bodiless:
            self.report({"WARNING"}, "No body was added: the bones are too short for it to be seen")
        jumps = f", {len(tags)} of them with jumps" if tags else ""
        self.report({"INFO"}, f"{counted(len(actions), 'clip')} imported{jumps}")

    def _jump_steps(self, uid: int, uids: set[int]):
        """Tags of the actions that hold jumps, by their session id: (masks, first frame); and, if jumps could not be
        looked for, why.
        """
        tag = self.jump_tag.strip()
        if not tag:
            return {}, ""
        tags = {}
        for done, action_uid in enumerate(sorted(uids)):
            yield Progress(done / len(uids), "Looking for jumps")
            armature = next(obj for obj in bpy.data.objects if obj.session_uid == uid)
            action = next(action for action in bpy.data.actions if action.session_uid == action_uid)
            clip = read_clip(armature, action)
            try:
                mask = jump_mask(clip, self.jump_height)
            except ClipError as error:
                # A character whose feet cannot be told is imported all the same.
                return {}, str(error)
            if mask.any():
                tags[action_uid] = {**clip.tags, tag: mask}, int(clip.first_frame)
        return tags, ""
