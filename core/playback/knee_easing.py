"""Knees that do not snap: where a leg is nearly straight, its foot gives way a little.

A nearly straight leg turns its knee by many degrees for a few millimetres that its foot is moved along it. Moves that
hold feet in place are therefore corrected: the bend of each knee stays as near as possible to what they ask for, while
its acceleration gets no larger than it is anyway in the motion.
"""

import numpy as np
from scipy.linalg import solveh_banded

from .two_bone import Leg

_USUAL = 99.5
"""Percentile of the accelerations of the knee in the motion that count as its own everywhere."""
_UNSEEN = 100.0
"""Radians per square second that nobody notices."""
_FREE = 0.02
"""Weight of a place in the air, beside that of a place on the ground."""
_LEAST_LEVER = 0.17
"""Sine of the bend below which the foot counts as moving with it all the same: 10 degrees."""
_HELD = 1e6
"""Weight of a place that nothing moves."""
_ROUNDS = 24
_STIFFNESS = 0.3
"""Square metres for the square of a radian per frame and frame: weight of accelerations beside places."""


def eased_foot_move(
    leg: Leg,
    positions: np.ndarray,
    hips_move: np.ndarray,
    foot_move: np.ndarray,
    planted: np.ndarray,
    frame_rate: float,
) -> np.ndarray:
    """Return (F, 3) metres to move a foot by, so that its knee is not accelerated more than it is in the motion.

    The foot leaves its ``foot_move`` towards the hip or away from it, only near frames where the knee would snap.
    Frames that nothing is moved in stay as they are, and so do steps that the foot is lifted for.

    Parameters
    ----------
    positions : (F, J, 3) float array
        The joints in the world.
    hips_move, foot_move : (F, 3) float arrays
        Metres that the hip is moved by, and that the ankle is to be.
    planted : (F,) bool array
        Where the foot is on the ground.
    """
    hip, knee, ankle = (positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    upper, lower = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    away = ankle + foot_move - hip - hips_move
    reach = np.linalg.norm(away, axis=1)
    own, asked = (_bend(upper, lower, distance) for distance in (np.linalg.norm(ankle - hip, axis=1), reach))
    moved = np.any(foot_move != 0, axis=1) | np.any(hips_move != 0, axis=1)
    accelerated = np.abs(np.diff(own, 2))
    allowed = np.maximum(accelerated, np.percentile(accelerated, _USUAL) if len(accelerated) else 0.0)
    allowed = np.maximum(allowed, _UNSEEN / frame_rate**2)
    # A step lifts its foot as high and as quickly as it has to.
    lifted = foot_move[:, 2] > 0
    allowed[lifted[:-2] | lifted[1:-1] | lifted[2:]] = np.inf
    # What the foot moves by for each radian that the knee bends, weighed.
    lever = upper * lower / np.maximum(reach, 1e-9) * np.maximum(np.sin(asked), _LEAST_LEVER)
    place = np.where(moved, np.where(planted, 1.0, _FREE) * lever**2, _HELD)
    bend = _eased(asked, place, allowed)
    length = np.sqrt(upper**2 + lower**2 + 2 * upper * lower * np.cos(bend))
    eased = moved & (np.abs(bend - asked) > 1e-6)
    gives = np.where(eased, length / np.maximum(reach, 1e-9) - 1, 0.0)
    return foot_move + gives[:, None] * away


def _bend(upper: np.ndarray, lower: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return (F,) radians that a knee is bent by: 0 for a straight leg."""
    return np.arccos(np.clip((reach**2 - upper**2 - lower**2) / (2 * upper * lower), -1.0, 1.0))


def _eased(asked: np.ndarray, place: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Return (F,) radians of bend near to those ``asked`` for, whose second differences do not exceed what is allowed.

    Least squares: misses, weighed by ``place`` (F,), and what accelerations exceed ``allowed`` (F - 2,) by are weighed
    against each other anew in every round, until nothing exceeds it.
    """
    bend, stiff = asked, np.zeros(len(allowed))
    for _ in range(_ROUNDS):
        excess = np.abs(np.diff(bend, 2)) > 1.001 * allowed
        if not excess.any():
            break
        stiff += _STIFFNESS * excess
        wanted = np.clip(np.diff(bend, 2), -allowed, allowed)
        bend = asked + _least_squares(place, stiff, wanted - np.diff(asked, 2))
        # No knee bends the other way.
        place = np.where(bend < 0, 2 * place, place)
    return np.maximum(bend, 0.0)


def _least_squares(place: np.ndarray, stiff: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return (F,) x with the least ``sum place x^2 + sum stiff (second differences of x - wanted)^2``."""
    n = len(place)
    bands = np.zeros((3, n))
    bands[2] = place
    for a, ca in enumerate((1.0, -2.0, 1.0)):
        for b, cb in enumerate((1.0, -2.0, 1.0)):
            if b >= a:
                bands[2 - (b - a), b : n - 2 + b] += ca * cb * stiff
    right = np.zeros(n)
    for a, ca in enumerate((1.0, -2.0, 1.0)):
        right[a : n - 2 + a] += ca * stiff * wanted
    return np.asarray(solveh_banded(bands, right))
