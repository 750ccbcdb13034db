"""A folder of BVH files as actions of one armature, by Blender's own importer."""

import contextlib
import io
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import addon_utils
import bpy

from ...core.errors import ClipError
from ...core.progress import Progress, finish
from .bvh_file import check_bvh, guess_bvh_scale, without_mark
from .read_actions import FRAME_RATE_PROPERTY, read_clip

_IMPORTER = "io_anim_bvh"
_COLLECTIONS = ("objects", "armatures", "meshes", "materials", "collections", "actions")


@dataclass(frozen=True)
class Before:
    """What the file held before an import, by session ids: no reference to Blender's data is kept meanwhile.

    ``blocks`` are those of each collection of data that an import adds to, ``active`` is the active object (0 for
    none), ``selected`` are the selected objects.
    """

    blocks: dict[str, frozenset[int]]
    active: int
    selected: frozenset[int]


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
    return import_bvh_files(bvh_files(folder), scale)


def bvh_files(folder) -> list[Path]:
    """The BVH files of a folder, in the order of their names; ClipError if it has none."""
    folder = Path(folder)
    paths = sorted(path for path in folder.glob("*") if path.suffix.lower() == ".bvh")
    if not paths:
        raise ClipError(f"The folder '{folder}' holds no BVH files; choose one with motion capture in it.")
    return paths


def import_bvh_files(paths, scale: float | None = None) -> tuple:
    """Like :func:`import_bvh_folder`, for these files."""
    return finish(import_bvh_files_steps(paths, scale))


def import_bvh_files_steps(paths, scale: float | None = None) -> Generator[Progress, None, tuple]:
    """As :func:`import_bvh_files`, as a generator that yields progress; nothing stays behind if it is closed early."""
    if not addon_utils.check(_IMPORTER)[1]:
        addon_utils.enable(_IMPORTER)
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    before = what_is_there()
    complete = False
    try:
        # By session id: no reference to Blender's data is held while other things happen.
        armature_uid, action_uids, problems = None, [], []
        for done, path in enumerate(map(Path, paths)):
            yield Progress(done / len(paths), f"Importing {path.name}")
            try:
                scale = scale or guess_bvh_scale(path)
                imported, action = _import_file(path, scale)
            except ClipError as error:
                problems.append((path.name, str(error)))
                continue
            if armature_uid is None:
                armature_object, armature_uid = imported, imported.session_uid
            else:
                armature_object = _known("objects", armature_uid)
                difference = _bone_difference(armature_object, imported)
                _remove(imported, None if not difference else action)
                if difference:
                    problems.append((path.name, difference))
                    continue
            # One name, so that Blender finds the slot when the actions are switched; 4.5 names it after the file.
            action.slots[0].name_display = armature_object.name
            action_uids.append(action.session_uid)
        if armature_uid is None:
            reasons = " ".join(reason for _, reason in problems)
            raise ClipError(f"None of the BVH files can be used. {reasons}")
        armature_object = _known("objects", armature_uid)
        actions = [_known("actions", uid) for uid in action_uids]
        armature_object.animation_data.action = None
        animation = armature_object.animation_data
        animation.action = actions[0]
        animation.action_slot = actions[0].slots[0]
        complete = True
        return armature_object, actions, problems
    finally:
        if not complete:
            restore(before)


def what_is_there() -> Before:
    """What :func:`restore` goes back to."""
    objects = bpy.context.view_layer.objects
    return Before(
        blocks={name: frozenset(block.session_uid for block in getattr(bpy.data, name)) for name in _COLLECTIONS},
        active=objects.active.session_uid if objects.active else 0,
        selected=frozenset(obj.session_uid for obj in objects.selected),
    )


def restore(before: Before) -> None:
    """Delete everything that has come since, and select what was selected."""
    _delete_later_than(before)
    objects = bpy.context.view_layer.objects
    for obj in objects:
        obj.select_set(obj.session_uid in before.selected)
    objects.active = next((obj for obj in objects if obj.session_uid == before.active), None)


def _known(collection: str, uid: int):
    return next(block for block in getattr(bpy.data, collection) if block.session_uid == uid)


def _import_file(path: Path, scale: float):
    """The armature object and the action of one file; ClipError, and nothing left behind, if it is damaged."""
    frame_rate = check_bvh(path)
    before = what_is_there()
    try:
        # The importer tells its progress on stdout, Blender the importer's errors on stderr.
        silence = contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO())
        with without_mark(path) as readable, silence[0], silence[1]:
            bpy.ops.import_anim.bvh(
                filepath=str(readable),
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
        if imported is None or imported.session_uid in before.blocks["objects"]:
            raise ClipError(f"'{path.name}' holds no skeleton; it is not a BVH file or is damaged.")
        action = imported.animation_data.action
        imported.name = imported.data.name = action.name = path.stem
        action[FRAME_RATE_PROPERTY] = frame_rate
        read_clip(imported, action)  # so that what cannot be read is found now
    except ClipError:
        _delete_later_than(before)
        raise
    except RuntimeError as error:  # whatever the importer stumbled over
        _delete_later_than(before)
        raise ClipError(f"'{path.name}' is damaged, Blender's importer reports: {_reason(error)}.") from None
    action.use_fake_user = True
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


def _delete_later_than(before: Before) -> None:
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for name in _COLLECTIONS:
        collection = getattr(bpy.data, name)
        for datablock in [datablock for datablock in collection if datablock.session_uid not in before.blocks[name]]:
            collection.remove(datablock)
