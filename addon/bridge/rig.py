"""From an armature object to the core's Skeleton, and what is needed to find the way back."""

from dataclasses import dataclass
from functools import cached_property

import bpy
import numpy as np

from ...core.errors import ClipError
from ...core.motion import quat
from ...core.motion.anatomy import find_body_root, find_facing
from ...core.motion.kinematics import ancestors, descendants, local_transforms
from ...core.motion.skeleton import Skeleton
from .rotation_modes import REST_CHANNELS

FORWARD_PROPERTY = "wayfarer_forward"
"""Custom property of an armature object: the direction, in armature space, that the character faces."""

ROOT_PROPERTY = "wayfarer_root"
"""Custom property of an armature object: the name of the bone that carries the body."""

_LEVEL = 0.05
"""A direction of unit length is horizontal enough to face if what lies in the ground's plane is at least this long."""


@dataclass(frozen=True)
class Placement:
    """The place of an object: world = translation + scale * rotation(local).

    ``rotation`` is a unit quaternion (w, x, y, z), ``translation`` (3,) in metres, ``scale`` one positive
    factor.
    """

    rotation: np.ndarray
    translation: np.ndarray
    scale: float


@dataclass(frozen=True)
class RigBinding:
    """Correspondence of the joints of a Skeleton and the bones of an armature; names and arrays, no references.

    Arrays are indexed by joint, in the order of ``skeleton.names``; J joints.

    Attributes
    ----------
    object_name : str
        The armature object's name.
    skeleton : Skeleton
        Every bone of the armature. Joint 0 carries the body; bones that do not hang below it (a ground bone
        above the hips, IK targets) hang directly from it here, so that it is one tree.
    bone_parents : (J,) int array
        Joint index of each bone's parent in the armature, -1 if it has none.
    rest_matrices : (J, 4, 4) float array
        Rest pose in armature space (Blender units).
    rotation_modes : tuple of str
        Blender's rotation mode of each pose bone.
    connected : (J,) bool array
        Bones that are glued to their parent's tail: Blender ignores their location channels.
    inherits_rotation, local_location : (J,) bool arrays
        The bones' settings Inherit Rotation and Local Location.
    placement : Placement
        Where the armature object stood.
    evaluation_reason : str
        Empty if f-curves alone determine the pose; otherwise what else does (a constraint, a driver ...).
    """

    object_name: str
    skeleton: Skeleton
    bone_parents: np.ndarray
    rest_matrices: np.ndarray
    rotation_modes: tuple[str, ...]
    connected: np.ndarray
    inherits_rotation: np.ndarray
    local_location: np.ndarray
    placement: Placement
    evaluation_reason: str

    @cached_property
    def bone_order(self) -> np.ndarray:
        """(J,) joint indices with every bone after its parent in the armature."""
        return np.argsort(_depths(self.bone_parents), kind="stable")

    @cached_property
    def rest_rotations(self) -> np.ndarray:
        """(J, 4) rest rotations in armature space, quaternions (w, x, y, z)."""
        return quat.from_matrix(self.rest_matrices[:, :3, :3])

    @cached_property
    def relative_rests(self) -> np.ndarray:
        """(J, 4, 4) rest pose of each bone relative to its parent in the armature."""
        relative = self.rest_matrices.copy()
        children = np.flatnonzero(self.bone_parents >= 0)
        parents = self.rest_matrices[self.bone_parents[children]]
        relative[children] = np.linalg.solve(parents, self.rest_matrices[children])
        return relative

    @cached_property
    def relative_rest_rotations(self) -> np.ndarray:
        """(J, 4) the rotations in ``relative_rests``, quaternions (w, x, y, z)."""
        return quat.from_matrix(self.relative_rests[:, :3, :3])

    @cached_property
    def up(self) -> np.ndarray:
        """(3,) the world's vertical in armature space, where the object stands."""
        return quat.rotate(quat.inverse(self.placement.rotation), [0.0, 0.0, 1.0])

    @cached_property
    def outside_body(self) -> np.ndarray:
        """(K,) joints of the bones that do not hang below joint 0 in the armature, parents first."""
        inside = [0, *descendants(self.bone_parents, 0)]
        return self.bone_order[~np.isin(self.bone_order, inside)]

    @cached_property
    def keeps_parent(self) -> np.ndarray:
        """(J,) bool: the joint's parent in the skeleton is the bone's parent in the armature."""
        kept = np.asarray(self.skeleton.parents) == self.bone_parents
        kept[0] = False
        return kept


def bind_rig(armature_object, root_bone: str = "", forward: tuple[float, float, float] | None = None) -> RigBinding:
    """The skeleton of an armature object and how it corresponds to its bones.

    The root joint is ``root_bone``; if that is empty, the bone that the armature object's custom property
    ``wayfarer_root`` names; if there is none, the bone that carries the body: see
    :func:`core.motion.anatomy.find_body_root`.

    ``forward``, in armature space, says where the character faces. If it is not given, the armature object's
    custom property ``wayfarer_forward`` does; if that is not there either, it is that of the rest pose, see
    :func:`core.motion.anatomy.find_facing`, or else Blender's convention, -Y.

    The world is the scene's: the object's location, rotation and uniform scale are included, one Blender
    unit is one metre.

    Raises ClipError if the object is no armature, has no bones, is scaled unevenly or mirrored, if it has no
    bone called ``root_bone`` or as ``wayfarer_root`` says, or if its ``wayfarer_forward`` is no direction that anyone
    can face.
    """
    if armature_object is None or armature_object.type != "ARMATURE":
        name = armature_object.name if armature_object else "nothing"
        raise ClipError(f"'{name}' is not an armature; choose the character's armature object.")
    bones = armature_object.data.bones
    if len(bones) == 0:
        raise ClipError(f"The armature '{armature_object.name}' has no bones; choose the character's armature.")
    bpy.context.view_layer.update()
    placement = object_placement(armature_object)

    names = [bone.name for bone in bones]
    index_of = {name: index for index, name in enumerate(names)}
    parents = np.array([index_of[bone.parent.name] if bone.parent else -1 for bone in bones])
    rests = read_matrices(bones, "matrix_local")
    broken = ~np.isfinite(rests).all(axis=(1, 2))
    if broken.any():
        raise ClipError(
            f"The rest position of bone '{names[np.argmax(broken)]}' of '{armature_object.name}' is not a number; "
            "place it anew in edit mode."
        )
    root_bone = root_bone or chosen_root(armature_object)
    if root_bone and root_bone not in index_of:
        raise ClipError(f"The armature '{armature_object.name}' has no bone called '{root_bone}' to be its root.")
    deforming = np.array([bone.use_deform for bone in bones])
    heads = placement.scale * quat.rotate(placement.rotation, rests[:, :3, 3])
    root = index_of[root_bone] if root_bone else find_body_root(names, parents, heads, deforming)

    order = _joint_order(parents, root)
    place = np.argsort(order)  # from bone index to joint index
    bone_parents = np.where(parents[order] >= 0, place[parents[order]], -1)
    rests = rests[order]
    names = [names[index] for index in order]
    pose_bones = [armature_object.pose.bones[name] for name in names]
    return RigBinding(
        object_name=armature_object.name,
        skeleton=_skeleton(names, bone_parents, rests, placement, forward or chosen_forward(armature_object)),
        bone_parents=bone_parents,
        rest_matrices=rests,
        rotation_modes=tuple(bone.rotation_mode for bone in pose_bones),
        connected=np.array([bone.bone.use_connect and bone.parent is not None for bone in pose_bones]),
        inherits_rotation=np.array([bone.bone.use_inherit_rotation for bone in pose_bones]),
        local_location=np.array([bone.bone.use_local_location for bone in pose_bones]),
        placement=placement,
        evaluation_reason=_evaluation_reason(armature_object, pose_bones),
    )


def chosen_root(armature_object) -> str:
    """Return what the armature object's custom property ``wayfarer_root`` says; empty if there is none.

    Raises ClipError if that is no text.
    """
    value = armature_object.get(ROOT_PROPERTY, "")
    if not isinstance(value, str):
        raise ClipError(
            f"'{armature_object.name}' has a property {ROOT_PROPERTY} that is no name of a bone; correct or remove it."
        )
    return value


def chosen_forward(armature_object) -> tuple[float, float, float] | None:
    """The armature object's custom property ``wayfarer_forward``, or None if it has none.

    Raises ClipError if that is anything but three numbers that make a direction, not upright in the world.
    """
    value = armature_object.get(FORWARD_PROPERTY)
    if value is None:
        return None
    # Numbers that are all of one kind come as an array; a text and a list of other things have a length, too.
    given = list(value) if hasattr(value, "__len__") and not isinstance(value, str | bytes) else []
    if len(given) == 3 and all(isinstance(part, int | float) and np.isfinite(part) for part in given):
        world = np.array(armature_object.matrix_world, dtype=float)[:3, :3] @ given
        length = np.linalg.norm(world)
        if 0 < length < np.inf and np.linalg.norm(world[:2]) >= _LEVEL * length:
            return given[0], given[1], given[2]
    raise ClipError(
        f"'{armature_object.name}' has a property {FORWARD_PROPERTY} that is no horizontal direction of three "
        "numbers; correct or remove it."
    )


def object_placement(obj) -> Placement:
    """Return the place of ``obj`` in the world; ClipError if its scale is uneven, negative or zero."""
    return matrix_placement(np.array(obj.matrix_world, dtype=float), obj.name)


def matrix_placement(matrix: np.ndarray, object_name: str) -> Placement:
    """The placement that an object's (4, 4) world matrix stands for; ClipError as above names the object."""
    axes = matrix[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    scale = lengths.mean()
    even = scale > 0 and np.allclose(axes.T @ axes, scale**2 * np.eye(3), atol=1e-4 * scale**2)
    if not even or np.linalg.det(axes) <= 0:
        raise ClipError(
            f"The scale of '{object_name}' is uneven, negative or zero, so that its motion has no metres; "
            "use Object > Apply > Scale."
        )
    return Placement(quat.from_matrix(axes / scale), matrix[:3, 3].copy(), float(scale))


def read_matrices(collection, attribute: str) -> np.ndarray:
    """(N, 4, 4) matrices of a collection's items: matrices[i] @ column vector."""
    flat = np.empty(16 * len(collection), dtype=np.float32)
    collection.foreach_get(attribute, flat)
    return flat.reshape(-1, 4, 4).transpose(0, 2, 1).astype(float)  # Blender stores columns


def _skeleton(names, bone_parents, rests, placement, forward) -> Skeleton:
    to_world = placement.rotation
    rotations = quat.multiply(to_world, quat.from_matrix(rests[:, :3, :3]))
    positions = placement.translation + placement.scale * quat.rotate(to_world, rests[:, :3, 3])
    parents = np.zeros_like(bone_parents)
    below_root = descendants(bone_parents, 0)
    parents[0], parents[below_root] = -1, bone_parents[below_root]
    if forward is not None:
        direction = quat.rotate(to_world, np.asarray(forward, dtype=float) / np.linalg.norm(forward))
    else:
        direction = find_facing(names, bone_parents, positions)
        if direction is None:
            direction = quat.rotate(to_world, [0.0, -1.0, 0.0])
    own_forward = quat.rotate(quat.inverse(rotations[0]), direction)
    return Skeleton(tuple(names), parents, *local_transforms(rotations, positions, parents), own_forward)


def _evaluation_reason(armature_object, pose_bones) -> str:
    for bone in pose_bones:
        if any(not constraint.mute for constraint in bone.constraints):
            return f"bone '{bone.name}' has constraints"
        rest = bone.bone
        if not (rest.use_inherit_rotation and rest.inherit_scale == "FULL" and rest.use_local_location):
            return f"bone '{bone.name}' does not inherit its parent's whole transform"
    obstacle = placement_obstacle(armature_object)
    if obstacle:
        return obstacle
    for data in (armature_object, armature_object.data):
        if data.animation_data and len(data.animation_data.drivers):
            return "the rig has drivers"
    return ""


def placement_obstacle(armature_object) -> str:
    """Name what else than its own transform channels, and those of parents at rest, decides where the object is; empty
    if nothing does."""
    if any(not constraint.mute for constraint in armature_object.constraints):
        return "the object has constraints"
    if any(
        not np.allclose(getattr(armature_object, f"delta_{name}"), rest)
        for name, rest in REST_CHANNELS.items()
        if hasattr(armature_object, f"delta_{name}")
    ):
        return "the object has delta transforms"
    parent = armature_object.parent
    if parent is not None and armature_object.parent_type != "OBJECT":
        return "the object is parented to a part of another object"
    while parent is not None:
        if parent.animation_data is not None or len(parent.constraints):
            return f"the object is parented to '{parent.name}', which is animated"
        parent = parent.parent
    return ""


def _joint_order(parents, root) -> np.ndarray:
    """Bone indices, the root first, then what hangs below it, then the others, each in the armature's order.

    Blender lists every bone after its parent.
    """
    rank = np.full(len(parents), 2)
    rank[root], rank[descendants(parents, root)] = 0, 1
    return np.argsort(rank, kind="stable")


def _depths(parents) -> np.ndarray:
    return np.array([_depth(parents, index) for index in range(len(parents))])


def _depth(parents, index) -> int:
    return len(ancestors(parents, index))
