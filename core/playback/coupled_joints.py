"""Joints that go with a leg without hanging from it: the controls of a rig, which its bones follow.

In a rig that moves by constraints, keys belong on controls: a foot's bone follows an IK control that hangs from
somewhere else. Such controls are known by what they do: they move with the thigh, the shin or the foot as if they were
one piece with it.
"""

from collections.abc import Sequence

import numpy as np

from ..motion import quat
from ..motion.kinematics import world_transforms
from ..motion.skeleton import Skeleton
from .two_bone import Leg

_N_SAMPLES = 60
_SAME_PLACE = 5e-3
"""Share of the stature, and radians / 10, that a coupled joint may stray by in most frames: blends move it a little."""
_MOST = 75
_MOVES = 0.05
"""Share of the stature, and radians / 10, that a joint must move by, as the hips see it, for coupled joints to be
known."""


def find_coupled_joints(
    skeleton: Skeleton, legs: Sequence[Leg], rotations: np.ndarray, positions: np.ndarray
) -> dict[int, int]:
    """Find the joints that are one piece with a joint of a leg, but neither hang from a leg nor carry one.

    Returns joint -> joint of the leg, from the world ``rotations`` (F, J, 4) and ``positions`` (F, J, 3) of a motion.
    Joints are compared on frames spread over all the poses of the leg, however seldom it moves; there are none for a
    leg that hardly does.
    """
    found: dict[int, int] = {}
    if skeleton.n_joints == 1:
        return found
    others = np.ones(skeleton.n_joints, dtype=bool)
    for leg in legs:
        others[[*skeleton.descendants(leg.thigh), leg.thigh, *skeleton.ancestors(leg.thigh)]] = False
    candidates, size, hips = np.flatnonzero(others), skeleton.stature, quat.inverse(rotations[:, 0])
    for leg in legs:
        for joint in (leg.foot, *skeleton.descendants(leg.foot), leg.shin, leg.thigh):
            # How far the joint travels and turns, as the hips see it.
            seen = quat.rotate(hips, positions[:, joint] - positions[:, 0])
            turned = quat.multiply(hips, rotations[:, joint])
            moved = np.linalg.norm(seen - seen[0], axis=1) / size + quat.angle_between(turned[0], turned) / 10
            if np.ptp(moved) < _MOVES:
                continue
            some = _spread_over(moved)
            inverse = quat.inverse(rotations[some, joint])
            for candidate in candidates:
                if candidate in found:
                    continue
                place = quat.rotate(inverse, positions[some, candidate] - positions[some, joint])
                strays = np.linalg.norm(place - np.median(place, axis=0), axis=1) / size
                if np.percentile(strays, _MOST) > _SAME_PLACE:
                    continue
                turn = quat.multiply(inverse, rotations[some, candidate])
                if np.percentile(quat.angle_between(quat.mean(turn), turn), _MOST) < 10 * _SAME_PLACE:
                    found[int(candidate)] = joint
    return found


def _spread_over(values: np.ndarray) -> np.ndarray:
    """Return up to ``_N_SAMPLES`` different frames whose (F,) values lie evenly between the least and the most.

    >>> _spread_over(np.array([0.0] * 1000 + [1.0, 2.0, 3.0])).tolist()
    [0, 1000, 1001, 1002]
    """
    order = np.argsort(values, kind="stable")
    levels = np.linspace(values.min(), values.max(), _N_SAMPLES)
    return np.unique(order[np.searchsorted(values[order], levels)])


def move_coupled_joints(
    coupled: dict[int, int],
    skeleton: Skeleton,
    old: tuple[np.ndarray, np.ndarray],
    rotations: np.ndarray,
    translations: np.ndarray,
    frames: np.ndarray,
) -> None:
    """Move coupled joints with those of the leg on some frames, in the new local ``rotations`` and ``translations``.

    ``old`` are the world rotations (F, J, 4) and positions (F, J, 3) of the motion before. What hangs from them
    goes with them.
    """
    if not coupled or len(frames) == 0:
        return
    old_rotations, old_positions = (array[frames] for array in old)
    new_rotations, new_positions = world_transforms(rotations[frames], translations[frames], skeleton.parents)
    changed = np.zeros(skeleton.n_joints, dtype=bool)
    for joint in range(1, skeleton.n_joints):
        parent = int(skeleton.parents[joint])
        carrier = new_rotations[:, parent]
        if joint in coupled:
            leader = coupled[joint]
            turn = quat.multiply(new_rotations[:, leader], quat.inverse(old_rotations[:, leader]))
            away = quat.rotate(turn, old_positions[:, joint] - old_positions[:, leader])
            new_positions[:, joint] = new_positions[:, leader] + away
            new_rotations[:, joint] = quat.multiply(turn, old_rotations[:, joint])
            back = quat.inverse(carrier)
            rotations[frames, joint] = quat.multiply(back, new_rotations[:, joint])
            translations[frames, joint] = quat.rotate(back, new_positions[:, joint] - new_positions[:, parent])
            changed[joint] = True
        elif changed[parent]:
            new_positions[:, joint] = new_positions[:, parent] + quat.rotate(carrier, translations[frames, joint])
            new_rotations[:, joint] = quat.multiply(carrier, rotations[frames, joint])
            changed[joint] = True
