"""Roles of a skeleton's joints, guessed from names and hierarchy.

Known namings: CMU and other BVH files, Mixamo, Rigify, Unreal, 3ds Max Biped, Unity/VRM, Character Creator.
"""

import re
from collections.abc import Sequence
from enum import Enum

import numpy as np

from .kinematics import ancestors


class JointRole(Enum):
    """Purpose of a joint; limbs come in a left and a right one."""

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


def guess_joint_roles(
    names: Sequence[str], parents: np.ndarray, heights: np.ndarray
) -> dict[tuple[JointRole, str], tuple[int, ...]]:
    """Guess joints by role and side: keys are (role, side) with side "left", "right" or "" for the trunk.

    ``names``, ``parents`` and rest ``heights`` (m) of J joints are as in a :class:`.skeleton.Skeleton`.

    The root is always joint 0. The hips are the joints below it down to where the thighs meet, if they do not
    meet at the root itself. Limb roles hold one joint, the first so named (so that twist bones do not
    count); the spine holds every joint so named below the root and above an upper arm. In a rig that has
    Rigify's deforming bones ("DEF-") limbs and spine are sought among those. Roles that no name speaks of are
    absent.
    """
    every = [_split_name(name) for name in names]
    deforming = any(name.startswith(_DEFORMING) for name in names)
    split = [
        own if name.startswith(_DEFORMING) or not deforming else ("", "")
        for name, own in zip(names, every, strict=True)
    ]
    roles: dict[tuple[JointRole, str], tuple[int, ...]] = {(JointRole.ROOT, ""): (0,)}
    for role, known in _LIMB_NAMES.items():
        for side in ("left", "right"):
            for core in known:
                if (side, core) in split[1:]:
                    roles[role, side] = (split.index((side, core), 1),)
                    break
    arms = [joints[0] for (role, _), joints in roles.items() if role is JointRole.UPPER_ARM]
    spine = [joint for joint, own in enumerate(split) if joint > 0 and own in _SPINE]
    spine = _below_arms(spine, arms, parents, heights)
    if spine:
        roles[JointRole.SPINE, ""] = spine
    thighs = [joints[0] for (role, _), joints in roles.items() if role is JointRole.THIGH]
    if len(thighs) == 2:
        above = (set(ancestors(parents, thigh)) for thigh in thighs)
        hips = tuple(sorted(set.intersection(*above) - {0, *thighs, *spine}))
        if hips:
            roles[JointRole.HIPS, ""] = hips
    if ("", "head") in every[1:]:
        roles[JointRole.HEAD, ""] = (every.index(("", "head"), 1),)
    return roles


def _split_name(name: str) -> tuple[str, str]:
    """Split a bone's name into side and core.

    >>> _split_name("mixamorig:LeftUpLeg"), _split_name("DEF-thigh.R")
    (('left', 'upleg'), ('right', 'thigh'))
    """
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


def _below_arms(spine: list[int], arms: list[int], parents: np.ndarray, heights: np.ndarray) -> tuple[int, ...]:
    """Those of the joints named spine that an arm hangs from; the others are the neck."""
    if not arms:
        return tuple(spine)
    above = {*arms}.union(*(ancestors(parents, arm) for arm in arms))
    # In generated rigs the arms hang from some mechanism: then only heights say what is below them.
    return tuple(joint for joint in spine if joint in above) or tuple(
        joint for joint in spine if heights[joint] <= heights[arms].max()
    )
