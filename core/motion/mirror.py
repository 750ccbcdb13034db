"""Clips seen in a mirror: every left turn is also a right turn."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from .. import wording
from ..errors import ClipError
from .clip import MotionClip
from .kinematics import as_quaternions, as_rotation
from .sides import partners
from .skeleton import Skeleton
from .stature import rest_world, stature

MIRRORED = " (mirrored)"
"""What is added to the name of a mirrored clip."""


def mirrored(clip: MotionClip, tolerance: float = 0.03) -> MotionClip:
    """The clip with left and right exchanged, walking along the mirror image of its path.

    The mirror of the path is the vertical plane through its start along its starting heading; that of the pose is
    the character's own plane of symmetry. With D the world rotation of a joint relative to its rest orientation and
    M the mirror, D' = M D M of the joint of the other side: bone rolls do not matter. Bones keep their own lengths;
    what joints move relative to the rest pose is mirrored too. Tags are kept, and " (mirrored)" is added to the name
    or taken away: mirrored twice is the clip itself.

    Parameters
    ----------
    clip : MotionClip
    tolerance : float
        By how much the two sides of the rest pose may differ, as a share of the character's stature.

    Raises ClipError, naming the bones, if no two bones are a left and a right one, or if the rest pose or the
    hierarchy is not the same on both sides.
    """
    skeleton = clip.skeleton
    other = partners(skeleton)
    normal = mirror_normal(skeleton)
    _check_symmetry(clip, other, normal, tolerance)
    rest = rest_world(skeleton)[0]
    n_frames, n_joints = clip.rotations.shape[:2]

    # From the mirror image in the rest pose's plane of symmetry to that in the plane of the path.
    start = clip.ground_path[0]
    turn = 2 * (start[2] - (np.arctan2(normal[1], normal[0]) - np.pi / 2))
    turned = Rotation.from_rotvec([0.0, 0.0, turn])

    every_rest = as_rotation(np.tile(rest, (n_frames, 1)))
    relative = as_quaternions(as_rotation(clip.world[0]) * every_rest.inv(), (n_frames, n_joints))
    world = turned * as_rotation(_reflected_rotations(relative[:, other], normal)) * every_rest
    rotations = as_quaternions(world, (n_frames, n_joints)).copy()
    parents = np.maximum(skeleton.parents, 0)
    local = as_rotation(rotations[:, parents[1:]]).inv() * as_rotation(rotations[:, 1:])
    rotations[:, 1:] = as_quaternions(local, (n_frames, n_joints - 1))

    # Bones of slightly different length would slide if a joint took the other side's place.
    moved = clip.translations - skeleton.rest_translations
    to_world = [as_rotation(rest[parent]) for parent in parents]
    translations = np.empty_like(moved)
    for joint in range(1, n_joints):
        offset = _reflected(to_world[other[joint]].apply(moved[:, other[joint]]), normal)
        translations[:, joint] = skeleton.rest_translations[joint] + to_world[joint].inv().apply(offset)
    from_start = clip.translations[:, 0] - [start[0], start[1], 0.0]
    translations[:, 0] = turned.apply(_reflected(from_start, normal)) + [start[0], start[1], 0.0]

    return replace(
        clip,
        name=clip.name.removesuffix(MIRRORED) if clip.name.endswith(MIRRORED) else clip.name + MIRRORED,
        rotations=rotations,
        translations=translations,
        heading=None if clip.heading is None else 2 * clip.heading[0] - clip.heading,
    )


def mirror_normal(skeleton: Skeleton) -> np.ndarray:
    """(3,) unit vector to the character's left in its rest pose, horizontal; ClipError if forward is vertical."""
    forward = as_rotation(skeleton.rest_rotations[:1]).apply(skeleton.forward)[0]
    length = np.hypot(forward[0], forward[1])
    if length < 1e-3:
        raise ClipError(
            f"The forward axis of bone '{skeleton.names[0]}' points up or down in the rest pose, so that the "
            "character has no left and right; choose another forward axis."
        )
    return np.array([-forward[1], forward[0], 0.0]) / length


def asymmetry(skeleton: Skeleton) -> np.ndarray:
    """(J,) metres between each joint of the rest pose and the mirror image of its partner, or of itself."""
    other, normal = partners(skeleton), mirror_normal(skeleton)
    positions = rest_world(skeleton)[1]
    aside = positions @ normal
    middle = np.median((aside + aside[other]) / 2)
    centred = positions - middle * normal
    return np.linalg.norm(centred - _reflected(centred[other], normal), axis=1)


def _check_symmetry(clip: MotionClip, other: np.ndarray, normal: np.ndarray, tolerance: float) -> None:
    skeleton = clip.skeleton
    names, every = skeleton.names, np.arange(skeleton.n_joints)
    if np.array_equal(other, every):
        raise ClipError(
            f"Clip '{clip.name}' cannot be mirrored: no two bones of its skeleton are named as left and right of the "
            "same; name them like 'thigh.L' and 'thigh.R', or switch Mirror "
            "Clips off."
        )
    parents = skeleton.parents
    for joint in range(1, skeleton.n_joints):
        if parents[other[joint]] != other[parents[joint]]:
            raise ClipError(
                f"Clip '{clip.name}' cannot be mirrored: bones '{names[joint]}' and '{names[other[joint]]}' do not "
                "hang from the same bone or a left and a right one; make the hierarchy the same on both sides, "
                "or switch Mirror Clips off."
            )
    apart = asymmetry(skeleton)
    worst = int(np.argmax(apart))
    if apart[worst] > tolerance * stature(skeleton):
        pair = f"bones '{names[worst]}' and '{names[other[worst]]}' are"
        subject = f"bone '{names[worst]}' is" if other[worst] == worst else pair
        raise ClipError(
            f"Clip '{clip.name}' cannot be mirrored: in the rest pose {subject} {wording.small(apart[worst])} from "
            "being symmetric; make the rest pose the same on both sides, or switch Mirror Clips off."
        )


def _reflected(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(..., 3) vectors reflected in the plane through the origin with the given unit normal."""
    return vectors - 2 * (vectors @ normal)[..., None] * normal


def _reflected_rotations(quaternions: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(..., 4) rotations M R M: the axis is mirrored, and turned the other way round."""
    return np.concatenate([quaternions[..., :1], -_reflected(quaternions[..., 1:], normal)], axis=-1)
