"""Joints of two skeletons that are the same part of a body: by their names, or by their roles."""

import re

import numpy as np

from ..errors import ClipError
from .bone_names import split_names
from .joint_roles import LEG, SIDES, JointRole
from .skeleton import Skeleton

_SHARED = 0.8
"""Share of the smaller skeleton's joints that two of one make have in common by name: ends of chains come and go."""


def by_names(own: Skeleton, other: Skeleton) -> np.ndarray | None:
    """Return (J,) the other's joint of the same name for each own one, -1 for none; None if these are no two of a make.

    A prefix before a colon says nothing, nor do capitals: "mixamorig1:Hips". The two are of one make if they share
    most names, and the shared joints hang from each other in the same way.
    """
    here, there = (_plain_names(skeleton) for skeleton in (own, other))
    if len(set(here)) < len(here) or len(set(there)) < len(there):
        here, there = own.names, other.names
    place = {name: joint for joint, name in enumerate(there)}
    result = np.array([place.get(name, -1) for name in here])
    shared = int(np.count_nonzero(result >= 0))
    if shared < _SHARED * min(own.n_joints, other.n_joints) or shared < 2:
        return None
    known = set(result[result >= 0].tolist())
    for joint in np.flatnonzero(result >= 0):
        above = next((int(result[a]) for a in own.ancestors(int(joint)) if result[a] >= 0), -1)
        if above != next((a for a in other.ancestors(int(result[joint])) if a in known), -1):
            return None
    return result


def by_roles(own: Skeleton, other: Skeleton) -> np.ndarray:
    """Return (J,) the other's joint of the same role for each own one, -1 for none.

    Hips, spine (however many joints it has), neck, head, collar bones, arms, hands, legs, feet and toes; below those
    also joints of the same name, such as fingers. ClipError if the legs of one of them are not known.
    """
    for skeleton in (own, other):
        missing = [f"{side} {role.value}" for role in LEG for side in SIDES if (role, side) not in skeleton.roles]
        if missing:
            raise ClipError(f"the {missing[0]} below '{skeleton.names[0]}' is not known.")
    here, there = _parts(own), _parts(other)
    result = np.full(own.n_joints, -1)
    for part in here.keys() & there.keys():
        result[here[part]] = there[part]
    _stretch(result, own, other, _spine(own), _spine(other))
    # What carries legs and trunk follows the hips, too.
    branch = 0
    while len(below := np.flatnonzero(np.asarray(own.parents) == branch)) == 1:
        branch = int(below[0])
    result[[branch, own.hips]] = other.hips
    _add_namesakes(result, own, other)
    return result


def leg_length(skeleton: Skeleton) -> float:
    """Return the metres of thigh and shin, on the average of both sides; 0 where they are not known."""
    lengths = []
    for side in SIDES:
        leg = [skeleton.roles.get((role, side), ()) for role in LEG]
        if not all(leg):
            return 0.0
        hip, knee, ankle = (skeleton.rest_world[1][joints[0]] for joints in leg)
        lengths.append(np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee))
    return float(np.mean(lengths))


def _plain_names(skeleton: Skeleton) -> list[str]:
    return [re.split(r"[:|]", name)[-1].lower() for name in skeleton.names]


def _parts(skeleton: Skeleton) -> dict[tuple[str, str], int]:
    """Return the joints that are one of a kind, by part and side."""
    roles = skeleton.roles
    parts = {
        (role.value, side): joints[0]
        for (role, side), joints in roles.items()
        if role not in (JointRole.ROOT, JointRole.HIPS, JointRole.SPINE)
    }
    trunk = {0, *roles.get((JointRole.HIPS, ""), ()), *roles.get((JointRole.SPINE, ""), ())}
    arms = [parts[JointRole.UPPER_ARM.value, side] for side in SIDES if (JointRole.UPPER_ARM.value, side) in parts]
    both_arms = set.intersection(*(set(skeleton.ancestors(arm)) for arm in arms)) if arms else set()
    for side in SIDES:
        arm = parts.get((JointRole.UPPER_ARM.value, side))
        above = int(skeleton.parents[arm]) if arm else -1
        if above >= 0 and above not in trunk | both_arms:
            parts["collar", side] = above
        hand = _hand(skeleton, parts.get((JointRole.LOWER_ARM.value, side)))
        if hand is not None:
            parts["hand", side] = hand
    head = parts.get((JointRole.HEAD.value, ""))
    if head is not None and int(skeleton.parents[head]) not in trunk | both_arms:
        parts["neck", ""] = int(skeleton.parents[head])
    return parts


def _hand(skeleton: Skeleton, forearm: int | None) -> int | None:
    if forearm is None:
        return None
    below = skeleton.descendants(forearm)
    cores = split_names(skeleton.names)
    named = [joint for joint in below if cores[joint][1] in ("hand", "wrist")]
    children = [joint for joint in below if skeleton.parents[joint] == forearm]
    return (named or sorted(children, key=lambda joint: -len(skeleton.descendants(joint))) or [None])[0]


def _spine(skeleton: Skeleton) -> list[int]:
    """List the joints of the spine, from below."""
    spine = skeleton.roles.get((JointRole.SPINE, ""), ())
    return sorted(spine, key=lambda joint: len(skeleton.ancestors(joint)))


def _stretch(result: np.ndarray, own: Skeleton, other: Skeleton, here: list[int], there: list[int]) -> None:
    """Give each joint of a spine the one that is as far up in the other: the last ones belong together."""
    for number, joint in enumerate(here if there else []):
        share = (number + 1) / len(here)
        result[joint] = there[max(round(share * len(there)) - 1, 0)]


def _add_namesakes(result: np.ndarray, own: Skeleton, other: Skeleton) -> None:
    names = {name: joint for joint, name in enumerate(_plain_names(other))}
    for joint, name in enumerate(_plain_names(own)):
        namesake, taken = names.get(name, -1), set(result.tolist())
        if result[joint] >= 0 or namesake < 0 or namesake in taken:
            continue
        above = next((int(result[a]) for a in own.ancestors(joint) if result[a] >= 0), -1)
        if above >= 0 and above == next((a for a in other.ancestors(namesake) if a in taken), -1):
            result[joint] = namesake
