"""Motion from other files: BVH, FBX and glTF, and .blend files."""

from pathlib import Path
from typing import Any, cast

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, StringProperty

from ...core.errors import ClipError
from ...core.files import full_path
from ...core.motion.airborne import jump_mask
from ...core.motion.bvh.character import TO_Z_UP
from ...core.motion.doctor.posture import posture_findings
from ...core.progress import Progress, portion
from ...core.wording import counted
from ..bridge.action_curves import action_curves
from ..bridge.blenders_importers import with_family
from ..bridge.body import add_body
from ..bridge.clip_actions import character_problem
from ..bridge.import_bvh import bvh_files
from ..bridge.import_motion import SUFFIXES, MotionImport, import_motion_steps, motion_files
from ..bridge.import_state import restore, what_is_there
from ..bridge.libraries import forget_file
from ..bridge.owned import CHARACTER, WALK_PROPERTY, ensure_collection
from ..bridge.read_actions import read_clip
from ..bridge.tags import write_tags
from ..bridge.write_action import assign_action
from .mixins import Browses, NeedsObjectMode, NeedsRig, reports_errors
from .remedies import doubts_in_words


class _ImportsMotion(NeedsObjectMode, Browses):
    """Mixin: files, or a folder, as actions of a character."""

    suffixes = SUFFIXES

    directory: StringProperty(
        name="Folder",
        description="All files in it that can hold motion are imported",
        subtype="DIR_PATH",
        options={"SKIP_SAVE"},
    )
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    filter_glob: StringProperty(default="*.bvh;*.fbx;*.glb;*.gltf", options={"HIDDEN"})
    scale: FloatProperty(
        name="Scale",
        description="Metres per unit of BVH files; 0 finds it from the size of the character",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=4,
    )
    up_axis: EnumProperty(
        name="Up",
        description="The axis that points up in BVH files",
        items=(
            ("AUTO", "From the Motion", "Find it from the motion: the head is above the feet"),
            *((axis, axis, f"{axis} is up in the files") for axis in TO_Z_UP),
        ),
        default="AUTO",
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
    use_body: BoolProperty(
        name="Add Body", description="Add a simple body to a new character that has none", default=True
    )

    def steps(self, context):
        folder = Path(bpy.path.abspath(self.directory))
        if not folder.is_dir():
            raise ClipError(f"There is no folder '{folder}'; choose one that holds motion.")
        # Where nothing is selected, the file browser gives the name in its text field: often that of the .blend file.
        chosen = [folder / file.name for file in self.files if file.name.lower().endswith(self.suffixes)]
        missing = [path.name for path in chosen if not path.is_file()]
        if missing:
            raise ClipError(
                f"There is no file '{missing[0]}' in '{folder}'; choose files that are there, or none to import all."
            )
        paths = chosen or self.all_of(folder)
        character = self.character(context)
        before, complete = what_is_there(), False
        try:
            up = "" if self.up_axis == "AUTO" else self.up_axis
            work = import_motion_steps(paths, character, self.scale or None, up)
            made = yield from portion(work, 0.0, 0.8)
            looked = yield from portion(self._look_steps(made.armature, set(made.actions)), 0.8, 1.0)
            complete = True
        finally:
            if not complete:
                restore(before)
        return before, made, *looked

    def character(self, context):
        """Return the armature that the motion is for; None for a new one."""
        character = context.scene.wayfarer.character
        return character if character is not None and not character_problem(context.scene) else None

    def all_of(self, folder: Path) -> list[Path]:
        """List the files of a folder."""
        return motion_files(folder)

    def apply(self, context, result):
        before, *imported = result
        try:
            self._add(context, *imported)
        except BaseException:
            restore(before)
            raise

    def _add(self, context, made: MotionImport, tags, unknown: str, doubtful) -> None:
        armature = next(obj for obj in bpy.data.objects if obj.session_uid == made.armature)
        actions = {action.session_uid: action for action in bpy.data.actions if action.session_uid in made.actions}
        for action_uid, (masks, first_frame) in tags.items():
            write_tags(actions[action_uid], masks, first_frame)
        bodiless = made.is_new and self._settle(context.scene, armature, made)
        settings = context.scene.wayfarer
        if settings.character != armature:
            settings.character = armature
        settings.refresh_clips()
        for name, reason in made.problems:
            self.report({"WARNING"}, f"Left out '{name}': {reason}")
        for remark in made.remarks:
            self.report({"INFO"}, remark)
        if unknown:
            self.report({"WARNING"}, f"No jumps were tagged: {unknown}")
        if bodiless:
            self.report({"WARNING"}, "No body was added: the bones are too short for it to be seen")
        for sentence in doubts_in_words(context.scene, [actions[action_uid] for action_uid in doubtful]):
            self.report({"WARNING"}, sentence)
        jumps = f", {len(tags)} of them with jumps" if tags else ""
        self.report({"INFO"}, f"{counted(len(actions), 'clip')} imported{jumps}")

    def _settle(self, scene, armature, made: MotionImport) -> bool:
        """Give a new character its place in the scene; return True if it lacks the body that is asked for."""
        collection = ensure_collection(scene, CHARACTER)
        for obj in with_family(armature):
            for other in obj.users_collection:
                other.objects.unlink(obj)
            collection.objects.link(obj)
        if made.actions:
            first = next(action for action in bpy.data.actions if action.session_uid == made.actions[0])
            assign_action(armature, first)
        if made.has_body:
            return False
        cast(bpy.types.Armature, armature.data).display_type = "STICK"
        return self.use_body and add_body(armature) is None

    def _look_steps(self, uid: int, uids: set[int]):
        """Tags of the actions that hold jumps, by their session id: (masks, first frame); if jumps could not be looked
        for, why; and the ids of the actions that show something to be wrong with the character.
        """
        tag, tags, unknown, doubtful = self.jump_tag.strip(), {}, "", []
        for done, action_uid in enumerate(sorted(uids)):
            yield Progress(done / len(uids), "Looking at the motion")
            armature = next(obj for obj in bpy.data.objects if obj.session_uid == uid)
            action = next(action for action in bpy.data.actions if action.session_uid == action_uid)
            clip = read_clip(armature, action)
            if any(posture_findings(clip)):
                doubtful.append(action_uid)
            if not tag or unknown:
                continue
            try:
                mask = jump_mask(clip, self.jump_height)
            except ClipError as error:
                # A character whose feet cannot be told is imported all the same.
                unknown = str(error)
                continue
            if mask.any():
                tags[action_uid] = {**clip.tags, tag: mask}, int(clip.first_frame)
        return tags, unknown, doubtful


class WAYFARER_OT_import_motion(_ImportsMotion, bpy.types.Operator):
    bl_idname = "wayfarer.import_motion"
    bl_label = "Import Motion"
    bl_description = (
        "Import BVH, FBX and glTF files as actions of the character, or of a new one if none is chosen: those that are "
        "selected, or all of a folder"
    )


class WAYFARER_OT_import_bvh(_ImportsMotion, bpy.types.Operator):
    bl_idname = "wayfarer.import_bvh"
    bl_label = "Import BVH Folder"
    bl_description = "Import BVH files as actions of one new character: those that are selected, or all of a folder"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    suffixes = (".bvh",)

    def character(self, context):
        return None

    def all_of(self, folder):
        return bvh_files(folder)


class WAYFARER_OT_append_actions(NeedsRig, bpy.types.Operator):
    bl_idname = "wayfarer.append_actions"
    bl_label = "Actions from File"
    bl_description = "Add the actions of another .blend file, or of an asset library, that move the character's bones"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", description="The .blend file", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_blender: BoolProperty(default=True, options={"HIDDEN"})
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})
    link: BoolProperty(
        name="Link", description="Leave the actions in their file and follow its changes, instead of copying them"
    )
    assets_only: BoolProperty(
        name="Only Assets", description="Leave out the actions of the file that are not marked as assets"
    )

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @reports_errors
    def execute(self, context):
        settings, path = context.scene.wayfarer, Path(bpy.path.abspath(self.filepath))
        if not path.is_file():
            raise ClipError(f"There is no file '{path}'; choose a .blend file")
        if bpy.data.filepath and full_path(path) == full_path(bpy.data.filepath):
            raise ClipError("That is the file that is open; its actions are listed already")
        before = {action.session_uid for action in bpy.data.actions}
        try:
            library: Any = bpy.data.libraries.load(str(path), link=self.link, assets_only=self.assets_only)
            with library as (there, here):  # the stubs have it return nothing
                here.actions = list(there.actions)
        except (OSError, RuntimeError) as error:
            raise ClipError(
                f"'{path.name}' cannot be read: it is no .blend file, is damaged, or comes from a later version of "
                "Blender. Choose another"
            ) from error
        loaded = [action for action in bpy.data.actions if action.session_uid not in before]
        useless = [action for action in loaded if not _moves(settings.character, action)]
        bpy.data.batch_remove(useless)
        forget_file(path)
        kept = len(loaded) - len(useless)
        if kept == 0:
            self.report({"WARNING"}, f"No new action of '{path.name}' moves bones of '{settings.character.name}'")
            return {"CANCELLED"}
        for action in bpy.data.actions:
            if action.session_uid not in before and action.library is None:
                action.use_fake_user = True
                # Now it belongs to this character, whoever it was made for.
                action_curves(settings.character, action).slot.name_display = settings.character.name
        settings.refresh_clips()
        left_out = f"; {counted(len(useless), 'other action')} left out" if useless else ""
        self.report({"INFO"}, f"{counted(kept, 'clip')} from '{path.name}'{left_out}")
        return {"FINISHED"}


def _moves(character, action) -> bool:
    if WALK_PROPERTY in action:
        return False
    try:
        action_curves(character, action)
    except ClipError:
        return False
    return True


CLASSES = (WAYFARER_OT_import_motion, WAYFARER_OT_import_bvh, WAYFARER_OT_append_actions)
