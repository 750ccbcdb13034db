"""The bones that carry a character through the world in its own actions, and those that stay behind."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import bpy
import numpy as np

from ...core.errors import ClipError
from ...core.motion import quat
from .action_curves import ActionCurves, action_curves, sample_curve
from .evaluated_pose import evaluated_matrices
from .read_actions import local_pose, needs_evaluation, to_armature_space
from .rig import RigBinding, placement_obstacle
from .rotation_modes import REST_CHANNELS, rotation_property

_N_SAMPLES = 5
"""Frames of each action that are looked at: enough to tell what moves from what does not."""
_STILL = 1e-3
"""Share of the rig's size, and radians, within which a bone or the object counts as standing still."""

Pose = tuple[np.ndarray, np.ndarray]
"""Rotation as a quaternion (w, x, y, z) and position (3,) in armature space, or arrays of them."""


@dataclass(frozen=True)
class Carriers:
    """Movement, by a character's own actions, of the bones outside its body, and the armature object.

    Attributes
    ----------
    still : mapping of int to Pose
        Bones outside the body (joints of the binding) that no action moves, with the pose that they keep: a root
        bone left at the origin while the hips travel.
    level : mapping of int to Pose
        Bones outside the body that move, but turn about the vertical only and keep their height, with one of
        their poses: a root bone that travels on the ground.
    object_keys : set of str
        Which of "location" and "rotation" of the armature object the actions key.
    object_moves : set of str
        Those of them that change within an action.
    """

    still: Mapping[int, Pose] = field(default_factory=dict)
    level: Mapping[int, Pose] = field(default_factory=dict)
    object_keys: Collection[str] = frozenset()
    object_moves: Collection[str] = frozenset()


def find_carriers(armature_object, binding: RigBinding) -> Carriers:
    """Find out from the file's actions of the armature how it travels.

    Actions that are none of its motions say nothing.
    """
    has_bones_outside = len(binding.outside_body) > 0
    samples, keys, moves = [], set(), set()
    for action in bpy.data.actions:
        if not (has_bones_outside or _keys_an_object(action)):
            continue
        try:
            curves = action_curves(armature_object, action)
            frames = curves.frames()
            if has_bones_outside:
                samples.append(_poses(armature_object, curves, frames, binding))
        except ClipError:
            continue
        for channel, changes in _object_channels(armature_object, curves, frames):
            keys.add(channel)
            moves |= {channel} if changes else set()
    if placement_obstacle(armature_object):
        keys, moves = set(), set()  # keys would not put the object where they say
    still, level = _still_and_level(binding, samples)
    return Carriers(still, level, frozenset(keys), frozenset(moves))


def levelled(rotations: np.ndarray, positions: np.ndarray, pose: Pose, up: np.ndarray) -> Pose:
    """The nearest poses that differ from ``pose`` by a turn about ``up`` and a move at right angles to it only.

    (..., 4) rotations and (..., 3) positions; those of ``pose`` are broadcast.
    """
    angles = quat.twist(quat.multiply(rotations, quat.inverse(pose[0])), up)
    turned = quat.multiply(quat.from_rotvec(angles[..., None] * up), pose[0])
    return turned, positions + ((pose[1] - positions) @ up)[..., None] * up


def _poses(armature_object, curves: ActionCurves, frames: np.ndarray, binding: RigBinding) -> Pose:
    """(n, K, 4) rotations and (n, K, 3) positions in armature space of the bones outside the body, on some frames."""
    outside = binding.outside_body
    some = frames[np.unique(np.linspace(0, len(frames) - 1, _N_SAMPLES).round().astype(int))]
    if not needs_evaluation(curves, frames, binding):
        rotations, translations = local_pose(curves, some, binding, outside)
        to_armature_space(rotations, translations, binding, outside)
        return rotations[:, outside], translations[:, outside]
    names = [binding.skeleton.names[joint] for joint in outside]
    poses, _ = evaluated_matrices(armature_object, curves.action, curves.slot, some, names)
    axes = poses[..., :3, :3] / np.maximum(np.linalg.norm(poses[..., :3, :3], axis=2, keepdims=True), 1e-12)
    # Bones that are mirrored or scaled to nothing have no rotation; it does not matter which they get.
    axes = np.where((np.linalg.det(axes) > 1e-6)[..., None, None], axes, np.eye(3))
    return quat.from_matrix(axes), poses[..., :3, 3]


def _still_and_level(binding: RigBinding, samples: list[Pose]) -> tuple[dict[int, Pose], dict[int, Pose]]:
    if not samples:
        return {}, {}
    up = binding.up
    size = max(float(np.ptp(binding.rest_matrices[:, :3, 3], axis=0).max()), 1e-6)
    first = samples[0][0][0], samples[0][1][0]

    def same(pose: Pose, other: Pose) -> np.ndarray:
        """(K,) bool"""
        signs = np.where(np.sum(pose[0] * other[0], axis=-1, keepdims=True) < 0, -1, 1)
        turned = np.abs(pose[0] * signs - other[0]).max(axis=(0, 2))
        return (turned < _STILL) & (np.abs(pose[1] - other[1]).max(axis=(0, 2)) < _STILL * size)

    still = np.all([same(pose, (pose[0][0], pose[1][0])) for pose in samples], axis=0)
    level = np.all([same(pose, levelled(*pose, first, up)) for pose in samples], axis=0) & ~still

    def poses(chosen: np.ndarray) -> dict[int, Pose]:
        return {int(binding.outside_body[k]): (first[0][k], first[1][k]) for k in np.flatnonzero(chosen)}

    return poses(still), poses(level)


def _keys_an_object(action) -> bool:
    """Return True if any slot of the action keys an object's own transform; quick, because all actions are asked."""
    return any(
        curve.data_path in REST_CHANNELS
        for layer in action.layers
        for strip in layer.strips
        for channelbag in strip.channelbags
        for curve in channelbag.fcurves
    )


def _object_channels(armature_object, curves: ActionCurves, frames: np.ndarray):
    """("location" or "rotation", whether it changes) for each curve of the object that has an effect."""
    names = {"location": "location", rotation_property(armature_object.rotation_mode): "rotation"}
    for (name, _), curve in curves.placement.items():
        if name in names:
            yield names[name], bool(np.ptp(sample_curve(curve, frames)) > _STILL)
