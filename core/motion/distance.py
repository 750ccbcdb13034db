"""The cost of switching from one frame of motion to another, for all pairs of frames."""

import math
from collections.abc import Generator, Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import ClipError
from ..progress import Progress
from . import quat
from .body_size import relative_size
from .clip import MotionClip
from .joint_roles import JointRole
from .skeleton import Skeleton

SAMPLED_FRAMES = 400
"""Frames that are compared with all others to estimate how many pairs there will be."""

BLOCK_ELEMENTS = 1 << 16
"""Pairs that are worked on at a time by the dense form: few enough for the processor's cache."""


_WEIGHTED_ROLES = (
    JointRole.HIPS,
    JointRole.SPINE,
    JointRole.THIGH,
    JointRole.SHIN,
    JointRole.UPPER_ARM,
    JointRole.LOWER_ARM,
)


_SAME_ANGLE, _SAME_HEIGHT = 0.02, 0.01
"""Radians and metres, at a person's size, up to which the last pose of a loop is its first."""

_STEADY = 1.5
"""How many times the largest change from one turn between frames to the next may occur at the seam of a loop."""


@dataclass(frozen=True)
class CostSettings:
    """Weights of what two frames are compared by.

    The cost is a sum of squares in rad^2; weights other than the joints' carry the unit that makes them so.

    Attributes
    ----------
    joint_weights : mapping of str to float, optional
        Weight of a bone's squared angle by bone name; bones not named keep the guessed weight (1 for root,
        spine, thighs, shins, upper and lower arms; 0 for the rest). The root's weight is that of its tilt.
    velocity_weight : float
        Weight (s^2) of squared differences of angular velocities, "nu" of Lee et al. 2002.
    height_weight : float
        Radians for each metre of difference in height of the root, or of the hips if they hang below it; for a
        character of a person's size, in proportion for others.
    travel_weight : float
        Radians for each m/s of difference in root velocity, seen from the heading; upwards that of the hips.
        Likewise in proportion.
    turn_weight : float
        Radians for each rad/s of difference in turn rate (seconds).
    """

    joint_weights: Mapping[str, float] | None = None
    velocity_weight: float = 0.02
    height_weight: float = 1.0
    travel_weight: float = 0.5
    turn_weight: float = 0.5


@dataclass(frozen=True)
class PoseFeatures:
    """Frames in the form in which they are compared; place and heading are left out.

    Attributes
    ----------
    rotations : (F, K, 4) float array
        Unit quaternions (w, x, y, z): the root's tilt (its heading removed), then the weighted joints'
        rotations.
    weights : (K,) float array
        Weight of each rotation's squared angle.
    vectors : (F, M) float array
        Everything that differs by subtraction, scaled so that the squared distance is its share of the cost:
        angular velocities of the same rotations, root height, root velocity in the heading frame, turn rate.
    """

    rotations: np.ndarray
    weights: np.ndarray
    vectors: np.ndarray

    @property
    def n_frames(self) -> int:
        return len(self.rotations)


def joint_weights(skeleton: Skeleton, by_name: Mapping[str, float] | None = None) -> np.ndarray:
    """Return the (J,) weight of each joint's angle in the transition cost; the root's entry weighs its tilt.

    Guessed unless ``by_name`` says otherwise: 1 for root, hips, spine, thighs, shins, upper and lower arms, 0 for
    the rest (Lee et al. 2002, section 4.1). If thighs and shins are not recognized by their names, every joint
    that has children weighs 1. ``by_name`` gives weights by bone name, replaces the guess for the bones that
    it names and raises ClipError for unknown bones and negative weights.
    """
    roles = skeleton.roles
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


def pose_features(clip: MotionClip, settings: CostSettings | None = None) -> PoseFeatures:
    """Return what of each frame of ``clip`` enters the transition cost.

    Angular velocities are local joint rotation differences per second, like all rates by central differences. Those go
    around the seam of a loop, a clip whose last pose is its first; at the ends of other clips they are one-sided, of
    second order as well. ClipError for bones that the skeleton lacks.
    """
    settings = settings or CostSettings()
    weights = joint_weights(clip.skeleton, settings.joint_weights)
    joints = np.flatnonzero(weights[1:]) + 1
    n_frames, rate, heading = clip.n_frames, clip.frame_rate, clip.ground_path[:, 2]

    tilt = quat.multiply(quat.about("z", -heading), clip.rotations[:, 0])
    rotations = quat.normalized(np.concatenate([tilt[:, None], clip.rotations[:, joints]], axis=1))
    weights = np.concatenate([weights[:1], weights[joints]])

    # Seen at a person's size.
    size = relative_size(clip.skeleton)
    height = _body_height(clip) / size

    between = quat.to_rotvec(quat.multiply(quat.inverse(rotations[:-1]), rotations[1:]))
    is_loop = _is_loop(rotations[:, weights > 0], height, between[:, weights > 0])
    angular = quat.to_rotvec(quat.multiply(quat.inverse(rotations[:-2]), rotations[2:])) / 2
    if is_loop:
        around = quat.to_rotvec(quat.multiply(quat.inverse(rotations[-2]), rotations[1])) / 2
        ends = around, around
    else:
        ends = _end_rates(between)
    angular = np.concatenate([ends[:1], angular, ends[1:]]) * rate
    angular *= np.sqrt(settings.velocity_weight * weights)[:, None]

    cos, sin = np.cos(heading), np.sin(heading)
    velocity = _rates(clip.translations[:, 0, :2] / size) * rate
    root = np.column_stack(
        [
            settings.travel_weight * (cos * velocity[:, 0] + sin * velocity[:, 1]),
            settings.travel_weight * (cos * velocity[:, 1] - sin * velocity[:, 0]),
            settings.travel_weight * _rates(height) * rate,
            settings.turn_weight * _rates(heading) * rate,
        ]
    )
    if is_loop:
        root[[0, -1]] = root[[0, -1]].mean(axis=0)
    return PoseFeatures(
        rotations,
        weights,
        np.column_stack([angular.reshape(n_frames, -1), settings.height_weight * height, root]),
    )


def _is_loop(rotations: np.ndarray, height: np.ndarray, between: np.ndarray) -> bool:
    """Return True if the last of (F, K, 4) rotations and (F,) heights (m) are the first ones again, and the motion goes
    on there: from the last of the (F - 1, K, 3) turns ``between`` frames to the first one not much more changes than
    between others.
    """
    if len(rotations) < 4:
        return False
    turned = quat.to_rotvec(quat.multiply(quat.inverse(rotations[0]), rotations[-1]))
    if np.linalg.norm(turned, axis=-1).max(initial=0.0) > _SAME_ANGLE or abs(height[-1] - height[0]) > _SAME_HEIGHT:
        return False
    changes = np.linalg.norm(np.diff(between, axis=0), axis=(1, 2))
    return bool(np.linalg.norm(between[0] - between[-1]) <= _STEADY * changes.max() + _SAME_ANGLE)


def _end_rates(between: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rates at the first and the last frame, by differences of second order, from those ``between`` frames,
    (F - 1, ...); of first order where there are but two frames."""
    inner = min(1, len(between) - 1)
    return 1.5 * between[0] - 0.5 * between[inner], 1.5 * between[-1] - 0.5 * between[-1 - inner]


def _rates(values: np.ndarray) -> np.ndarray:
    """Return the rate for each frame of (F, ...) values, by differences of second order."""
    return np.gradient(values, axis=0, edge_order=2 if len(values) > 2 else 1)


def _body_height(clip: MotionClip) -> np.ndarray:
    """(F,) height of the hips in metres: where the root is a bone on the ground, it knows nothing of it."""
    hips = clip.skeleton.hips
    return clip.world[1][:, hips, 2] if hips else clip.translations[:, 0, 2]


def joined(parts: list[PoseFeatures]) -> PoseFeatures:
    """Join the frames of several clips of one skeleton, one after the other."""
    return PoseFeatures(
        np.concatenate([part.rotations for part in parts]),
        parts[0].weights,
        np.concatenate([part.vectors for part in parts]),
    )


def pair_costs(features: PoseFeatures, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the (P,) float64 costs of switching between the frames (first[p], second[p]) of one set of features.

    ``D = sum_k w_k |log(q_bk^-1 q_ak)|^2 + nu sum_k w_k |omega_ak - omega_bk|^2 + root terms`` (rad^2), after Lee
    et al. 2002, section 4.1, with horizontal position and heading left out. Symmetric.
    """
    cosines = np.einsum("pkc,pkc->pk", features.rotations[first], features.rotations[second])
    difference = features.vectors[first] - features.vectors[second]
    return squared_angles(cosines) @ features.weights + np.einsum("pm,pm->p", difference, difference)


def close_pairs_steps(
    features: PoseFeatures, max_cost: float, classes: np.ndarray | None = None
) -> Generator[Progress, None, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Find all pairs of frames i < j of the same class whose cost is at most ``max_cost``.

    Returns i (P,), j (P,) and cost (P,) float64, class after class, sorted by i, then j. ``classes`` (F,) holds
    a label for every frame; all are of one class if it is not given.

    Only pairs are compared exactly that may be near enough: half the squared distance of two rotation
    matrices is 4 sin^2(angle / 2) <= angle^2, hence one matrix product bounds the cost of all pairs from
    below, and tightly so where the cost is small. Memory grows with the number of pairs found.
    """
    yield Progress(0.0, "Comparing frames")
    of_rows, of_columns = _bounding_factors(features)
    members = [np.arange(features.n_frames)]
    if classes is not None:
        members = [np.flatnonzero(classes == label) for label in np.unique(classes)]
    work, done = max(1, sum(len(own) ** 2 for own in members)), 0
    found = []
    for own in members:
        rows, columns = of_rows[own], of_columns[own]
        height = max(1, 32 * BLOCK_ELEMENTS // max(1, len(own)))
        for top in range(0, len(own), height):
            yield Progress((done + top * (2 * len(own) - top)) / work, "Comparing frames")
            block = rows[top : top + height] @ columns[top:].T
            first, second = np.nonzero(block >= -max_cost / 2)
            upper = second > first
            first, second = own[first[upper] + top], own[second[upper] + top]
            # In pieces, because every pair takes some kilobytes for the moment.
            for start in range(0, len(first), BLOCK_ELEMENTS // 2):
                piece = slice(start, start + BLOCK_ELEMENTS // 2)
                if start > 0:
                    yield Progress((done + top * (2 * len(own) - top)) / work, "Comparing frames")
                costs = pair_costs(features, first[piece], second[piece])
                near = costs <= max_cost
                found.append((first[piece][near], second[piece][near], costs[near]))
        done += len(own) ** 2
    if not found:
        return np.empty(0, np.intp), np.empty(0, np.intp), np.empty(0)
    i, j, costs = (np.concatenate(part) for part in zip(*found, strict=True))
    return i, j, costs


def expected_pairs(features: PoseFeatures, max_cost: float, classes: np.ndarray | None = None) -> float:
    """Estimate how many pairs :func:`close_pairs_steps` finds, from some hundred frames compared with all others.

    Rather too many than too few: by the bound that it sorts pairs out with.
    """
    of_rows, of_columns = _bounding_factors(features)
    chosen = np.arange(0, features.n_frames, math.ceil(features.n_frames / SAMPLED_FRAMES))
    n_pairs = -len(chosen)  # None is paired with itself.
    for some in np.array_split(chosen, math.ceil(len(chosen) / 64)):
        near = of_rows[some] @ of_columns.T >= -max_cost / 2
        if classes is not None:
            near &= classes[some][:, None] == classes
        n_pairs += np.count_nonzero(near)
    return n_pairs / len(chosen) * features.n_frames / 2


def _bounding_factors(features: PoseFeatures) -> tuple[np.ndarray, np.ndarray]:
    """(F, M) float32 of rows and of columns, whose product bounds minus half the cost of all pairs from above."""
    matrices = quat.to_matrix(features.rotations).reshape(features.n_frames, -1, 9)
    matrices *= np.sqrt(features.weights / 2)[:, None]
    points = np.concatenate([matrices.reshape(features.n_frames, -1), features.vectors], axis=1)
    points -= points.mean(axis=0)
    squares = np.einsum("fm,fm->f", points, points)
    # p.q - |p|^2 / 2 - |q|^2 / 2 = -|p - q|^2 / 2, all of it in one product of single precision. Its rounding
    # error is at most half of what the squares are lessened by, so that no pair is lost; those let through in
    # vain are sorted out below. (Higham, Accuracy and Stability of Numerical Algorithms, section 3.1)
    halves = -0.5 * squares * (1 - 2 * (points.shape[1] + 2) * np.finfo(np.float32).eps)
    ones = np.ones_like(squares)
    return (
        np.column_stack([points, ones, halves]).astype(np.float32),
        np.column_stack([points, halves, ones]).astype(np.float32),
    )


def squared_angles(cosines: np.ndarray) -> np.ndarray:
    """Return squared angles (rad^2) of the rotations between quaternions whose inner products are ``cosines``.

    ``(2 arccos |c|)^2`` as ``u h(u)`` with ``u = 1 - |c|``: the square is smooth where arccos itself is not, so a
    polynomial h is both faster and safe against rounding near equal rotations. Overwrites ``cosines``.

    >>> squared_angles(np.cos(np.array([0.0, 0.1, 0.5]))).round(6)  # half the angles
    array([0.  , 0.04, 1.  ])
    """
    u = np.abs(cosines, out=cosines)
    np.subtract(1, u, out=u)
    np.maximum(u, 0, out=u)
    coefficients = _ANGLE_POLYNOMIAL.astype(u.dtype)
    angles = np.full_like(u, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        angles *= u
        angles += coefficient
    angles *= u
    return angles


def _angle_polynomial(degree: int = 9) -> np.ndarray:
    """Coefficients, lowest first, of h(u) = (2 arccos(1 - u))^2 / u on [0, 1], to 1e-8."""

    def ratio(u):
        # 1 - u would lose u's digits; arccos(1 - u) = 2 arcsin(sqrt(u / 2)) does not.
        return (4 * np.arcsin(np.sqrt(u / 2))) ** 2 / u

    fit = np.polynomial.Chebyshev.interpolate(ratio, degree, domain=[0, 1])
    return fit.convert(kind=np.polynomial.Polynomial, domain=[-1, 1], window=[-1, 1]).coef


_ANGLE_POLYNOMIAL = _angle_polynomial()
