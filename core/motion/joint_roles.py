"""Which joint of a skeleton does what, guessed from names and hierarchy.

Known namings: CMU and other BVH files, Mixamo, Rigify, Unreal, 3ds Max Biped, Unity/VRM, Character Creator.
"""

import re
from collections.abc import Mapping
from enum import Enum

import numpy as np

from ..errors import ClipError
from . import quat
from .skeleton import Skeleton
from .stature import rest_world


class JointRole(Enum):
    """What a joint is for; limbs come in a left and a right one."""

    ROOT = "root"
    HIPS = "hips"
    SPINE = "spine"
    HEAD = "head"
    THIGH = "thigh"
    SHIN = "shin"
    FOOT = "foot"
    TOES = "toes"
    UPPER_ARM = "upper arm"
    LOWER_ARM = "lower arm"


# Names are compared in lower case without side, digits and separators.
_LIMB_NAMES = {
    JointRole.THIGH: ("thigh", "upleg", "upperleg", "hip"),
    JointRole.SHIN: ("shin", "calf", "lowerleg", "lowleg", "knee", "leg"),
    JointRole.FOOT: ("foot", "ankle"),
    JointRole.TOES: ("toe", "toes", "toebase", "ball"),
    JointRole.UPPER_ARM: ("upperarm", "uparm", "arm", "shoulder"),
    JointRole.LOWER_ARM: ("forearm", "lowerarm", "lowarm", "elbow"),
}
_SPINE = [("", name) for name in ("spine", "lowerback", "waist", "abdomen", "torso", "chest", "upperchest")]
# "shoulder" and "hip" mean the limb only where nothing says so more clearly: CMU's LeftShoulder is a collar
# bone.
_DECORATION = {"def", "bip", "j", "c", "b", "cc", "base", "mixamorig"}
_DEFORMING = "DEF-"
"""Rigify's prefix of the bones that move the mesh. Controls and mechanism bear the same names without it."""

_WEIGHTED_ROLES = (
    JointRole.HIPS,
    JointRole.SPINE,
    JointRole.THIGH,
    JointRole.SHIN,
    JointRole.UPPER_ARM,
    JointRole.LOWER_ARM,
)


def guess_joint_roles(skeleton: Skeleton) -> dict[tuple[JointRole, str], tuple[int, ...]]:
    """Joints by role and side: keys are (role, side) with side "left", "right" or "" for the trunk.

    The root is always joint 0. The hips are the joints below it down to where the thighs meet, if they do not
    meet at the root itself. Limb roles hold one joint, the first so named (so that twist bones do not
    count); the spine holds every joint so named below the root and above an upper arm. In a rig that has
    Rigify's deforming bones ("DEF-") limbs and spine are sought among those. Roles that no name speaks of are
    absent.
    """
    every = [_split_name(name) for name in skeleton.names]
    deforming = any(name.startswith(_DEFORMING) for name in skeleton.names)
    names = [
        split if name.startswith(_DEFORMING) or not deforming else ("", "")
        for name, split in zip(skeleton.names, every, strict=True)
    ]
    roles: dict[tuple[JointRole, str], tuple[int, ...]] = {(JointRole.ROOT, ""): (0,)}
    for role, known in _LIMB_NAMES.items():
        for side in ("left", "right"):
            for core in known:
                if (side, core) in names[1:]:
                    roles[role, side] = (names.index((side, core), 1),)
                    break
    arms = [joints[0] for (role, _), joints in roles.items() if role is JointRole.UPPER_ARM]
    spine = _below_arms(skeleton, [joint for joint, split in enumerate(names) if joint > 0 and split in _SPINE], arms)
    if spine:
        roles[JointRole.SPINE, ""] = spine
    thighs = [joints[0] for (role, _), joints in roles.items() if role is JointRole.THIGH]
    if len(thighs) == 2:
        shared = _ancestors(skeleton, thighs[0]) & _ancestors(skeleton, thighs[1])
        hips = tuple(sorted(shared - {0, *thighs, *spine}))
        if hips:
            roles[JointRole.HIPS, ""] = hips
    if ("", "head") in every[1:]:
        roles[JointRole.HEAD, ""] = (every.index(("", "head"), 1),)
    return roles


def hips_joint(skeleton: Skeleton) -> int:
    """The joint whose height is that of the body: where the thighs meet, or the root if there is no telling."""
    return guess_joint_roles(skeleton).get((JointRole.HIPS, ""), (0,))[-1]


def joint_weights(skeleton: Skeleton, by_name: Mapping[str, float] | None = None) -> np.ndarray:
    """(J,) weight of each joint's angle in the transition cost; the root's entry weighs its tilt.

    Guessed unless ``by_name`` says otherwise: 1 for root, hips, spine, thighs, shins, upper and lower arms, 0 for
    the rest (Lee et al. 2002, section 4.1). If thighs and shins cannot be told from the names, every joint
    that has children weighs 1. ``by_name`` gives weights by bone name, replaces the guess for the bones that
    it names and raises ClipError for unknown bones and negative weights.
    """
    roles = guess_joint_roles(skeleton)
    weights = np.zeros(skeleton.n_joints)
    legs = [(role, side) for role in (JointRole.THIGH, JointRole.SHIN) for side in ("left", "right")]
    if all(leg in roles for leg in legs):
        for (role, _), joints in roles.items():
            if role in _WEIGHTED_ROLES:
                weights[list(joints)] = 1.0
    else:
        weights[np.unique(skeleton.parents[1:])] = 1.0
    weights[0] = 1.0
    for name, weight in (by_name or {}).items():
        if not (np.isfinite(weight) and weight >= 0):
            raise ClipError(f"The weight of bone '{name}' is {weight}; it must be zero or more.")
        weights[skeleton.index(name)] = weight
    return weights


def foot_joints(
    skeleton: Skeleton, by_name: tuple[tuple[str, ...], tuple[str, ...]] | None = None
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Joints of the left and of the right foot that may touch the ground: ankle, then toes where there are
    any.

    ``by_name`` names them; otherwise they are guessed from the names, and failing that taken to be the two
    lowest chains of the rest pose. ClipError if there is no telling.
    """
    if by_name is not None:
        left, right = (tuple(skeleton.index(name) for name in names) for names in by_name)
        if not left or not right:
            raise ClipError("The feet need at least one bone for each side.")
        return left, right
    roles = guess_joint_roles(skeleton)
    feet = []
    for side in ("left", "right"):
        feet.append(roles.get((JointRole.FOOT, side), ()) + roles.get((JointRole.TOES, side), ()))
    if feet[0] and feet[1]:
        return feet[0], feet[1]
    return _lowest_chains(skeleton)


def _split_name(name: str) -> tuple[str, str]:
    """A bone's name as (side, core): "mixamorig:LeftUpLeg" -> ("left", "upleg")."""
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name.rsplit(":", 1)[-1])
    spaced = re.sub(r"^([LRlr])([A-Z])", r"\1 \2", spaced)
    words = [word.lower() for word in re.split(r"[^A-Za-z]+", spaced) if word]
    side = ""
    core = []
    for word in words:
        if word in ("left", "l") and not side:
            side = "left"
        elif word in ("right", "r") and not side:
            side = "right"
        else:
            core.append(word)
    if not side and core:
        # "leftupleg", written without any separator
        for prefix in ("left", "right"):
            if core[0].startswith(prefix) and len(core[0]) > len(prefix):
                side, core[0] = prefix, core[0].removeprefix(prefix)
    plain = [word for word in core if word not in _DECORATION]
    return side, "".join(plain)


def _ancestors(skeleton: Skeleton, joint: int) -> set[int]:
    """The joint and everything between it and the root, both included."""
    found = set()
    while joint >= 0:
        found.add(joint)
        joint = int(skeleton.parents[joint])
    return found


def _below_arms(skeleton: Skeleton, spine: list[int], arms: list[int]) -> tuple[int, ...]:
    """Those of the joints named ``spine`` that carry an arm; the others are the neck."""
    if not arms:
        return tuple(spine)
    carriers = set().union(*(_ancestors(skeleton, arm) for arm in arms))
    carrying = tuple(joint for joint in spine if joint in carriers)
    if carrying:
        return carrying
    # In generated rigs the arms hang from some mechanism; what carries them is told by its height then.
    height = rest_world(skeleton)[1][:, 2]
    return tuple(joint for joint in spine if height[joint] <= height[arms].max())


def _lowest_chains(skeleton: Skeleton) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The two lowest leaves in the rest pose, each with its parent, that belong to different legs."""
    rotations, positions = rest_world(skeleton)
    height = positions[:, 2]
    leaves = np.setdiff1d(np.arange(1, skeleton.n_joints), skeleton.parents)
    leaves = leaves[np.argsort(height[leaves], kind="stable")]
    # Toes of one foot meet at its ankle, legs meet at the hips: tell them apart by the height of the meeting
    # point.
    ankle_height = height.min() + 0.25 * np.ptp(height)
    for other in leaves[1:]:
        meeting = max(_ancestors(skeleton, leaves[0]) & _ancestors(skeleton, other))
        if height[meeting] > ankle_height:
            feet = [(int(skeleton.parents[leaf]), int(leaf)) for leaf in (leaves[0], other)]
            forward = quat.rotate(rotations[0], skeleton.forward)
            side = [forward[0] * positions[foot[1], 1] - forward[1] * positions[foot[1], 0] for foot in feet]
            left, right = feet if side[0] >= side[1] else feet[::-1]
            return left, right
    raise ClipError(
        f"The feet of the skeleton rooted at '{skeleton.names[0]}' cannot be told from its bone names or its "
        "rest pose; choose Left Foot and Right Foot in the panel Contacts."
    )
