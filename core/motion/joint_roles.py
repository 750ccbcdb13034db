"""Roles of a skeleton's joints: from their names in any dialect, or else from the shape of the rest pose."""

from collections.abc import Mapping, Sequence
from enum import Enum

import numpy as np

from .bone_names import split_names
from .kinematics import ancestors
from .limb_shapes import find_arms, find_legs


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


Roles = dict[tuple[JointRole, str], tuple[int, ...]]

SIDES = ("left", "right")
LEG = (JointRole.THIGH, JointRole.SHIN, JointRole.FOOT)
ARM = (JointRole.UPPER_ARM, JointRole.LOWER_ARM)

# Names are compared in lower case without side, digits and separators.
_LIMB_NAMES = {
    JointRole.THIGH: ("thigh", "upleg", "upperleg", "legupper", "femur", "hip"),
    JointRole.SHIN: ("shin", "calf", "lowerleg", "lowleg", "leglower", "knee", "leg"),
    JointRole.FOOT: ("foot", "ankle"),
    JointRole.TOES: ("toe", "toes", "toebase", "ball"),
    JointRole.UPPER_ARM: ("upperarm", "uparm", "armupper", "shldr", "arm", "shoulder"),
    JointRole.LOWER_ARM: ("forearm", "lowerarm", "lowarm", "armlower", "elbow"),
}
# "shoulder" and "hip" mean the limb only where nothing says so more clearly: CMU's LeftShoulder is a collar bone.
_SPINE = ("spine", "lowerback", "waist", "abdomen", "torso", "chest", "upperchest")
_SPINE_PARTS = {("", name + part) for name in _SPINE for part in ("", "lower", "upper")}
_DEFORMING = "DEF-"
"""Rigify's prefix of the bones that move the mesh. Controls and mechanism bear the same names without it."""


def guess_joint_roles(
    names: Sequence[str], parents: np.ndarray, positions: np.ndarray, left: np.ndarray | None = None
) -> Roles:
    """Guess joints by role and side: keys are (role, side) with side "left", "right" or "" for the trunk.

    ``names``, ``parents`` and rest ``positions`` (J, 3) in metres are as in a :class:`.skeleton.Skeleton`; ``left``
    (3,) is the direction to its left, where that is known.

    The root is always joint 0. The hips are the joints below it down to where the thighs meet, if they do not
    meet at the root itself. Limb roles hold one joint, the first so named (so that twist bones do not
    count); the spine holds every joint so named below the root and above an upper arm. In a rig that has
    Rigify's deforming bones ("DEF-") limbs and spine are sought among those. Limbs that no names speak of are those of
    :mod:`.limb_shapes`; roles that neither names nor shape speak of are absent.
    """
    split = split_names(names)
    body = _deforming_names(names, split)
    roles: Roles = {(JointRole.ROOT, ""): (0,)}
    roles.update(find_limbs(names, parents, positions, left, first=1))
    arms = [joints[0] for (role, _), joints in roles.items() if role is JointRole.UPPER_ARM]
    spine = [joint for joint, own in enumerate(body) if joint > 0 and own in _SPINE_PARTS]
    spine = _below_arms(spine, arms, parents, positions[:, 2])
    thighs = [joints[0] for (role, _), joints in roles.items() if role is JointRole.THIGH]
    shared = [set(ancestors(parents, thigh)) for thigh in thighs]
    if not spine and len(arms) == len(thighs) == 2:
        spine = _between_legs_and_arms(parents, thighs, arms)
    if spine:
        roles[JointRole.SPINE, ""] = spine
    if len(thighs) == 2:
        hips = tuple(sorted(set.intersection(*shared) - {0, *thighs, *spine}))
        if hips:
            roles[JointRole.HIPS, ""] = hips
    if ("", "head") in split[1:]:
        roles[JointRole.HEAD, ""] = (split.index(("", "head"), 1),)
    return roles


def find_limbs(
    names: Sequence[str], parents: np.ndarray, positions: np.ndarray, left: np.ndarray | None = None, first: int = 0
) -> Roles:
    """Find the joints of legs and arms in a tree or several, from joint ``first`` on; see :func:`guess_joint_roles`."""
    body = _deforming_names(names, split_names(names))
    sides = [side for side, _ in body]
    roles = _named_limbs(body, parents, first)
    if not _has(roles, LEG):
        legs = find_legs(parents, positions, sides, left)
        for side, joints in zip(SIDES, legs, strict=True) if legs else ():
            for role in (*LEG, JointRole.TOES):
                roles.pop((role, side), None)
            roles.update({(role, side): (joint,) for role, joint in zip((*LEG, JointRole.TOES), joints, strict=False)})
    if _has(roles, LEG) and not _has(roles, ARM):
        legs = [tuple(roles[role, side][0] for role in LEG) for side in SIDES]
        arms = find_arms(parents, positions, sides, *legs)
        for side, joints in zip(SIDES, arms, strict=True) if arms else ():
            roles.update({(role, side): (joint,) for role, joint in zip(ARM, joints, strict=False)})
    return roles


def _has(roles: Mapping, limb: Sequence[JointRole]) -> bool:
    return all((role, side) in roles for role in limb for side in SIDES)


def _deforming_names(names: Sequence[str], split: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Blank out what is not to be taken for a part of the body, in a rig that marks those that are."""
    if not any(name.startswith(_DEFORMING) for name in names):
        return split
    return [own if name.startswith(_DEFORMING) else ("", "") for name, own in zip(names, split, strict=True)]


def _named_limbs(split: list[tuple[str, str]], parents: np.ndarray, first: int) -> Roles:
    roles: Roles = {}
    places: dict[tuple[str, str], int] = {}
    for joint in range(len(split) - 1, first - 1, -1):
        places[split[joint]] = joint
    for side in SIDES:
        above = -1  # the joint of the same limb that was found last
        for role, known in _LIMB_NAMES.items():
            if role is JointRole.UPPER_ARM:
                above = -1
            named = [places[side, core] for core in known if (side, core) in places]
            # "knee" may be a pole of the shin that is called "leg".
            hanging = [joint for joint in named if above in ancestors(parents, joint)]
            if named:
                above = (hanging or named)[0]
                roles[role, side] = (above,)
        _correct_leg(roles, side, places, parents)
    return roles


def _correct_leg(roles: Roles, side: str, places: Mapping[tuple[str, str], int], parents: np.ndarray) -> None:
    """Sort out the words that mean one joint in one dialect and its neighbour in another."""
    leg, shin = places.get((side, "leg"), -1), roles.get((JointRole.SHIN, side), (-1,))[0]
    named = roles.get((JointRole.THIGH, side), (-1,))[0]
    if leg >= 0 and shin >= 0 and leg in ancestors(parents, shin) and named not in ancestors(parents, leg):
        # leg, knee, ankle, maybe below a hip that is no thigh but a part of the pelvis
        roles[JointRole.THIGH, side] = (leg,)
    ankle, foot = places.get((side, "ankle"), -1), roles.get((JointRole.FOOT, side), (-1,))[0]
    if ankle >= 0 and ankle in ancestors(parents, foot):
        roles[JointRole.FOOT, side] = (ankle,)
        roles.setdefault((JointRole.TOES, side), (foot,))
    toes = roles.get((JointRole.TOES, side), (-1,))[0]
    for core in _LIMB_NAMES[JointRole.TOES] if toes >= 0 else ():
        # Of ball and toe it is the ball that bends.
        if places.get((side, core), -1) in ancestors(parents, toes):
            roles[JointRole.TOES, side] = (places[side, core],)


def _between_legs_and_arms(parents: np.ndarray, thighs: list[int], arms: list[int]) -> tuple[int, ...]:
    """The joints above both arms that are not above both legs, the joint 0 left out."""
    legs, both = (set.intersection(*(set(ancestors(parents, joint)) for joint in pair)) for pair in (thighs, arms))
    return tuple(sorted(both - legs - {0}))


def _below_arms(spine: list[int], arms: list[int], parents: np.ndarray, heights: np.ndarray) -> tuple[int, ...]:
    """Those of the joints named spine that an arm hangs from; the others are the neck."""
    if not arms:
        return tuple(spine)
    above = {*arms}.union(*(ancestors(parents, arm) for arm in arms))
    # In generated rigs the arms hang from some mechanism: then only heights say what is below them.
    return tuple(joint for joint in spine if joint in above) or tuple(
        joint for joint in spine if heights[joint] <= heights[arms].max()
    )
