"""Characters in the manners of several tools, all of which perform the same walks.

Their keys are made from the sample's world transforms here, by plain matrices, so that nothing of what reads and
writes actions is used to make what it is tested on.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import bpy
import numpy as np
from mathutils import Matrix
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from bl_ext.user_default.wayfarer.core.motion.clip import MotionClip
from bl_ext.user_default.wayfarer.core.motion.repertoire import sample_bone_lengths, sample_repertoire, sample_skeleton

WALKS = ("walk", "walk_again", "turn_left_45", "turn_right_45", "turn_left_90", "arc_right", "start_left", "stop_short")
"""The clips of the sample that every character performs."""

FRAME_RATE = 30

BESIDE = (0.3, -0.2, 0.0)
"""From below the hips to the origin of the armature object that carries its character, in metres."""

_TRUNK = ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head")
_LIMBS = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
_UNREAL_TRUNK = ("pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head")
_UNREAL_LIMBS = ("clavicle", "upperarm", "lowerarm", "hand", "thigh", "calf", "foot", "ball")


@dataclass(frozen=True)
class Character:
    """A rig with its actions, and what it is known to do.

    Attributes
    ----------
    object_name : str
        Of the armature object.
    action_names : tuple of str
        One for each clip.
    clips : tuple of MotionClip
        The same motions as the sample's skeleton performs them, with the rig's size, place and heading.
    root : str
        The bone that carries the body.
    bone_of : dict of str to str
        The rig's bone for each of the sample's joints.
    size : float
        How many times as large as the sample, which is 1.75 m tall.
    controls : tuple of str
        Bones that the actions move, if others follow those.
    is_copy : bool
        All bones go where the sample's joints go; otherwise only the toes do.
    """

    object_name: str
    action_names: tuple[str, ...]
    clips: tuple[MotionClip, ...]
    root: str
    bone_of: dict[str, str]
    size: float = 1.0
    controls: tuple[str, ...] = ()
    is_copy: bool = True

    @property
    def armature_object(self):
        return bpy.data.objects[self.object_name]

    @property
    def actions(self) -> list:
        return [bpy.data.actions[name] for name in self.action_names]


@dataclass(frozen=True)
class Bone:
    """A bone to be built.

    Attributes
    ----------
    name : str
    parent : str, optional
    rest : (4, 4) float array
        Rotation and head at rest, in the world of the sample.
    length : float
        Metres.
    motion : callable
        From a clip to (F, 4, 4) rotation and head on every frame, in the clip's world.
    """

    name: str
    parent: str | None
    rest: np.ndarray
    length: float
    motion: Callable[[MotionClip], np.ndarray]


def sample_walks() -> tuple[MotionClip, ...]:
    """The clips of the sample that every character performs."""
    clips = {clip.name: clip for clip in sample_repertoire(FRAME_RATE)}
    return tuple(clips[name] for name in WALKS)


def placed(clip: MotionClip, place: np.ndarray) -> MotionClip:
    """The clip moved, turned and scaled by a (4, 4) similarity."""
    size = np.cbrt(np.linalg.det(place[:3, :3]))
    turn = Rotation.from_matrix(place[:3, :3] / size)

    def turned(rotation):
        return (turn * Rotation.from_quat(rotation, scalar_first=True)).as_quat(scalar_first=True)

    def moved(positions):
        return place[:3, 3] + positions @ place[:3, :3].T

    rotations, translations = clip.rotations.copy(), clip.translations * size
    rotations[:, 0], translations[:, 0] = turned(clip.rotations[:, 0]), moved(clip.translations[:, 0])
    rest_rotations, rest_translations = clip.skeleton.rest_rotations.copy(), clip.skeleton.rest_translations * size
    rest_rotations[0] = turned(rest_rotations[0])
    rest_translations[0] = moved(clip.skeleton.rest_translations[0])
    skeleton = replace(clip.skeleton, rest_rotations=rest_rotations, rest_translations=rest_translations)
    return replace(clip, skeleton=skeleton, rotations=rotations, translations=translations)


def similarity(angles=(0.0, 0.0, 0.0), location=(0.0, 0.0, 0.0), scale: float = 1.0) -> np.ndarray:
    """(4, 4) matrix of XYZ Euler angles in degrees, a location in metres and a uniform scale."""
    matrix = np.eye(4)
    matrix[:3, :3] = scale * Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    matrix[:3, 3] = location
    return matrix


def mixamo_character(clips: Sequence[MotionClip]) -> Character:
    """Hips carry the travel; bones in centimetres, Y up, in an object turned and scaled, as FBX files come.

    The object has keys too, which hold it where it is.
    """
    names = {joint: f"mixamorig:{joint}" for joint in sample_skeleton().names}
    object_matrix = similarity((90, 0, 0), scale=0.01)
    return _built("Armature", clips, names, _body(names), object_matrix, object_motion=_nowhere)


def unreal_character(clips: Sequence[MotionClip], travel: str) -> Character:
    """A root bone on the ground above the pelvis, IK bones below it; all channels of all bones keyed.

    ``travel`` says which bone goes through the world, "root" or "pelvis"; the root stays where it is in the other
    case. Bones point along none of the limbs.
    """
    names = dict(zip(_TRUNK, _UNREAL_TRUNK, strict=True))
    for side, suffix in (("Left", "_l"), ("Right", "_r")):
        names |= {side + joint: name + suffix for joint, name in zip(_LIMBS, _UNREAL_LIMBS, strict=True)}
    body = _body(names, axes=Rotation.from_euler("xyz", (90, 0, 90), degrees=True))
    ground = ground_motion if travel == "root" else _nowhere
    by_name = {bone.name: bone for bone in body}
    bones = [Bone("root", None, np.eye(4), 0.3, ground), replace(body[0], parent="root"), *body[1:]]
    bones.append(Bone("ik_foot_root", "root", np.eye(4), 0.1, ground))
    for side in ("_l", "_r"):
        bones.append(replace(by_name["foot" + side], name="ik_foot" + side, parent="ik_foot_root"))
        bones.append(replace(by_name["thigh" + side], name="thigh_twist_01" + side, parent="thigh" + side))
    return _built("Mannequin", clips, names, bones, np.eye(4), mode="XYZ", all_channels=True)


def object_rooted_character(clips: Sequence[MotionClip], turns: bool = True) -> Character:
    """Bones move on the spot; the armature object goes, and ``turns`` or not, by keys in the same actions.

    Its origin lies beside the character, at :data:`BESIDE` when that faces -Y.
    """
    names = {joint: joint for joint in sample_skeleton().names}

    def motion(clip):
        matrices = ground_motion(clip)
        if not turns:
            matrices[:, :3, :3] = np.eye(3)
        return matrices

    return _built("Puppet", clips, names, _body(names), similarity(location=BESIDE), object_motion=motion)


def placed_character(clips: Sequence[MotionClip], object_matrix: np.ndarray, size: float = 1.0) -> Character:
    """Named as the sample, in an armature object that stands as ``object_matrix`` says.

    The object's place and turn about the vertical are the character's; its tilt and its scale are made up for by the
    bones, so that the character is upright and ``size`` times as large as the sample.
    """
    names = {joint: joint for joint in sample_skeleton().names}
    # Where +X goes, the character turns; no tilt that is used here turns that axis out of the ground plane.
    heading = np.degrees(np.arctan2(object_matrix[1, 0], object_matrix[0, 0]))
    place = similarity((0, 0, heading), object_matrix[:3, 3], size)
    return _built("Figure", clips, names, _body(names), object_matrix, place=place)


def ground_motion(clip):
    """(F, 4, 4) of what goes along below the body, on the ground and more evenly than the hips.

    Nothing of what the rigs are tested for is used here.
    """
    rest = Rotation.from_quat(clip.skeleton.rest_rotations[0], scalar_first=True)
    turn = Rotation.from_quat(clip.rotations[:, 0], scalar_first=True) * rest.inv()
    forward = turn.apply([0.0, -1.0, 0.0])
    heading = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0])) + np.pi / 2
    path = np.column_stack([clip.translations[:, 0, :2], heading])
    path = gaussian_filter1d(path, 6.0, axis=0, mode="nearest")
    matrices = np.tile(np.eye(4), (len(path), 1, 1))
    matrices[:, :3, :3] = Rotation.from_euler("z", path[:, 2:]).as_matrix()
    matrices[:, :2, 3] = path[:, :2]
    return matrices


def _nowhere(clip):
    return np.tile(np.eye(4), (clip.n_frames, 1, 1))


def _body(names, axes=None) -> list[Bone]:
    """The sample's bones under other names, their axes turned by ``axes``."""
    skeleton, lengths = sample_skeleton(), sample_bone_lengths()
    axes = axes or Rotation.identity()
    rotations, positions = skeleton.rest_world

    def matrices(quaternions, heads):
        result = np.tile(np.eye(4), (len(heads), 1, 1))
        result[:, :3, :3] = (Rotation.from_quat(quaternions, scalar_first=True) * axes).as_matrix()
        result[:, :3, 3] = heads
        return result

    def motion_of(joint):
        return lambda clip: matrices(clip.world[0][:, joint], clip.world[1][:, joint])

    rests = matrices(rotations, positions)
    return [
        Bone(
            names[name],
            names[skeleton.names[skeleton.parents[joint]]] if joint else None,
            rests[joint],
            lengths[joint],
            motion_of(joint),
        )
        for joint, name in enumerate(skeleton.names)
    ]


def _built(
    name, clips, names, bones, object_matrix, place=None, mode="QUATERNION", all_channels=False, object_motion=None
) -> Character:
    place = np.eye(4) if place is None else place
    size = np.cbrt(np.linalg.det(place[:3, :3]))
    armature_object = _armature(name, bones, np.linalg.inv(object_matrix) @ place, object_matrix)
    rests = {bone.name: np.array(bone.matrix_local) for bone in armature_object.data.bones}
    for bone in armature_object.pose.bones:
        bone.rotation_mode = mode
    for clip in clips:
        curves = Curves(clip.name, armature_object)
        objects = np.tile(object_matrix, (clip.n_frames, 1, 1))
        if object_motion is not None:
            objects = object_motion(clip) @ object_matrix
            curves.key("location", objects[:, :3, 3])
            curves.key("rotation_euler", euler_angles(rigid(objects)[:, :3, :3]))
            curves.key("scale", np.cbrt(np.linalg.det(objects[:, :3, :3]))[:, None].repeat(3, axis=1))
        poses = {bone.name: rigid(np.linalg.inv(objects) @ place @ bone.motion(clip)) for bone in bones}
        for bone in bones:
            carried = rests[bone.name]
            if bone.parent:
                carried = poses[bone.parent] @ np.linalg.inv(rests[bone.parent]) @ rests[bone.name]
            curves.pose(bone.name, np.linalg.inv(carried) @ poses[bone.name], mode, all_channels or bone is bones[0])
    return Character(
        armature_object.name,
        tuple(clip.name for clip in clips),
        tuple(placed(clip, place) for clip in clips),
        names["Hips"],
        names,
        float(size),
    )


def _armature(name, bones, to_armature, object_matrix):
    data = bpy.data.armatures.new(name)
    armature_object = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(armature_object)
    armature_object.matrix_world = Matrix(object_matrix)
    bpy.context.view_layer.objects.active = armature_object
    bpy.ops.object.mode_set(mode="EDIT")
    scale = np.cbrt(np.linalg.det(to_armature[:3, :3]))
    for bone in bones:
        edited = data.edit_bones.new(bone.name)
        edited.tail = (0.0, bone.length * scale, 0.0)
        edited.matrix = Matrix(rigid((to_armature @ bone.rest)[None])[0])
        if bone.parent:
            edited.parent = data.edit_bones[bone.parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature_object


def rigid(matrices: np.ndarray) -> np.ndarray:
    """(F, 4, 4) matrices without their uniform scale."""
    matrices = matrices.copy()
    matrices[:, :3, :3] /= np.cbrt(np.linalg.det(matrices[:, :3, :3]))[:, None, None]
    return matrices


def euler_angles(rotations: np.ndarray) -> np.ndarray:
    """(F, 3) unwrapped angles of Blender's XYZ order."""
    return np.unwrap(Rotation.from_matrix(rotations).as_euler("xyz"), axis=0)


@dataclass
class Curves:
    """The curves of a new action, one linear key a frame from frame 1 on."""

    name: str
    armature_object: object
    _bag: object = field(init=False)

    def __post_init__(self):
        action = bpy.data.actions.new(self.name)
        action.use_fake_user = True
        slot = action.slots.new("OBJECT", self.armature_object.name)
        self._bag = action.layers.new("Layer").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)

    def pose(self, bone: str, basis: np.ndarray, mode: str, with_location: bool) -> None:
        """Key a bone's (F, 4, 4) transforms, relative to rest, in a rotation mode."""
        path = f'pose.bones["{bone}"].'
        if mode == "QUATERNION":
            quaternions = Rotation.from_matrix(basis[:, :3, :3]).as_quat(scalar_first=True)
            flips = np.sign(np.sum(quaternions[1:] * quaternions[:-1], axis=1))
            quaternions[1:] *= np.cumprod(flips)[:, None]
            self.key(path + "rotation_quaternion", quaternions)
        else:
            self.key(path + "rotation_euler", euler_angles(basis[:, :3, :3]))
        if with_location:
            self.key(path + "location", basis[:, :3, 3])
            self.key(path + "scale", np.ones((len(basis), 3)))

    def key(self, path: str, values: np.ndarray) -> None:
        """Key a property to (F, C) values."""
        for index, column in enumerate(values.T):
            curve = self._bag.fcurves.new(path, index=index)
            curve.keyframe_points.add(len(column))
            keys = np.column_stack([1 + np.arange(len(column)), column]).astype(np.float32)
            curve.keyframe_points.foreach_set("co", keys.ravel())
            curve.keyframe_points.foreach_set("interpolation", np.ones(len(column), dtype=np.int32))
            curve.update()
