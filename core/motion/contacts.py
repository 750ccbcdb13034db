"""Contacts: the frames in which the feet are on the ground."""

from dataclasses import dataclass

import numpy as np

from ..errors import ClipError
from .body_size import relative_size
from .clip import MotionClip
from .joint_roles import JointRole
from .skeleton import Skeleton

FLOOR_PERCENTILE = 5
"""A foot's floor is not its very lowest frame, which noise and landings push below where it stands."""

Feet = tuple[tuple[str, ...], tuple[str, ...]]
"""Bone names of the left and of the right foot, ankle first, then toes."""


@dataclass(frozen=True)
class ContactSettings:
    """Thresholds for a foot to count as planted: a joint of it is low and slow.

    A joint is planted from where it is below ``height`` and slower than ``speed``, and stays so until it
    rises above ``release_height`` or gets faster than ``release_speed``.

    Attributes
    ----------
    height, release_height : float
        Metres above where the same joint (ankle or toes) stands in this clip, for a character of a person's size;
        in proportion for others.
    speed, release_speed : float
        Metres per second, likewise.
    feet : pair of tuple of str, optional
        Bone names of the left and of the right foot, ankle first, then toes; guessed if not given.
    """

    height: float = 0.05
    release_height: float = 0.08
    speed: float = 0.45
    release_speed: float = 0.7
    feet: Feet | None = None

    def __post_init__(self):
        if not (0 < self.height <= self.release_height and 0 < self.speed <= self.release_speed):
            raise ClipError(
                "Planted Below and Slower Than must be positive, and not above Lifted Above and Faster Than."
            )


def foot_joints(skeleton: Skeleton, by_name: Feet | None = None) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Find the joints of the left and the right foot that may touch the ground: ankle, then toes where there are any.

    ``by_name`` names them; otherwise they are guessed from the names, and failing that taken to be the two
    lowest chains of the rest pose. ClipError if nothing says which they are.
    """
    if by_name is not None:
        left, right = (tuple(skeleton.index(name) for name in names) for names in by_name)
        if not left or not right:
            raise ClipError("The feet need at least one bone for each side.")
        return left, right
    left, right = (
        skeleton.roles.get((JointRole.FOOT, side), ()) + skeleton.roles.get((JointRole.TOES, side), ())
        for side in ("left", "right")
    )
    return (left, right) if left and right else _lowest_chains(skeleton)


def foot_contacts(clip: MotionClip, settings: ContactSettings | None = None) -> np.ndarray:
    """Find the frames in which the left and the right foot are planted: (F, 2) bool.

    A foot is planted while its ankle or its toes are. Heights count from the clip's own floor: the lowest
    that either foot's ankle (toes) gets, so that a foot held up is not taken for a standing one. ClipError if
    the skeleton has no feet that can be recognized.
    """
    return np.column_stack([planted.any(axis=1) for planted in joint_contacts(clip, settings)])


def joint_contacts(clip: MotionClip, settings: ContactSettings | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Find the planted joints of the left and of the right foot: an (F, n) bool array for each.

    Joints in the order of :func:`foot_joints`; see :func:`foot_contacts`.
    """
    settings = settings or ContactSettings()
    feet = foot_joints(clip.skeleton, settings.feet)
    # Seen at a person's size.
    positions = clip.world[1] / relative_size(clip.skeleton)
    low = [np.percentile(positions[:, list(foot), 2], FLOOR_PERCENTILE, axis=0) for foot in feet]
    n_shared = min(len(foot) for foot in feet)
    shared_floor = np.minimum(low[0][:n_shared], low[1][:n_shared])
    left, right = (np.zeros((clip.n_frames, len(foot)), dtype=bool) for foot in feet)
    for side, planted in enumerate((left, right)):
        for order, joint in enumerate(feet[side]):
            floor = shared_floor[order] if order < n_shared else low[side][order]
            height = positions[:, joint, 2] - floor
            speed = np.linalg.norm(np.gradient(positions[:, joint], axis=0), axis=1) * clip.frame_rate
            enter = (height <= settings.height) & (speed <= settings.speed)
            leave = (height > settings.release_height) | (speed > settings.release_speed)
            planted[:, order] = _latched(enter, leave)
    return left, right


def _latched(enter: np.ndarray, leave: np.ndarray) -> np.ndarray:
    """(F,) bool: frames at which ``enter`` was True later than ``leave``.

    What comes before the first of either is the opposite of it: a foot about to leave has been planted.
    """
    decided = np.flatnonzero(enter | leave)
    if len(decided) == 0:
        return np.zeros(len(enter), dtype=bool)
    latest = np.searchsorted(decided, np.arange(len(enter)), side="right") - 1
    return np.where(latest >= 0, enter[decided[np.maximum(latest, 0)]], leave[decided[0]])


def _lowest_chains(skeleton: Skeleton) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The two lowest leaves in the rest pose, each with its parent, that belong to different legs."""
    positions = skeleton.rest_world[1]
    height = positions[:, 2]
    leaves = np.setdiff1d(np.arange(1, skeleton.n_joints), skeleton.parents)
    leaves = leaves[np.argsort(height[leaves], kind="stable")]
    # Toes of one foot meet at its ankle, legs meet at the hips: the height of the meeting point
    # says which.
    ankle_height = height.min() + 0.25 * np.ptp(height)
    for other in leaves[1:]:
        meeting = next(joint for joint in skeleton.ancestors(other) if joint in skeleton.ancestors(leaves[0]))
        if height[meeting] > ankle_height:
            feet = [(int(skeleton.parents[leaf]), int(leaf)) for leaf in (leaves[0], other)]
            forward = skeleton.rest_forward
            side = [forward[0] * positions[foot[1], 1] - forward[1] * positions[foot[1], 0] for foot in feet]
            left, right = feet if side[0] >= side[1] else feet[::-1]
            return left, right
    raise ClipError(
        f"The feet of the skeleton rooted at '{skeleton.names[0]}' cannot be told from its bone names or its "
        "rest pose; choose Left Foot and Right Foot in the panel Contacts."
    )
