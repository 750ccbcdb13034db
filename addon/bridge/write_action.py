"""Baking a motion clip into a new action."""

from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.errors import ClipError
from ...core.motion import quat
from ...core.motion.clip import MotionClip
from ...core.motion.skeleton import Skeleton
from .action_curves import action_curves, actions_of
from .carriers import Carriers, find_carriers, levelled
from .owned import WALK_PROPERTY
from .rig import RigBinding, bind_rig, matrix_placement
from .rotation_modes import REST_CHANNELS, channels_from_quaternions, rotation_property
from .tags import write_tags

_STASH = "[Action Stash]"
"""Blender's own name for tracks that keep an action that would otherwise be lost."""

_LINEAR = 1  # value of Keyframe.interpolation in foreach_set
STILL = 1e-5  # metres: a joint that keeps to its rest position this closely needs no location keys


def write_clip(
    armature_object,
    clip: MotionClip,
    name: str,
    first_frame: int = 1,
    binding: RigBinding | None = None,
    only_bones: Collection[str] | None = None,
    at_own_rate: bool = False,
) -> bpy.types.Action:
    """Bake ``clip`` into a new action that moves the bones of ``armature_object`` like the clip's joints.

    The clip is in world space and metres; it is resampled to the scene's frame rate, unless ``at_own_rate``, and gets
    one linear key a frame from ``first_frame`` on, in each bone's own rotation mode, without jumps. Bones and
    joints are matched by name, through their rest poses, so that clips of the same character can be written
    on a rig whose bones have other axes. Bones that the clip does not know stay in their rest pose; joints
    that the armature lacks are skipped. Location is keyed for the root and for joints that leave their rest
    position; bones connected to their parent stay there.

    What carries the travel in the actions that the armature has, carries it in the new one: a root bone on the
    ground goes along there, one that stays at the origin is left there, and an armature object that is moved by
    its actions goes and turns with the clip's ground path. If those actions hold the object where it is, so does
    the new one; else the object is not keyed, and its present placement is taken into account.

    ``only_bones`` limits the keys to the bones so named; the others are then taken to follow by themselves.
    By default all matching bones are keyed, except on a rig that also moves by constraints or drivers: there
    the keys belong on the controls, which are taken to be the bones that any action of the file animates.

    The action gets the clip's tags. It is not assigned (see :func:`assign_action`); nothing else is changed.

    Raises ClipError if the armature has no bone named like the clip's root, or one that cannot travel because
    it is connected to its parent, and for the reasons of :func:`bind_rig`.
    """
    binding = binding or bind_rig(armature_object)
    clip = clip if at_own_rate else at_scene_rate(clip)
    carriers = find_carriers(armature_object, binding)
    placements = carried_placements(binding, clip, carriers)
    of_object = object_channels(armature_object, placements, carriers.object_keys, clip.n_frames)
    channels = bone_channels(binding, clip, keyed_bones(armature_object, binding, only_bones), carriers, placements)
    action = write_channels(armature_object, name, channels, of_object, first_frame)
    write_tags(action, clip.tags, first_frame)
    return action


def at_scene_rate(clip: MotionClip) -> MotionClip:
    """The clip with one sample for each frame of the scene."""
    render = bpy.context.scene.render
    return clip.resampled(render.fps / render.fps_base)


def keyed_bones(armature_object, binding: RigBinding, only_bones: Collection[str] | None = None):
    """Names of the bones that may be keyed, None for all: see :func:`write_clip`."""
    if only_bones is None and binding.evaluation_reason:
        return animated_bones(armature_object, actions_of(armature_object)) or None
    return only_bones


def write_channels(armature_object, name: str, channels, of_object, first_frame: int = 1) -> bpy.types.Action:
    """A new action of linear keys, one a frame from ``first_frame`` on.

    ``channels`` maps (bone name, property), ``of_object`` a property of the object itself, to (F, C) values.
    """
    action = new_action(armature_object, name)
    bones: dict[str, dict[str, np.ndarray]] = {}
    for (bone, name_of_property), values in channels.items():
        bones.setdefault(bone, {})[name_of_property] = values
    for bone, of_bone in bones.items():
        write_bone(action, bone, of_bone, first_frame)
    _write_curves(_channelbag(action), "", of_object, first_frame)
    return action


def new_action(armature_object, name: str) -> bpy.types.Action:
    """An empty action, with one slot for ``armature_object``."""
    action = bpy.data.actions.new(name)
    slot = action.slots.new(id_type="OBJECT", name=armature_object.name)
    action.layers.new("Layer").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)
    return action


def write_bone(action, bone: str, channels: Mapping[str, np.ndarray], first_frame: int = 1) -> None:
    """Give a :func:`new_action` linear keys of one bone: property -> (F, C) values, one key a frame."""
    channelbag = _channelbag(action)
    group = channelbag.groups.new(bone)
    path = f'pose.bones["{bpy.utils.escape_identifier(bone)}"].'
    for curve in _write_curves(channelbag, path, channels, first_frame):
        curve.group = group


def _channelbag(action):
    return action.layers[0].strips[0].channelbag(action.slots[0])


def _write_curves(channelbag, owner: str, channels: Mapping[str, np.ndarray], first_frame: int) -> list:
    curves = []
    for name_of_property, values in channels.items():
        for component, curve_values in enumerate(values.T):
            curve = channelbag.fcurves.new(owner + name_of_property, index=component)
            write_linear_keys(curve, first_frame + np.arange(len(values)), curve_values)
            curves.append(curve)
    return curves


def animated_bones(armature_object, actions: Iterable) -> set[str]:
    """Names of the bones that any of the actions animates; ClipError if one of them animates none."""
    return {name for action in actions for name, *_ in action_curves(armature_object, action).bones}


def walk_channels(armature_object) -> set[tuple[str, str]]:
    """Find the (bone, property) of the armature that the file's walks key, whoever they were made for."""
    found: set[tuple[str, str]] = set()
    for action in bpy.data.actions:
        if WALK_PROPERTY in action:
            with suppress(ClipError):  # the walk of another character
                found |= keyed_channels(armature_object, [action])
    return found


def keyed_channels(armature_object, actions: Iterable) -> set[tuple[str, str]]:
    """Find the (bone, property) that any of the actions keys; ClipError if one of them animates no bone."""
    return {(bone, name) for action in actions for bone, name, _ in action_curves(armature_object, action).bones}


def put_to_rest(armature_object, channels: Iterable[tuple[str, str]]) -> None:
    """Give (bone, property) their values in the rest pose: what nothing keys keeps what was last played there."""
    for bone, name in channels:
        setattr(armature_object.pose.bones[bone], name, REST_CHANNELS[name])


def assign_action(armature_object, action) -> None:
    """Make ``armature_object`` play ``action``, by the slot that :func:`read_clip` would read.

    An artist's action that was assigned, and that nobody else uses, is stashed: Blender saves nothing without a user.
    """
    slot = action_curves(armature_object, action).slot
    animation = armature_object.animation_data_create()
    before = animation.action
    if before not in (None, action) and WALK_PROPERTY not in before and before.users < 2 and not before.use_fake_user:
        stash_assigned(animation)
    animation.action = action
    animation.action_slot = slot


def stash_assigned(animation) -> None:
    """Take the assigned action off, as Blender's Stash does: onto a muted track, unless a strip plays it already."""
    action, slot = animation.action, animation.action_slot
    if action is None:
        return
    animation.action = None
    if any(strip.action == action for track in animation.nla_tracks for strip in track.strips):
        return
    track = animation.nla_tracks.new()
    track.name = _STASH
    strip = track.strips.new(action.name, int(action.frame_range[0]), action)
    strip.action_slot = slot
    track.mute = track.lock = True


def write_linear_keys(curve, frames: np.ndarray, values: np.ndarray) -> None:
    """Fill an empty f-curve with one linear key for each of the (F,) frame numbers."""
    points = curve.keyframe_points
    points.add(len(frames))
    points.foreach_set("co", np.column_stack([frames, values]).astype(np.float32).ravel())
    points.foreach_set("interpolation", np.full(len(frames), _LINEAR, dtype=np.int32))
    curve.update()


@dataclass(frozen=True)
class Placements:
    """Places of the armature object, frame by frame: (F, 4) rotations or (4,), (F, 3) or (3,) metres, one scale."""

    rotation: np.ndarray
    translation: np.ndarray
    scale: float


def carried_placements(binding: RigBinding, clip: MotionClip, carriers: Carriers) -> Placements:
    """The object's present placement, carried along the clip's ground path as far as its actions move it.

    It keeps its place relative to the rest pose's root: where that is above the path, heading as the path does.
    """
    present, skeleton = binding.placement, binding.skeleton
    rotation, translation = present.rotation, present.translation
    if not carriers.object_moves:
        return Placements(rotation, translation, present.scale)
    x, y, heading = clip.ground_path.T
    forward = skeleton.rest_forward
    angles = heading - np.arctan2(forward[1], forward[0])
    turn = quat.about("z", angles) if "rotation" in carriers.object_moves else quat.IDENTITY
    if "location" in carriers.object_moves:
        below_root = np.column_stack([x, y, np.full(clip.n_frames, skeleton.rest_translations[0, 2])])
        translation = below_root + quat.rotate(turn, translation - skeleton.rest_translations[0])
    return Placements(quat.multiply(turn, rotation), translation, present.scale)


def object_channels(armature_object, placements: Placements, keys: Collection[str], n_frames: int):
    """Property of the object -> (F, C) values of its placements, for those of "location" and "rotation" in ``keys``."""
    matrices = np.tile(np.eye(4), (n_frames, 1, 1))
    matrices[:, :3, :3] = placements.scale * quat.to_matrix(placements.rotation)
    matrices[:, :3, 3] = placements.translation
    if armature_object.parent is not None:
        parent = np.array(armature_object.parent.matrix_world @ armature_object.matrix_parent_inverse)
        matrices = np.linalg.inv(parent) @ matrices
    channels = {}
    if "location" in keys:
        channels["location"] = matrices[:, :3, 3]
    if "rotation" in keys:
        mode = armature_object.rotation_mode
        turns = np.array([matrix_placement(matrix, armature_object.name).rotation for matrix in matrices])
        channels[rotation_property(mode)] = channels_from_quaternions(mode, turns)
    return channels


def bone_channels(
    binding: RigBinding, clip: MotionClip, only_bones, carriers: Carriers, placements: Placements
) -> dict[tuple[str, str], np.ndarray]:
    """(bone name, property) -> (F, C) values of everything to be keyed."""
    bones, joints = _matches(binding, clip.skeleton)
    corrections = _axis_corrections(binding, clip.skeleton, bones, joints)
    world_rotations, world_positions = clip.world
    to_armature = quat.inverse(placements.rotation)
    scale = placements.scale
    joint_of = dict(zip(bones, joints, strict=True))

    channels = {}
    poses: dict[int, tuple[np.ndarray, np.ndarray]] = {}  # armature-space rotation and position of each bone
    for bone in binding.bone_order:
        parent = binding.bone_parents[bone]
        rest = binding.relative_rests[bone]
        parent_turn, parent_position = poses[parent] if parent >= 0 else (quat.IDENTITY, np.zeros(3))
        # The frames in which the bone's own channels act.
        carried = quat.multiply(parent_turn, binding.relative_rest_rotations[bone])
        base = carried if binding.inherits_rotation[bone] else binding.rest_rotations[bone]
        location_base = carried if binding.local_location[bone] else parent_turn
        position = parent_position + quat.rotate(parent_turn, rest[:3, 3])
        if bone not in joint_of:
            poses[bone] = base, position
            continue
        joint = joint_of[bone]
        name = binding.skeleton.names[bone]
        keyed = only_bones is None or name in only_bones
        turn = quat.multiply(to_armature, world_rotations[:, joint], corrections[bone])
        target = quat.rotate(to_armature, world_positions[:, joint] - placements.translation) / scale
        if bone in carriers.still:
            turn, target = (np.tile(values, (clip.n_frames, 1)) for values in carriers.still[bone])
        elif bone in carriers.level:
            turn, target = levelled(turn, target, carriers.level[bone], binding.up)
        if keyed:
            basis = quat.multiply(quat.inverse(base), turn)
            mode = binding.rotation_modes[bone]
            channels[name, rotation_property(mode)] = channels_from_quaternions(mode, basis)

        offset = None
        clip_parent = clip.skeleton.parents[joint]
        if joint == 0 or not binding.keeps_parent[bone] or joint_of.get(parent, clip_parent) != clip_parent:
            # It hangs from elsewhere in the skeleton, or from nothing: only its place in the world counts.
            offset = target - position
        else:
            # Relative to the rest position, so that a character of other proportions keeps its own.
            away = clip.translations[:, joint] - clip.skeleton.rest_translations[joint]
            if np.abs(away).max() > STILL:
                offset = quat.rotate(to_armature, quat.rotate(world_rotations[:, clip_parent], away)) / scale
        if offset is not None and not binding.connected[bone]:
            if keyed:
                channels[name, "location"] = quat.rotate(quat.inverse(location_base), offset)
            position = position + offset
        elif joint == 0 and binding.connected[bone]:
            raise ClipError(
                f"Bone '{name}' of '{binding.object_name}' carries the character but is connected to its "
                "parent, so that it cannot travel; switch off Connected in its bone relations."
            )
        poses[bone] = turn, position
    return channels


def _matches(binding: RigBinding, skeleton: Skeleton) -> tuple[list[int], list[int]]:
    """Bones (joints of the binding) and joints (of the clip) that share a name."""
    joint_of = {name: joint for joint, name in enumerate(skeleton.names)}
    bones = [bone for bone, name in enumerate(binding.skeleton.names) if name in joint_of]
    if skeleton.names[0] not in binding.skeleton.names:
        raise ClipError(
            f"The armature '{binding.object_name}' has no bone called '{skeleton.names[0]}', the root of the "
            "motion; choose the armature that the motion graph was built from, or one with the same bone names."
        )
    return bones, [joint_of[binding.skeleton.names[bone]] for bone in bones]


def _axis_corrections(binding: RigBinding, skeleton: Skeleton, bones, joints) -> dict[int, np.ndarray]:
    """For each bone, the rotation from its joint's axes to its own: world bone = world joint * correction.

    It is what lies between the two in the rest pose, once the two rest poses stand in the same direction.
    """
    own = binding.skeleton
    if _same_rest(skeleton, own):
        return dict.fromkeys(bones, quat.IDENTITY)
    joint_turns, joint_places = skeleton.rest_world
    bone_turns, bone_places = own.rest_world
    aligned = _heading_between(
        joint_places[joints],
        bone_places[bones],
        skeleton.rest_forward,
        own.rest_forward,
    )
    return {
        bone: quat.multiply(quat.inverse(quat.multiply(aligned, joint_turns[joint])), bone_turns[bone])
        for bone, joint in zip(bones, joints, strict=True)
    }


def _same_rest(skeleton: Skeleton, other: Skeleton) -> bool:
    """Return True if both have the same rest pose, wherever it stands in the world."""
    if not skeleton.is_like(other):
        return False
    turned = 1 - np.abs(np.sum(skeleton.rest_rotations[1:] * other.rest_rotations[1:], axis=1))
    moved = skeleton.rest_translations[1:] - other.rest_translations[1:]
    return bool(np.all(turned < 1e-6) and np.all(np.abs(moved) < 1e-4) and skeleton.forward @ other.forward > 1 - 1e-6)


def _heading_between(places, target_places, forward, target_forward) -> np.ndarray:
    """The turn about the vertical that best brings the (N, 3) rest positions over the target's (least
    squares).

    Where the positions do not tell, on a straight vertical chain, the forward directions do.
    """
    source = places[:, :2] - places[:, :2].mean(axis=0)
    target = target_places[:, :2] - target_places[:, :2].mean(axis=0)
    along = np.sum(source * target)
    across = np.sum(source[:, 0] * target[:, 1] - source[:, 1] * target[:, 0])
    size = np.sqrt(np.sum(source**2) * np.sum(target**2))
    if np.hypot(along, across) > 1e-4 * max(np.ptp(places, axis=0).max() ** 2, 1e-9) and size > 0:
        angle = np.arctan2(across, along)
    else:
        angle = np.arctan2(target_forward[1], target_forward[0]) - np.arctan2(forward[1], forward[0])
    return quat.about("z", angle)
