"""BVH files as actions of one armature."""

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core.errors import ClipError
from ...core.motion import quat
from ...core.motion.bvh.character import BvhCharacter, understand_bvh_steps
from ...core.motion.bvh.clip import Fit, bvh_clip_steps, fit_character
from ...core.motion.bvh.file import BvhFile
from ...core.motion.bvh.reader import load_bvh_steps
from ...core.motion.clip import MotionClip
from ...core.motion.doctor.finding import bones_in_words
from ...core.motion.skeleton import Skeleton
from ...core.progress import Progress, finish, portion
from .create_armature import create_armature
from .import_state import restore, what_is_there
from .read_actions import FRAME_RATE_PROPERTY
from .rig import FORWARD_PROPERTY, read_matrices
from .rotation_modes import channels_from_quaternions, rotation_property
from .write_action import STILL, new_action, write_bone

_READING = 0.3  # of the whole work


@dataclass(frozen=True)
class BvhImport:
    """What came of an import.

    ``problems`` are (file name, reason) of the files that were left out, ``remarks`` sentences on how the others were
    understood.
    """

    armature: bpy.types.Object
    actions: list[bpy.types.Action]
    problems: list[tuple[str, str]]
    remarks: list[str]


def import_bvh_folder(folder, scale: float | None = None, up: str = "") -> tuple:
    """Import every BVH file of a folder, in the order of their names, onto one armature.

    Returns (armature object, actions, problems): actions are named after their files and keep every frame of
    theirs, from frame 1, one frame apart; their own rate is in the custom property ``wayfarer_frame_rate``,
    which :func:`read_clip` honours. Problems are (file name, reason) of those that were left out: damaged
    files, and those whose skeleton cannot be understood beside that of the first. Files of another rest pose, size or
    skeleton are carried over to that of the first.

    ``scale`` is the length of a file's unit in metres, ``up`` the axis that points up in the files, a key of
    ``TO_Z_UP``; by default both are found from the motion (:func:`understand_bvh_steps`). The scene's rate and frame
    range stay as they are.

    Raises ClipError if the folder has no BVH file, or none that can be used.
    """
    return import_bvh_files(bvh_files(folder), scale, up)


def bvh_files(folder) -> list[Path]:
    """The BVH files of a folder, in the order of their names; ClipError if it has none."""
    folder = Path(folder)
    paths = sorted(path for path in folder.glob("*") if path.suffix.lower() == ".bvh")
    if not paths:
        raise ClipError(f"The folder '{folder}' holds no BVH files; choose one with motion capture in it.")
    return paths


def import_bvh_files(paths, scale: float | None = None, up: str = "") -> tuple:
    """Like :func:`import_bvh_folder`, for these files."""
    made = finish(import_bvh_files_steps(paths, scale, up))
    return made.armature, made.actions, made.problems


def import_bvh_files_steps(paths, scale: float | None = None, up: str = "") -> Generator[Progress, None, BvhImport]:
    """As :func:`import_bvh_files`, as a generator that yields progress; nothing stays behind if it is closed early."""
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    before = what_is_there()
    complete = False
    try:
        files, problems = yield from portion(_read_steps(list(map(Path, paths))), 0.0, 0.8 * _READING)
        characters = yield from portion(understand_bvh_steps(files, scale, up), 0.8 * _READING, _READING)
        # By session id: no reference to Blender's data is held while other things happen.
        armature_uid, action_uids, fits = None, [], {}
        for done, (file, character) in enumerate(zip(files, characters, strict=True)):
            start = _READING + (1 - _READING) * done / len(files)
            yield Progress(start, f"Importing {file.name}")
            try:
                if id(character) not in fits:
                    fits[id(character)] = _fit(characters[0], character, Path(files[0].name).stem)
                work = bvh_clip_steps(file, character, fits[id(character)])
                clip = yield from portion(work, start, start)
            except ClipError as error:
                problems.append((file.name, str(error)))
                continue
            if armature_uid is None:
                armature_uid = _new_armature(clip.name, files[0], characters[0]).session_uid
            work = _write_steps(armature_uid, clip)
            action_uids.append((yield from portion(work, start, start + (1 - _READING) / len(files))))
        if armature_uid is None:
            reasons = " ".join(reason for _, reason in problems)
            raise ClipError(f"None of the BVH files can be used. {reasons}")
        armature_object = _known("objects", armature_uid)
        actions = [_known("actions", uid) for uid in action_uids]
        animation = armature_object.animation_data_create()
        animation.action = actions[0]
        animation.action_slot = actions[0].slots[0]
        complete = True
        return BvhImport(armature_object, actions, problems, _remarks(files, characters, fits))
    finally:
        if not complete:
            restore(before)


def _read_steps(paths: Sequence[Path]) -> Generator[Progress, None, tuple[list[BvhFile], list[tuple[str, str]]]]:
    files, problems = [], []
    for done, path in enumerate(paths):
        try:
            files.append((yield from portion(load_bvh_steps(path), done / len(paths), (done + 1) / len(paths))))
        except ClipError as error:
            problems.append((path.name, str(error)))
    return files, problems


def _fit(own: BvhCharacter, other: BvhCharacter, name: str) -> Fit:
    try:
        return fit_character(own, other)
    except ClipError as error:
        raise ClipError(f"Its skeleton is not that of '{name}', and {error} Import it by itself.") from None


def _remarks(files: Sequence[BvhFile], characters: Sequence[BvhCharacter], fits: dict[int, Fit]) -> list[str]:
    """Sentences on how the files were understood, and on those that are unlike the first."""
    remarks = [f"{characters[0].describe()}; if it is not, import again with another Up or Scale."]
    unlike: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for file, character in zip(files, characters, strict=True):
        fit = fits.get(id(character))
        if fit is not None and not fit.is_same:
            unlike.setdefault((fit.reason, fit.unmoved), []).append(file.name)
    remarks += carried_in_words(unlike, f"the skeleton of '{files[0].name}'")
    return remarks + [remark for file in files for remark in file.remarks]


def carried_in_words(unlike: Mapping[tuple[str, tuple[str, ...]], Sequence[str]], goal: str) -> list[str]:
    """Say which files were carried over to ``goal``: their names by what is unlike, and the bones they do not move."""
    sentences = []
    for (reason, unmoved), names in unlike.items():
        named = ", ".join(f"'{name}'" for name in names[:3])
        named += f" and {len(names) - 3} more" if len(names) > 3 else ""
        verb, they = ("has", "it") if len(names) == 1 else ("have", "them")
        rests = "stays at rest" if len(unmoved) == 1 else "stay at rest"
        rest = f"; {bones_in_words(unmoved)} {rests}, without a counterpart in {they}" if unmoved else ""
        sentences.append(f"{named} {verb} {reason}: carried over to {goal}{rest}.")
    return sentences


def _new_armature(name: str, file: BvhFile, character: BvhCharacter) -> bpy.types.Object:
    """The armature of a file at rest, its bones turning in the order of the file's channels."""
    armature_object: Any = create_armature(character.skeleton, character.tails, name, bpy.context.scene.collection)
    # Where it faces is found like that of any other rig.
    del armature_object[FORWARD_PROPERTY]
    for joint, joint_name in enumerate(file.names):
        order = file.order(joint)
        mode = order if len(set(order)) == 3 else "XYZ"
        armature_object.pose.bones[joint_name].rotation_mode = mode
    return armature_object


def _write_steps(armature_uid: int, clip: MotionClip) -> Generator[Progress, None, int]:
    """Write a clip as an action with every frame of it, from frame 1; return the action's session id."""
    skeleton = clip.skeleton
    before, after = _basis_turns(_known("objects", armature_uid), skeleton)
    action_uid = 0
    for joint, name in enumerate(skeleton.names):
        armature_object = _known("objects", armature_uid)
        mode = armature_object.pose.bones[name].rotation_mode
        turns = quat.multiply(before[joint], clip.rotations[:, joint], after[joint])
        channels = {rotation_property(mode): channels_from_quaternions(mode, turns)}
        away = clip.translations[:, joint] - skeleton.rest_translations[joint]
        if joint == 0 or np.abs(away).max() > STILL:
            channels["location"] = quat.rotate(before[joint], away)
        if action_uid == 0:
            action = new_action(armature_object, clip.name)
            action.use_fake_user = True
            action[FRAME_RATE_PROPERTY] = clip.frame_rate
            action_uid = action.session_uid
        action = _known("actions", action_uid)
        write_bone(action, name, channels)
        yield Progress((joint + 1) / skeleton.n_joints, f"Importing {clip.name}")
    return action_uid


def _basis_turns(armature_object, skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    """(J, 4) before and after: the turn of a bone's channels is before * local rotation of its joint * after.

    With rest rotations in the world R of joints and B of their bones, and p for a joint's parent, these are
    B^-1 R_p and R^-1 B; before also brings a joint's translation to the bone's axes.
    """
    bones = armature_object.data.bones
    place = {bone.name: index for index, bone in enumerate(bones)}
    rests = quat.from_matrix(read_matrices(bones, "matrix_local")[:, :3, :3])
    of_bones = rests[[place[name] for name in skeleton.names]]
    of_joints = skeleton.rest_world[0]
    above = np.where((skeleton.parents >= 0)[:, None], of_joints[skeleton.parents], quat.IDENTITY)
    return quat.multiply(quat.inverse(of_bones), above), quat.multiply(quat.inverse(of_joints), of_bones)


def _known(collection: str, uid: int):
    return next(block for block in getattr(bpy.data, collection) if block.session_uid == uid)
