"""Motion clips from a character's actions."""

from collections.abc import Iterable

import bpy
import numpy as np

from ...core import wording
from ...core.errors import ClipError
from ...core.motion import quat
from ...core.motion.clip import MotionClip
from .action_curves import ActionCurves, action_curves
from .evaluated_pose import evaluated_matrices, local_transforms
from .rig import RigBinding, bind_rig, matrix_placement
from .rotation_modes import quaternions_from_channels, rotation_property
from .tags import read_tags

FRAME_RATE_PROPERTY = "wayfarer_frame_rate"
"""Custom property of an action: its own frames per second, where they are not the scene's."""

MOST_FRAMES = 120_000
"""Frames of one clip, an hour at 33 frames per second: where there are more, a key was set far away by mistake."""


def read_clip(
    armature_object, action, frame_rate: float | None = None, binding: RigBinding | None = None
) -> MotionClip:
    """The motion of ``armature_object`` when it plays ``action``, one sample for each of the action's frames.

    In the world's frame and in metres (one Blender unit is one metre), the armature object's own
    placement and animation included; see :class:`MotionClip` for the arrays. The result is what
    Blender shows when only this action plays on a rig in its rest pose: computed from the f-curves, or
    by evaluating the scene frame by frame where constraints, drivers or scaled bones have a say.

    Frames are those of the action's manual frame range, if it has one, else from its first to its last key.
    ``frame_rate`` says how many of them make a second; by default the action's custom property
    ``wayfarer_frame_rate``, else the scene's rate. Tags are those of :mod:`.tags`.
    ``binding`` saves time when many actions of one armature are read.

    Raises ClipError if the action moves none of the armature's bones, has fewer than two frames or more than
    ``MOST_FRAMES``, or holds a value that is not a number, and for the reasons of :func:`bind_rig`.
    """
    binding = binding or bind_rig(armature_object)
    curves = action_curves(armature_object, action)
    frames = curves.frames()
    if len(frames) > MOST_FRAMES:
        raise ClipError(
            f"Action '{action.name}' goes from frame {frames[0]:,.0f} to {frames[-1]:,.0f}; a clip may have "
            f"{wording.number(MOST_FRAMES)} frames. Delete keys that stand far from its motion, or give it a manual "
            "frame range."
        )
    if needs_evaluation(curves, frames, binding):
        rotations, translations = local_transforms(
            binding, *evaluated_matrices(armature_object, action, curves.slot, frames, binding.skeleton.names)
        )
    else:
        rotations, translations = _transforms_from_curves(armature_object, curves, frames, binding)
    return MotionClip(
        name=action.name,
        skeleton=binding.skeleton,
        frame_rate=frame_rate or source_frame_rate(action),
        rotations=rotations,
        translations=translations,
        tags=read_tags(action, frames),
        first_frame=float(frames[0]),
    )


def read_clips(
    armature_object, actions: Iterable, frame_rate: float | None = None, binding: RigBinding | None = None
) -> tuple[list[MotionClip], list[tuple[str, str]]]:
    """The clips of all actions that can be read, and (action name, reason) of those that cannot.

    Raises ClipError if there are no actions, or if the armature itself cannot be used.
    """
    actions = list(actions)
    if not actions:
        raise ClipError(f"'{armature_object.name}' was given no actions; choose at least one for its motion graph.")
    binding = binding or bind_rig(armature_object)
    clips, problems = [], []
    for action in actions:
        try:
            clips.append(read_clip(armature_object, action, frame_rate, binding))
        except ClipError as error:
            problems.append((action.name, str(error)))
    return clips, problems


def source_frame_rate(action) -> float:
    """Frames per second of an action: its own ``wayfarer_frame_rate``, else the scene's.

    Raises ClipError if that property is not a positive number.
    """
    render = bpy.context.scene.render
    rate = action.get(FRAME_RATE_PROPERTY, render.fps / render.fps_base)
    if not isinstance(rate, int | float) or not 0 < rate < np.inf:
        raise ClipError(
            f"The custom property '{FRAME_RATE_PROPERTY}' of action '{action.name}' is {rate!r}; it must be a "
            "number of frames per second. Correct or remove it."
        )
    return float(rate)


def needs_evaluation(curves: ActionCurves, frames: np.ndarray, binding: RigBinding) -> bool:
    """Test if more than rotations and locations of f-curves has a say in the pose: constraints, scaled bones ..."""
    scaled = {bone for bone, name, _ in curves.bones if name == "scale"}
    return bool(binding.evaluation_reason) or any(
        np.abs(np.asarray(curves.bone_channels(bone, "scale", frames)) - 1).max() > 1e-5 for bone in scaled
    )


def local_pose(curves: ActionCurves, frames: np.ndarray, binding: RigBinding, joints: Iterable[int]):
    """(F, J, 4) rotations and (F, J, 3) translations of bones relative to their parents in the armature, from f-curves.

    Only ``joints`` are posed; all others are at rest.
    """
    rotations = np.tile(binding.relative_rest_rotations, (len(frames), 1, 1))
    translations = np.tile(binding.relative_rests[:, :3, 3], (len(frames), 1, 1))
    turning: dict[str, list[tuple[int, np.ndarray]]] = {}
    for joint in joints:
        bone, mode = binding.skeleton.names[joint], binding.rotation_modes[joint]
        values = curves.bone_channels(bone, rotation_property(mode), frames)
        if values is not None:
            turning.setdefault(mode, []).append((joint, values))
        location = None if binding.connected[joint] else curves.bone_channels(bone, "location", frames)
        if location is not None:
            translations[:, joint] += location @ binding.relative_rests[joint, :3, :3].T
    for mode, channels in turning.items():
        posed = [joint for joint, _ in channels]
        turns = quaternions_from_channels(mode, np.stack([values for _, values in channels], axis=1))
        rotations[:, posed] = quat.multiply(rotations[:, posed], turns)
    return rotations, translations


def to_armature_space(rotations: np.ndarray, translations: np.ndarray, binding: RigBinding, joints: Iterable[int]):
    """Change the given joints of a :func:`local_pose` to armature space, in place.

    ``joints`` hold every one's ancestors in the armature, before it.
    """
    for joint in joints:
        parent = binding.bone_parents[joint]
        if parent >= 0:
            turn = rotations[:, parent]
            translations[:, joint] = translations[:, parent] + quat.rotate(turn, translations[:, joint])
            rotations[:, joint] = quat.multiply(turn, rotations[:, joint])


def _transforms_from_curves(armature_object, curves: ActionCurves, frames, binding: RigBinding):
    """Local rotations (F, J, 4) and translations (F, J, 3) of the skeleton's joints, from f-curves alone."""
    rotations, translations = local_pose(curves, frames, binding, range(binding.skeleton.n_joints))
    # Everything that does not keep its parent in the skeleton is needed in armature space, its ancestors too;
    # those all lie outside what hangs below the root, or are the root.
    loose = [joint for joint in binding.bone_order if not binding.keeps_parent[joint]]
    to_armature_space(rotations, translations, binding, loose)
    place_rotation, place_translation, place_scale = _placements(armature_object, curves, frames, binding)
    from_root = quat.inverse(rotations[:, 0])
    for joint in loose:
        if joint != 0:
            translations[:, joint] = quat.rotate(from_root, translations[:, joint] - translations[:, 0])
            rotations[:, joint] = quat.multiply(from_root, rotations[:, joint])
    translations *= place_scale[:, None, None]
    translations[:, 0] = place_translation + quat.rotate(place_rotation, translations[:, 0])
    rotations[:, 0] = quat.multiply(place_rotation, rotations[:, 0])
    return rotations, translations


def _placements(armature_object, curves: ActionCurves, frames, binding: RigBinding):
    """Return the place of the armature object on each frame: F rotations, (F, 3) translations, (F,) scales."""
    n_frames = len(frames)
    if not curves.placement:
        placement = binding.placement
        places = (np.tile(values, (n_frames, 1)) for values in (placement.rotation, placement.translation))
        return *places, np.full(n_frames, placement.scale)
    mode = armature_object.rotation_mode
    name = rotation_property(mode)
    turns = quaternions_from_channels(mode, curves.placement_channels(name, frames, getattr(armature_object, name)))
    scales = curves.placement_channels("scale", frames, armature_object.scale)
    basis = np.tile(np.eye(4), (n_frames, 1, 1))
    basis[:, :3, :3] = quat.to_matrix(turns) * scales[:, None, :]
    basis[:, :3, 3] = curves.placement_channels("location", frames, armature_object.location)
    # What the parent and its inverse contribute does not change: see RigBinding.evaluation_reason.
    parent = np.eye(4)
    if armature_object.parent is not None:
        parent = np.array(armature_object.parent.matrix_world @ armature_object.matrix_parent_inverse)
    placements = [matrix_placement(matrix, armature_object.name) for matrix in parent @ basis]
    return (
        np.array([placement.rotation for placement in placements]),
        np.array([placement.translation for placement in placements]),
        np.array([placement.scale for placement in placements]),
    )
