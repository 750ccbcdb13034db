"""An armature made from a Skeleton."""

from collections.abc import Mapping

import bpy
import numpy as np

from ...core.motion import quat
from ...core.motion.skeleton import Skeleton
from .rig import FORWARD_PROPERTY

_SHORTEST = 0.005
"""Part of the stature below which a tail is too near to be a bone's: Blender deletes bones without length."""


def create_armature(skeleton: Skeleton, tails: Mapping[str, np.ndarray], name: str, collection):
    """A new armature object in ``collection`` whose rest pose is that of ``skeleton``.

    ``tails`` gives, by bone name, the (3,) world position in metres of the tails of leaf joints, and of any
    other bone that should not point at its child. A bone with several children points at the one that lies
    most nearly in its own direction. Bones point along their own Y as always in Blender, rolled so that
    their Z lies as near to their joint's Z as it can: where the joint's Y points along the bone, both have
    the same axes. Where it does not, :func:`write_clip` accounts for the difference. The object stands at
    the world's origin, unrotated, and is made the active one; bones rotate in quaternions.
    """
    rotations, heads = skeleton.rest_world
    joint_z = quat.rotate(rotations, [0.0, 0.0, 1.0])
    ends = _tails(skeleton, heads, tails)

    armature = bpy.data.armatures.new(name)
    armature_object = bpy.data.objects.new(name, armature)
    scene_collection = bpy.context.scene.collection
    collection.objects.link(armature_object)
    # Edit mode wants an object of the view layer, which the collection may not be part of.
    view_layer = bpy.context.view_layer
    view_layer.update()
    guest = view_layer.objects.get(armature_object.name) is None
    if guest:
        scene_collection.objects.link(armature_object)
    if view_layer.objects.active is not None and view_layer.objects.active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    view_layer.objects.active = armature_object
    bpy.ops.object.mode_set(mode="EDIT")
    bones = []
    for joint, joint_name in enumerate(skeleton.names):
        bone = armature.edit_bones.new(joint_name)
        bone.head, bone.tail = heads[joint], ends[joint]
        bone.align_roll(joint_z[joint])
        if skeleton.parents[joint] >= 0:
            bone.parent = bones[skeleton.parents[joint]]
        bones.append(bone)
    bpy.ops.object.mode_set(mode="OBJECT")
    if guest:
        scene_collection.objects.unlink(armature_object)
    armature_object[FORWARD_PROPERTY] = tuple(skeleton.rest_forward)
    return armature_object


def _tails(skeleton: Skeleton, heads: np.ndarray, given: Mapping[str, np.ndarray]) -> np.ndarray:
    """(J, 3) the tail of each bone."""
    parents = np.asarray(skeleton.parents)
    tails = np.empty_like(heads)
    shortest = _SHORTEST * skeleton.stature
    for joint, name in enumerate(skeleton.names):
        came_from = heads[joint] - heads[parents[joint]] if parents[joint] >= 0 else np.array([0.0, 0.0, 1.0])
        children = heads[parents == joint] - heads[joint]
        lengths = np.linalg.norm(children, axis=1)
        children, lengths = children[lengths > shortest], lengths[lengths > shortest]
        if name in given and np.linalg.norm(given[name] - heads[joint]) > shortest:
            tails[joint] = given[name]
        elif len(children):
            tails[joint] = heads[joint] + children[np.argmax(children @ came_from / lengths)]
        elif np.linalg.norm(came_from) > shortest:
            tails[joint] = heads[joint] + came_from / 2
        else:
            tails[joint] = heads[joint] + [0.0, 0.0, 5 * shortest]
    return tails
