"""Get the character's motions out of another .blend file."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty

from ...core.errors import ClipError
from ..bridge.action_curves import action_curves
from ..bridge.clip_actions import character_problem
from ..bridge.libraries import forget_file
from ..bridge.owned import WALK_PROPERTY
from ..bridge.text import counted


class WAYFARER_OT_append_actions(bpy.types.Operator):
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

    @classmethod
    def poll(cls, context):
        problem = character_problem(context.scene)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        settings, path = context.scene.wayfarer, Path(bpy.path.abspath(self.filepath))
        if not path.is_file():
            self.report({"ERROR"}, f"There is no file '{path}'; choose a .blend file")
            return {"CANCELLED"}
        if bpy.data.filepath and path.resolve() == Path(bpy.data.filepath).resolve():
            self.report({"ERROR"}, "That is the file that is open; its actions are listed already")
            return {"CANCELLED"}
        before = {action.session_uid for action in bpy.data.actions}
        try:
            library: Any = bpy.data.libraries.load(str(path), link=self.link, assets_only=self.assets_only)
            with library as (there, here):  # the stubs have it return nothing
                here.actions = list(there.actions)
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, f"'{path.name}' cannot be read: {str(error).strip().splitlines()[-1]}")
            return {"CANCELLED"}
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
