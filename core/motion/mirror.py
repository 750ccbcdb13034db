"""Clips seen in a mirror: every left turn is also a right turn."""

from dataclasses import replace

import numpy as np

from .. import wording
from ..errors import ClipError
from . import quat
from .clip import MotionClip
from .kinematics import local_transforms
from .skeleton import Skeleton

MIRRORED = " (mirrored)"
"""What is added to the name of a mirrored clip."""


def mirrored(clip: MotionClip, tolerance: float = 0.03) -> MotionClip:
    """Exchange left and right of a clip, walking along the mirror image of its path.

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
    other = skeleton.partners
    normal = mirror_normal(skeleton)
    _check_symmetry(clip, other, normal, tolerance)
    rest = skeleton.rest_world[0]

    # From the mirror image in the rest pose's plane of symmetry to that in the plane of the path.
    start = clip.ground_path[0]
    turn = 2 * (start[2] - (np.arctan2(normal[1], normal[0]) - np.pi / 2))
    turned = quat.about("z", turn)

    relative = quat.multiply(clip.world[0], quat.inverse(rest))
    world = quat.multiply(turned, quat.mirrored(relative[:, other], normal), rest)
    rotations, _ = local_transforms(world, clip.world[1], skeleton.parents)

    # Bones of slightly different length would slide if a joint took the other side's place.
    to_world = rest[np.maximum(skeleton.parents, 0)]
    moved = quat.rotate(to_world, clip.translations - skeleton.rest_translations)
    moved = quat.rotate(quat.inverse(to_world), quat.reflected(moved[:, other], normal))
    translations = skeleton.rest_translations + moved
    from_start = clip.translations[:, 0] - [start[0], start[1], 0.0]
    translations[:, 0] = quat.rotate(turned, quat.reflected(from_start, normal)) + [start[0], start[1], 0.0]

    return replace(
        clip,
        name=clip.name.removesuffix(MIRRORED) if clip.name.endswith(MIRRORED) else clip.name + MIRRORED,
        rotations=rotations,
        translations=translations,
        heading=None if clip.heading is None else 2 * clip.heading[0] - clip.heading,
    )


def mirror_normal(skeleton: Skeleton) -> np.ndarray:
    """Return the (3,) horizontal unit vector to the left in the rest pose; ClipError if forward is vertical."""
    forward = skeleton.rest_forward
    length = np.hypot(forward[0], forward[1])
    if length < 1e-3:
        raise ClipError(
            f"The forward axis of bone '{skeleton.names[0]}' points up or down in the rest pose, so that the "
            "character has no left and right; choose another forward axis."
        )
    return np.array([-forward[1], forward[0], 0.0]) / length


def asymmetry(skeleton: Skeleton) -> np.ndarray:
    """Return the (J,) metres between each joint of the rest pose and the mirror image of its partner, or of itself."""
    other, normal = skeleton.partners, mirror_normal(skeleton)
    positions = skeleton.rest_world[1]
    aside = positions @ normal
    middle = np.median((aside + aside[other]) / 2)
    centred = positions - middle * normal
    return np.linalg.norm(centred - quat.reflected(centred[other], normal), axis=1)


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
    if apart[worst] > tolerance * skeleton.stature:
        pair = f"bones '{names[worst]}' and '{names[other[worst]]}' are"
        subject = f"bone '{names[worst]}' is" if other[worst] == worst else pair
        raise ClipError(
            f"Clip '{clip.name}' cannot be mirrored: in the rest pose {subject} {wording.small(apart[worst])} from "
            "being symmetric; make the rest pose the same on both sides, or switch Mirror Clips off."
        )
