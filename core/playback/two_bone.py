"""Two-bone legs: which joints they are, and how they reach for another place without turning their knee's plane."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..motion import quat
from ..motion.joint_roles import JointRole
from ..motion.limb import limb_frames
from ..motion.skeleton import Skeleton

_APART = 1e-2
"""Share of the stature: joints nearer to each other in the rest pose make no bone of a leg."""
_LEAST_BEND = 0.05
"""Sine of the knee's bend below which the leg's own hinge takes over from the plane in which it happens to lie."""


@dataclass(frozen=True)
class Leg:
    """The joints of a leg: thigh (at the hip), shin (at the knee) and foot (at the ankle), each above the next.

    There may be joints between them, twist bones for instance, which keep their place in the thigh or in the shin.
    """

    thigh: int
    shin: int
    foot: int


def find_leg(skeleton: Skeleton, side: int, feet: Sequence[Sequence[int]]) -> Leg | str:
    """Find the leg of a foot, or a sentence that says why there is none.

    ``feet`` holds the joints of the left and of the right foot, ankle first. Thigh and shin are those so named, if the
    foot hangs from joints so named; else they are the next two joints above the ankle that lie apart from it and
    from each other, and do not carry the other foot.
    """
    foot, other = feet[side][0], feet[1 - side][0]
    above, shared = skeleton.ancestors(foot), set(skeleton.ancestors(other))
    named = [
        skeleton.roles.get((role, ("left", "right")[side]), (-1,))[0] for role in (JointRole.THIGH, JointRole.SHIN)
    ]
    positions, least = skeleton.rest_world[1], _APART * skeleton.stature

    def apart(a: int, b: int) -> bool:
        return bool(np.linalg.norm(positions[a] - positions[b]) > least)

    thigh, shin = named
    if not (thigh in above and shin in above[: above.index(thigh)] and apart(thigh, shin) and apart(shin, foot)):
        own = [joint for joint in above if joint not in shared]
        shin = next((joint for joint in own if apart(joint, foot)), -1)
        upper = own[own.index(shin) + 1 :] if shin >= 0 else []
        # Of several joints at one place it is the uppermost that turns what lies below.
        shin = next((joint for joint in reversed(upper) if not apart(joint, shin)), shin)
        upper = own[own.index(shin) + 1 :] if shin >= 0 else []
        thigh = next((joint for joint in upper if apart(joint, shin)), -1)
        thigh = next((joint for joint in reversed(upper) if thigh >= 0 and not apart(joint, thigh)), thigh)
    if thigh < 0 or shin < 0:
        return (
            f"The foot '{skeleton.names[foot]}' does not hang from a thigh and a shin, so that it cannot be held in "
            "place; choose the bones of the feet below a leg of two bones."
        )
    return Leg(thigh, shin, foot)


def leg_turns(
    leg: Leg, rotations: np.ndarray, positions: np.ndarray, hips_move: np.ndarray, foot_move: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return (F, 4), (F, 4) rotations in the world that thigh and shin turn by, so that the foot gets there.

    The plane of the knee turns with the line from hip to ankle, the least that it can. A leg that neither end moves
    of is not turned at all; one that its target is out of reach for points at it.

    Parameters
    ----------
    rotations, positions : (F, J, 4) and (F, J, 3) float arrays
        The joints in the world.
    hips_move, foot_move : (F, 3) float arrays
        Metres that the hip is moved by, and that the ankle shall be.
    """
    hip, knee, ankle = (positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    upper, lower = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    hinge = _hinge(leg, rotations, positions)
    old = limb_frames(hip, ankle, hinge, upper, lower)
    start, target = hip + hips_move, ankle + foot_move
    new_hinge = quat.rotate(quat.between(ankle - hip, target - start), hinge)
    # The hinge of a nearly straight leg is not quite at right angles to it: what that misses is aimed for anew.
    aim = target
    for _ in range(3):
        new = limb_frames(start, aim, new_hinge, upper, lower)
        thigh, shin = (quat.multiply(after, quat.inverse(before)) for after, before in zip(new, old, strict=True))
        reached = start + quat.rotate(thigh, knee - hip) + quat.rotate(shin, ankle - knee)
        aim = np.where(_within(start, target, upper, lower)[:, None], aim + target - reached, aim)
    still = (np.abs(hips_move) + np.abs(foot_move)).max(axis=1) == 0
    thigh[still] = shin[still] = quat.IDENTITY
    return thigh, shin


def _within(start: np.ndarray, target: np.ndarray, upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
    distance = np.linalg.norm(target - start, axis=1)
    return (distance < 0.99999 * (upper + lower)) & (distance > 1.001 * np.abs(upper - lower))


def _hinge(leg: Leg, rotations: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return (F, 3) unit axes in the world that the knee bends about.

    At right angles to thigh and shin, unless the leg is straight or bent the wrong way: then the axis that it usually
    bends about, fixed to the thigh, decides.
    """
    along_thigh, along_shin = (
        vector / np.linalg.norm(vector, axis=1, keepdims=True)
        for vector in (
            positions[:, leg.shin] - positions[:, leg.thigh],
            positions[:, leg.foot] - positions[:, leg.shin],
        )
    )
    normal = np.cross(along_thigh, along_shin)
    thigh = rotations[:, leg.thigh]
    usual = quat.rotate(quat.inverse(thigh), normal).sum(axis=0)
    if np.linalg.norm(usual) < 1e-3 * len(normal):
        # It never bends: any axis across the thigh will do, as long as it turns with it.
        axis = quat.rotate(quat.inverse(thigh[0]), along_thigh[0])
        usual = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    usual = quat.rotate(thigh, usual / np.linalg.norm(usual))
    bend = np.sum(normal * usual, axis=1, keepdims=True)
    axis = normal + np.maximum(_LEAST_BEND - bend, 0.0) * usual
    return -axis / np.linalg.norm(axis, axis=1, keepdims=True)
