"""Motion of BVH, FBX and glTF files on one character."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from ...core.errors import ClipError
from ...core.motion.bvh.character import understand_bvh_steps
from ...core.motion.bvh.clip import bvh_clip_steps
from ...core.motion.bvh.reader import load_bvh_steps
from ...core.motion.clip import MotionClip
from ...core.motion.retarget import Fit, fit_skeleton, retarget_steps
from ...core.progress import Progress, portion
from .blenders_importers import Brought, bring_file, holds_skin, is_skinned, with_family
from .import_bvh import carried_in_words, import_bvh_files_steps
from .import_state import remove_newcomers, restore, restore_scene, what_is_there
from .read_actions import FRAME_RATE_PROPERTY, read_clip
from .rest_poses import have_same_rest
from .rig import bind_rig
from .write_action import write_clip

SUFFIXES = (".bvh", ".fbx", ".glb", ".gltf")


@dataclass
class MotionImport:
    """Outcome of an import, by session ids.

    ``problems`` are (file name, reason) of what was left out, ``remarks`` sentences on how the rest was understood;
    ``is_new`` says that the armature came with the files, and ``has_body`` that a mesh came with it. ``carried`` holds
    the names of files that were carried over, by what is unlike in them and the bones that nothing in them moves.
    """

    armature: int = 0
    actions: list[int] = field(default_factory=list)
    problems: list[tuple[str, str]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    is_new: bool = True
    has_body: bool = False
    carried: dict[tuple[str, tuple[str, ...]], list[str]] = field(default_factory=dict)


def motion_files(folder) -> list[Path]:
    """The files of a folder that can hold motion, in the order of their names; ClipError if it has none."""
    folder = Path(folder)
    paths = sorted(path for path in folder.glob("*") if path.suffix.lower() in SUFFIXES)
    if not paths:
        kinds = ", ".join(SUFFIXES)
        raise ClipError(f"The folder '{folder}' holds no files of motion ({kinds}); choose one that does.")
    return paths


def import_motion_steps(
    paths: Sequence[Path], onto=None, scale: float | None = None, up: str = ""
) -> Generator[Progress, None, MotionImport]:
    """Import files as actions of one character: the armature object ``onto``, or that of the first file.

    Of FBX and glTF files, actions on the bones of a character with the same rest pose are kept as the importer made
    them; all other motion is carried over (:func:`core.motion.retarget.fit_skeleton`) and baked. Each action has the
    rate of its file in the custom property ``wayfarer_frame_rate``. Whatever else a file brings is deleted again, but
    for the mesh of the character that is kept. ``scale`` and ``up`` are those of BVH files.

    Nothing stays behind if the generator is closed early. Raises ClipError if nothing in the files can be used.
    """
    paths = list(map(Path, paths))
    # Of the files, the character is the first that has a body.
    scenes = sorted((path for path in paths if path.suffix.lower() != ".bvh"), key=lambda path: not holds_skin(path))
    recordings = [path for path in paths if path.suffix.lower() == ".bvh"]
    made = MotionImport(onto.session_uid if onto else 0, is_new=onto is None)
    if onto is not None:
        bind_rig(onto)
    before, complete = what_is_there(), False
    share = len(scenes) / len(paths)
    try:
        if before.active and bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        yield from portion(_scene_steps(scenes, made), 0.0, share)
        if recordings and not made.armature:
            try:
                yield from portion(_recordings_alone_steps(recordings, made, scale, up), share, 1.0)
            except ClipError as error:
                made.problems.append((recordings[0].name if len(recordings) == 1 else "BVH", str(error)))
        elif recordings:
            yield from portion(_recording_steps(recordings, made, scale, up), share, 1.0)
        if not made.actions and (onto is not None or not made.armature):
            reasons = " ".join(reason for _, reason in made.problems)
            raise ClipError(reasons if len(paths) == 1 else f"None of the files can be used. {reasons}")
        restore_scene(before)
        made.remarks += carried_in_words(made.carried, f"'{known('objects', made.armature).name}'")
        complete = True
        return made
    finally:
        if not complete:
            restore(before)


def known(collection: str, uid: int):
    """Return the datablock of a session id."""
    return next(block for block in getattr(bpy.data, collection) if block.session_uid == uid)


def _scene_steps(paths: Sequence[Path], made: MotionImport) -> Generator[Progress, None, None]:
    for done, path in enumerate(paths):
        yield Progress(done / len(paths), f"Importing {path.name}")
        before, kept = what_is_there(), set()
        try:
            brought = bring_file(path, before)
            if not made.armature:
                made.armature, made.has_body = brought.armature.session_uid, is_skinned(brought.armature)
                kept = {obj.session_uid for obj in with_family(brought.armature)}
            work = _take_steps(brought, path, made)
            kept |= set((yield from portion(work, done / len(paths), (done + 1) / len(paths))))
        except ClipError as error:
            made.problems.append((path.name, str(error)))
        finally:
            remove_newcomers(before, kept)
            restore_scene(before)


def _take_steps(brought: Brought, path: Path, made: MotionImport) -> Generator[Progress, None, list[int]]:
    """Take the motion of a file that Blender's importer has read; return the session ids of the actions to keep."""
    character, armature = known("objects", made.armature), brought.armature
    is_kept = character == armature
    if not brought.actions and not is_kept:
        raise ClipError(f"'{path.name}' holds no motion of its bones; choose files with animation.")
    is_same = is_kept or have_same_rest(character, armature)
    fit, uids, problems = None, [], []
    for number, action in enumerate(brought.actions):
        name = path.stem if len(brought.actions) == 1 else brought.names[number]
        try:
            clip = read_clip(armature, action)
        except ClipError as error:
            problems.append((path.name, str(error)))
            continue
        if is_same:
            action.name = name
            brought.give_to(character, action)
        else:
            fit = fit or _fit(character, clip, path.name)
            part = number / len(brought.actions), (number + 1) / len(brought.actions)
            carried = yield from portion(retarget_steps(clip, fit), *part)
            # Its name is free then.
            bpy.data.actions.remove(action)
            action = _write(character, carried, name)
            _remember(made, fit, path.name)
        action.use_fake_user = True
        uids.append(action.session_uid)
    if is_kept and not uids:
        made.remarks.append(f"'{path.name}' brought the character '{character.name}', and no motion.")
    else:
        made.problems += problems
    made.actions += uids
    return uids


def _fit(character, clip: MotionClip, name: str) -> Fit:
    """Find how the motion of a file moves the character."""
    try:
        fit = fit_skeleton(bind_rig(character).skeleton, clip.skeleton, clip)
    except ClipError as error:
        raise ClipError(
            f"'{name}' has another skeleton than '{character.name}', and {error} Import it without a character."
        ) from None
    held = [bone for bone in fit.skeleton.names if any(not c.mute for c in character.pose.bones[bone].constraints)]
    if held:
        raise ClipError(
            f"'{name}' has another skeleton than '{character.name}', whose bone '{held[0]}' is moved by constraints; "
            "import it onto a skeleton without any."
        )
    return fit


def _remember(made: MotionImport, fit: Fit, name: str) -> None:
    names = made.carried.setdefault((fit.reason, fit.unmoved), [])
    if name not in names:
        names.append(name)


def _write(character, clip: MotionClip, name: str) -> bpy.types.Action:
    action = write_clip(character, clip, name, round(clip.first_frame), at_own_rate=True)
    action.use_fake_user = True
    action[FRAME_RATE_PROPERTY] = clip.frame_rate
    return action


def _recordings_alone_steps(paths, made: MotionImport, scale, up) -> Generator[Progress, None, None]:
    result = yield from import_bvh_files_steps(paths, scale, up)
    made.armature = result.armature.session_uid
    made.actions += [action.session_uid for action in result.actions]
    made.problems += result.problems
    made.remarks += result.remarks


def _recording_steps(paths, made: MotionImport, scale, up) -> Generator[Progress, None, None]:
    """Put BVH files onto the character that is there."""
    files = []
    for done, path in enumerate(paths):
        start, end = 0.3 * done / len(paths), 0.3 * (done + 1) / len(paths)
        try:
            files.append((yield from portion(load_bvh_steps(path), start, end)))
        except ClipError as error:
            made.problems.append((path.name, str(error)))
    characters = (yield from portion(understand_bvh_steps(files, scale, up), 0.3, 0.4)) if files else []
    fits: dict[int, Fit] = {}
    for done, (file, character) in enumerate(zip(files, characters, strict=True)):
        start, end = (0.4 + 0.6 * place / len(files) for place in (done, done + 1))
        yield Progress(start, f"Importing {file.name}")
        try:
            middle = 0.5 * (start + end)
            clip = yield from portion(bvh_clip_steps(file, character), start, middle)
            if id(character) not in fits:
                fits[id(character)] = _fit(known("objects", made.armature), clip, file.name)
            clip = yield from portion(retarget_steps(clip, fits[id(character)]), middle, end)
            made.actions.append(_write(known("objects", made.armature), clip, clip.name).session_uid)
            _remember(made, fits[id(character)], file.name)
        except ClipError as error:
            made.problems.append((file.name, str(error)))
        made.remarks += file.remarks
