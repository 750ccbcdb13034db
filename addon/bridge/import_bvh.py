"""A folder of BVH files as actions of one armature, by Blender's own importer."""

import contextlib
import io
from pathlib import Path

import addon_utils
import bpy

from ...core.errors import ClipError
from .bvh_file import check_bvh, guess_bvh_scale
from .read_actions import FRAME_RATE_PROPERTY, read_clip

_IMPORTER = "io_anim_bvh"
_COLLECTIONS = ("objects", "armatures", "actions")


def import_bvh_folder(folder, scale: float | None = None) -> tuple:
    """Import every BVH file of a folder, in the order of their names, onto one armature.

    Returns (armature object, actions, problems): actions are named after their files and keep every frame of
    theirs, from frame 1, one frame apart; their own rate is in the custom property ``wayfarer_frame_rate``,
    which :func:`read_clip` honours. Problems are (file name, reason) of those that were left out: damaged
    files, and those whose bones are not the ones of the first.

    ``scale`` is the length of a file's unit in metres; by default it is guessed (:func:`guess_bvh_scale`)
    from the first file that can be read, for all. The scene's rate and frame range stay as they are.

    Raises ClipError if the folder has no BVH file, or none that can be used.
    """
    folder = Path(folder)
    paths = sorted(path for path in folder.glob("*") if path.suffix.lower() == ".bvh")
    if not paths:
        raise ClipError(f"The folder '{folder}' holds no BVH files; choose one with motion capture in it.")
    return import_bvh_files(paths, scale)


def import_bvh_files(paths, scale: float | None = None) -> tuple:
    """Like :func:`import_bvh_folder`, for these files."""
    if not addon_utils.check(_IMPORTER)[1]:
        addon_utils.enable(_IMPORTER)
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    armature_object, actions, problems = None, [], []
    for path in map(Path, paths):
        try:
            scale = scale or guess_bvh_scale(path)
            imported, action = _import_file(path, scale)
        except ClipError as error:
            problems.append((path.name, str(error)))
            continue
        if armature_object is None:
            armature_object = imported
        else:
            difference = _bone_difference(armature_object, imported)
            _remove(imported, None if not difference else action)
            if difference:
                problems.append((path.name, difference))
                continue
        # One name, so that Blender finds the slot when the actions are switched; 4.5 names it after the file.
        action.slots[0].name_display = armature_object.name
        actions.append(action)
    if armature_object is None:
        reasons = " ".join(reason for _, reason in problems)
        raise ClipError(f"None of the BVH files can be used. {reasons}")
    armature_object.animation_data.action = None
    animation = armature_object.animation_data
    animation.action = actions[0]
    animation.action_slot = actions[0].slots[0]
    return armature_object, actions, problems


def _import_file(path: Path, scale: float):
    """The armature object and the action of one file; ClipError, and nothing left behind, if it is damaged."""
    frame_rate = check_bvh(path)
    before = {name: set(getattr(bpy.data, name)) for name in _COLLECTIONS}
    try:
        # The importer tells its progress on stdout, Blender the importer's errors on stderr.
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            bpy.ops.import_anim.bvh(
                filepath=str(path),
                axis_forward="-Z",
                axis_up="Y",
                global_scale=scale,
                rotate_mode="NATIVE",
                frame_start=1,
                use_fps_scale=False,
                update_scene_fps=False,
                update_scene_duration=False,
            )
        imported = bpy.context.view_layer.objects.active
        if imported is None or imported in before["objects"]:
            raise ClipError(f"'{path.name}' holds no skeleton; it is not a BVH file or is damaged.")
        action = imported.animation_data.action
        imported.name = imported.data.name = action.name = path.stem
        read_clip(imported, action)  # so that what cannot be read is found now
    except ClipError:
        _restore(before)
        raise
    except RuntimeError as error:  # whatever the importer stumbled over
        _restore(before)
        raise ClipError(f"'{path.name}' is damaged, Blender's importer reports: {_reason(error)}.") from None
    action.use_fake_user = True
    action[FRAME_RATE_PROPERTY] = frame_rate
    return imported, action


def _reason(error) -> str:
    """The exception's line of a traceback."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and not line.startswith("Location:")]
    return lines[-1].rstrip(".") if lines else "no reason"


def _bone_difference(armature_object, other) -> str:
    """Why clips of the two cannot be mixed, or nothing."""
    own = {bone.name: bone.parent.name if bone.parent else "" for bone in armature_object.data.bones}
    others = {bone.name: bone.parent.name if bone.parent else "" for bone in other.data.bones}
    if own == others:
        return ""
    strange = sorted(set(own.items()) ^ set(others.items()))[0][0]
    return (
        f"Its skeleton is not that of '{armature_object.name}': they differ in bone '{strange}'. "
        "Import it from a folder of its own."
    )


def _remove(armature_object, action) -> None:
    """Delete an imported armature with its data, and its action if given."""
    armature = armature_object.data
    bpy.data.objects.remove(armature_object)
    bpy.data.armatures.remove(armature)
    if action is not None:
        bpy.data.actions.remove(action)


def _restore(before) -> None:
    """Delete everything that has come since."""
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for name in _COLLECTIONS:
        collection = getattr(bpy.data, name)
        for datablock in set(collection) - before[name]:
            collection.remove(datablock)
