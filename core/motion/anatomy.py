"""The body as a whole, understood from the rest pose of a rig: what carries it, and where it faces."""

from collections.abc import Sequence

import numpy as np

from .joint_roles import ARM, LEG, SIDES, JointRole, Roles, find_limbs
from .kinematics import ancestors, descendants
from .limb_shapes import toes_direction
from .sides import mirrored_pairs

_UP = np.array([0.0, 0.0, 1.0])
_LEG_WORDS = ("thigh", "leg", "hip", "femur", "shin", "calf", "knee", "foot", "ankle")
_MOST_STEPS = 2
"""Joints between the legs' own joint and the one that carries trunk and legs, at most: MMD's lower body is one."""
_ON_GROUND = 0.25
"""Share of the height below which a joint at rest is a place on the ground, not a part of the body."""


def find_body_root(names: Sequence[str], parents: np.ndarray, positions: np.ndarray, deforming: np.ndarray) -> int:
    """Return the joint that carries the body: where legs and trunk meet, whatever there is above it.

    On a rig that has no legs it is the parentless joint with the most deforming ones below it.

    Parameters
    ----------
    names : sequence of str
    parents, positions, deforming : (J,) int, (J, 3) float, (J,) bool array
        One or several trees; where the joints rest in the world, in metres; those that move the mesh.
    """
    limbs = find_limbs(names, parents, positions)
    pairs = [
        (limbs[role, "left"][0], limbs[role, "right"][0]) for role in LEG if all((role, s) in limbs for s in SIDES)
    ]
    pairs = pairs[:1] or _leg_pairs(names, deforming)
    meeting = [
        (len(ancestors(parents, pair[0])), joint) for pair in pairs if (joint := _meeting_point(parents, *pair)) >= 0
    ]
    if meeting:
        return _with_trunk(min(meeting)[1], limbs, parents, positions)
    tops = np.flatnonzero(parents < 0)
    sizes = [np.count_nonzero(deforming[[top, *descendants(parents, int(top))]]) for top in tops]
    return int(tops[np.argmax(sizes)])


def find_facing(names: Sequence[str], parents: np.ndarray, positions: np.ndarray) -> np.ndarray | None:
    """Return the (3,) unit direction in which a rest pose faces; None if neither names nor shape say so.

    Where the feet point, if they do. Else left x up, with the left from the legs or another left and right pair of
    joints; up is that of the body, if it lies at rest.
    """
    size = float(np.ptp(positions, axis=0).max())
    limbs = find_limbs(names, parents, positions)
    legs = [tuple(limbs[role, side][0] for role in (*LEG, JointRole.TOES) if (role, side) in limbs) for side in SIDES]
    up, toes = _UP, None
    if all(len(leg) >= 3 for leg in legs):
        along = np.sum([positions[leg[0]] - positions[leg[2]] for leg in legs], axis=0)
        length = np.linalg.norm(along)
        if length > 0.2 * size and abs(along[2]) < 0.5 * length:
            up = along / length
        elif along[2] > 0:
            toes = toes_direction(positions, legs)
    pairs = list(zip(*legs, strict=False))
    pairs += [tuple(limbs[role, side][0] for side in SIDES) for role in ARM if all((role, s) in limbs for s in SIDES)]
    named = [(names.index(left), names.index(right)) for left, right in mirrored_pairs(names)]
    named.sort(key=lambda pair: (not _is_leg(names[pair[0]]), len(ancestors(parents, pair[0]))))
    for left, right in (*pairs, *named):
        direction = np.cross(positions[left] - positions[right], up)
        if np.linalg.norm(direction) > 0.01 * size:
            direction = direction / np.linalg.norm(direction)
            # Feet turn out: they say roughly where the line through both legs says exactly.
            if toes is None or direction @ toes > 0.5:
                return direction
            return toes if direction @ toes > -0.5 else -direction
    return toes


def _with_trunk(root: int, limbs: Roles, parents: np.ndarray, positions: np.ndarray) -> int:
    """Return the joint near above ``root`` that carries the trunk as well, if there is one that is off the ground."""
    arms = [limbs[role, side][0] for role in ARM[:1] for side in SIDES if (role, side) in limbs]
    above = [root, *ancestors(parents, root)][: _MOST_STEPS + 1]
    heights = positions[:, 2]
    floor = heights.min() + _ON_GROUND * np.ptp(heights)
    for joint in above:
        if arms and all(joint in ancestors(parents, arm) for arm in arms):
            return joint if heights[joint] > floor else root
    return root


def _leg_pairs(names: Sequence[str], deforming: np.ndarray) -> list[tuple[int, int]]:
    """Index pairs of joints whose names speak of a left and a right leg, those that deform if any does."""
    pairs = [(names.index(left), names.index(right)) for left, right in mirrored_pairs(names) if _is_leg(left)]
    return [pair for pair in pairs if deforming[pair[0]]] or pairs


def _is_leg(name: str) -> bool:
    """Test whether a name is that of a leg's bone, and not of an IK control or a pole, which hang from anywhere."""
    words = "".join(letter if letter.isalnum() else "_" for letter in name)
    lowered = words.lower()
    is_control = "ik" in lowered.split("_") or "pole" in lowered or "IK" in words
    return any(word in lowered for word in _LEG_WORDS) and not is_control


def _meeting_point(parents: np.ndarray, left: int, right: int) -> int:
    """The nearest common ancestor, -1 if there is none."""
    above = set(ancestors(parents, right))
    return next((ancestor for ancestor in ancestors(parents, left) if ancestor in above), -1)
