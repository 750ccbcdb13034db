"""The general, slower way to read a motion: Blender evaluates every frame, with constraints and drivers."""

import contextlib
import re

import bpy
import numpy as np

from ...core.errors import ClipError
from ...core.motion import kinematics, quat
from .rig import RigBinding, matrix_placement, read_matrices
from .rotation_modes import REST_CHANNELS


def evaluated_matrices(armature_object, action, slot, frames: np.ndarray, bone_names) -> tuple[np.ndarray, np.ndarray]:
    """Let Blender evaluate the armature on each frame while it plays ``action`` alone, from its rest pose.

    Returns the pose (F, B, 4, 4) of the bones ``bone_names`` in armature space and the object's world
    matrices (F, 4, 4). Everything is left as it was to the last float, unkeyed poses and moves included.

    Raises ClipError if the object is not part of the current view layer, so that Blender does not evaluate
    it, or if its NLA is being tweaked.
    """
    if bpy.context.view_layer.objects.get(armature_object.name) != armature_object:
        raise ClipError(
            f"The armature '{armature_object.name}' is not in the current view layer, so that Blender cannot "
            "evaluate its constraints; include its collection."
        )
    order = [armature_object.pose.bones.find(name) for name in bone_names]
    poses = np.empty((len(frames), len(bone_names), 4, 4))
    worlds = np.empty((len(frames), 4, 4))
    with _playing_alone(armature_object, action, slot), _scene_apart(armature_object) as scene:
        for index, frame in enumerate(frames):
            whole = int(np.floor(frame))
            scene.frame_set(whole, subframe=float(frame - whole))
            evaluated = armature_object.evaluated_get(scene.view_layers[0].depsgraph)
            poses[index] = read_matrices(evaluated.pose.bones, "matrix")[order]
            worlds[index] = evaluated.matrix_world
    return poses, worlds


def local_transforms(binding: RigBinding, poses: np.ndarray, worlds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Joint rotations (F, J, 4) and translations (F, J, 3) in the conventions of a clip, of evaluated
    matrices.

    Scale and shear of single bones move their children, and are otherwise dropped.
    """
    skeleton = binding.skeleton
    for world in worlds:
        matrix_placement(world, binding.object_name)
    matrices = worlds[:, None] @ poses
    finite = np.isfinite(matrices).all(axis=(2, 3))
    if not finite.all():
        frame, joint = np.argwhere(~finite)[0]
        raise ClipError(
            f"The pose of '{binding.object_name}' is not a number at sample {frame}, bone "
            f"'{skeleton.names[joint]}'; repair its keys or constraints."
        )
    axes = matrices[..., :3, :3]
    lengths = np.linalg.norm(axes, axis=2, keepdims=True)
    axes = axes / np.where(lengths > 0, lengths, 1.0)
    # A bone scaled to nothing or mirrored has no rotation of its own: it keeps the one of its rest pose.
    axes = np.where(
        (np.linalg.det(axes) > 1e-6)[..., None, None],
        axes,
        _unscaled(worlds)[:, None] @ binding.rest_matrices[:, :3, :3],
    )
    return kinematics.local_transforms(quat.from_matrix(axes), matrices[..., :3, 3], skeleton.parents)


def _unscaled(worlds):
    axes = worlds[:, :3, :3]
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


@contextlib.contextmanager
def _scene_apart(armature_object):
    """Yield a scene of its own with the armature in it, and all that it depends on; it is removed at the end.

    Blender writes what it evaluates back into poses and transforms for scenes that a window shows. Setting a frame of
    this one changes neither them nor anything else.
    """
    shown, scene = bpy.context.scene, bpy.data.scenes.new("Wayfarer Reading")
    try:
        scene.collection.objects.link(armature_object)
        for name in ("fps", "fps_base", "frame_map_old", "frame_map_new"):
            setattr(scene.render, name, getattr(shown.render, name))
        yield scene
    finally:
        bpy.data.scenes.remove(scene)


@contextlib.contextmanager
def transforms_kept(scene):
    """Put poses and transforms of a scene's objects back at the end, keyed or not: a frame that is set moves them."""
    before = []
    for obj in scene.objects:
        for holder in (obj, *(obj.pose.bones if obj.pose is not None else ())):
            before.append((holder, {name: tuple(getattr(holder, name)) for name in REST_CHANNELS}))
    try:
        yield
    finally:
        for holder, values in before:
            for name, value in values.items():
                if tuple(getattr(holder, name)) != value:
                    setattr(holder, name, value)


@contextlib.contextmanager
def _playing_alone(armature_object, action, slot):
    """Play one action on the rest pose, without NLA; put everything back afterwards."""
    bones = armature_object.pose.bones
    had_animation = armature_object.animation_data is not None
    animation = armature_object.animation_data_create()
    if animation.use_tweak_mode:
        raise ClipError(f"'{armature_object.name}' is in the NLA's tweak mode; leave it and try again.")
    action_before, slot_before = animation.action, animation.action_slot
    settings = {name: getattr(animation, name) for name in ("use_nla", "action_influence", "action_blend_type")}
    position_before = armature_object.data.pose_position
    others_before = _other_values(armature_object, action, slot)
    if action_before is not None and slot_before is not None and action_before != action:
        others_before += _other_values(armature_object, action_before, slot_before)
    pose_before = {name: np.empty(len(bones) * len(rest), dtype=np.float32) for name, rest in REST_CHANNELS.items()}
    placement_before = {name: tuple(getattr(armature_object, name)) for name in REST_CHANNELS}
    for name, rest in REST_CHANNELS.items():
        bones.foreach_get(name, pose_before[name])
        bones.foreach_set(name, np.tile(np.array(rest, dtype=np.float32), len(bones)))
    try:
        animation.use_nla, animation.action_influence, animation.action_blend_type = False, 1.0, "REPLACE"
        animation.action = action
        animation.action_slot = slot
        armature_object.data.pose_position = "POSE"
        yield
    finally:
        for name, value in settings.items():
            setattr(animation, name, value)
        animation.action = action_before
        if action_before is not None and slot_before is not None:
            animation.action_slot = slot_before
        if not had_animation:
            armature_object.animation_data_clear()
        armature_object.data.pose_position = position_before
        # Assigning an action has Blender play it once more: only then comes the pose that was not keyed.
        bpy.context.view_layer.update()
        for owner, key, index, value in others_before:
            _set_value(armature_object, owner, key, index, value)
        for name, values in pose_before.items():
            bones.foreach_set(name, values)
            setattr(armature_object, name, placement_before[name])
        armature_object.update_tag()
        bpy.context.view_layer.update()


_DATA_PATH = re.compile(
    r"""(?P<owner>.*?)                                  # pose.bones["hand.L"]
    (?: \.?(?P<name>\w+) | \["(?P<custom>(?:[^"\\]|\\.)*)"\] )$  # .influence or ["IK_FK"]""",
    re.VERBOSE,
)


def _other_values(armature_object, action, slot) -> list[tuple[str, str, int, object]]:
    """Find what the action animates besides transforms (influences, custom properties): place and present value."""
    values = []
    for layer in action.layers:
        for strip in layer.strips:
            channelbag = strip.channelbag(slot)
            for curve in channelbag.fcurves if channelbag else ():
                match = _DATA_PATH.match(curve.data_path)
                if match is None or match["name"] in REST_CHANNELS:
                    continue
                try:
                    value = armature_object.path_resolve(curve.data_path)
                except ValueError:  # a curve of something that is no longer there
                    continue
                if isinstance(value, bpy.types.bpy_struct | bpy.types.bpy_prop_collection):  # a bone, say: no value
                    continue
                is_array = hasattr(value, "__len__") and not isinstance(value, str)
                if is_array and curve.array_index >= len(value):  # nor is this: an array that was made shorter
                    continue
                index = curve.array_index if is_array else -1
                key = match["name"] or f'["{match["custom"]}"]'
                values.append((match["owner"], key, index, value[index] if is_array else value))
    return values


def _set_value(armature_object, owner, key, index, value):
    holder = armature_object.path_resolve(owner) if owner else armature_object
    if index >= 0:
        (armature_object.path_resolve(f"{owner}.{key}".strip(".")))[index] = value
    elif key.startswith("["):
        holder[bpy.utils.unescape_identifier(key[2:-2])] = value
    else:
        setattr(holder, key, value)
