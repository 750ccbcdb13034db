"""Motion of one skeleton on another: rest poses, sizes and names may differ.

Both skeletons are brought into the same pose, the source's rest pose; from there each bone turns in the world as its
counterpart does, and the way gets longer with the legs.
"""

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..progress import Progress
from . import quat
from .clip import MotionClip
from .counterparts import by_names, by_roles, leg_length
from .joint_roles import LEG, SIDES, JointRole
from .kinematics import world_transforms
from .skeleton import Skeleton

_SAME_DIRECTION = np.radians(25)  # of bones in their joints' axes: actors differ by less, rest poses by more
_NEARLY_SAME_REST = np.radians(40)  # beside their parents: axes that differ do so by right angles
_BLOCK = 100_000  # joints times frames that are worked on at a time
_LIMBS = (JointRole.THIGH, JointRole.SHIN, JointRole.UPPER_ARM, JointRole.LOWER_ARM)
_USUAL_ANKLE, _ALIKE = 0.1, 0.2
"""Height of the ankles of someone who stands, and how much that may differ, as parts of the legs' length."""
_AWAY = 0.3
"""Statures from the world's origin from which a character stands elsewhere."""
_STANDING = 10
"""Percentile of the heights of ankles in a motion that is taken for that of a standing foot."""


@dataclass(frozen=True)
class Fit:
    """How the joints of one skeleton follow those of another.

    Attributes
    ----------
    skeleton : Skeleton
        The part of the own skeleton that moves: joints that have a counterpart, and those above them.
    joints : (J,) int array
        The other's joint for each of ``skeleton``, -1 for those that stay in their rest pose beside their parent.
    turns : (J, 4) float array
        Own world rotation = the other's * turn.
    carriers : tuple of int
        Joints of ``skeleton`` whose places follow the other's: own = ratio * the other's + shift.
    ratio : float
        Own metres for one of the other's.
    shift : (3,) float array
        Metres in the world.
    is_same : bool
        The two are alike: motion is taken as it is.
    reason : str
        Where they are not, in what they differ: "another rest pose".
    unmoved : tuple of str
        The own joints that nothing moves.
    """

    skeleton: Skeleton
    joints: np.ndarray
    turns: np.ndarray
    carriers: tuple[int, ...]
    ratio: float = 1.0
    shift: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0)
    is_same: bool = False
    reason: str = ""
    unmoved: tuple[str, ...] = ()


def fit_skeleton(own: Skeleton, other: Skeleton, example: MotionClip | None = None) -> Fit:
    """Find how motion of ``other`` moves ``own``: by the names of the joints or, where those differ, by their roles.

    By names, rotations are taken over where the bones of both lie alike in their joints' axes, and rest nearly alike.
    Otherwise bones are brought into the other's rest pose from the hips down: each turns the shortest way or, where
    several hang from one joint, as fits them best (Kabsch 1976). By roles, only the limbs are: trunks and feet of two
    rigs are alike in the poses that people stand in, whatever way their joints lie inside.

    ``example`` is a clip of the other, which shows how high the floor is beside its rest pose; 0 without one.

    Raises ClipError if neither names nor roles say what is what; the sentence begins in lower case, and ends with a
    full stop.
    """
    joints, named = by_names(own, other), True
    if joints is None:
        joints, named = by_roles(own, other), False
    skeleton, kept = _moving_part(own, joints)
    unmoved = tuple(name for name in own.names if name not in skeleton.names)
    joints = joints[kept]
    carriers = tuple(joint for joint in _carriers(skeleton) if joints[joint] >= 0)
    if named and _have_same_axes(skeleton, other, joints):
        turns = np.tile(quat.IDENTITY, (skeleton.n_joints, 1))
    else:
        posed = _posed_like(skeleton, other, joints, named)
        turns = quat.multiply(quat.inverse(other.rest_world[0][joints]), posed)
    ratio = _leg_ratio(skeleton, other, joints, named)
    shift = skeleton.rest_world[1][carriers[-1]] - ratio * other.rest_world[1][joints[carriers[-1]]]
    # Files keep their places, seen from where the character stands, which is not quite above its own origin.
    there = skeleton.rest_world[1][carriers[-1], :2]
    shift[:2] = there if np.linalg.norm(there) > _AWAY * skeleton.stature else 0.0
    if named:
        # Alike in their bones: what is on the floor there is so here.
        shift[2] = 0.0 if _stands_on(skeleton, 0.0) else skeleton.rest_world[1][:, 2].min()
    else:
        shift[2] -= ratio * _below_motion(other, example)
    reason = "another rest pose" if named else "another skeleton"
    return Fit(skeleton, joints, turns, carriers, ratio, shift, False, reason, unmoved)


def retarget_steps(clip: MotionClip, fit: Fit) -> Generator[Progress, None, MotionClip]:
    """Carry a clip of the fit's other skeleton over to ``fit.skeleton``; every bone keeps its length."""
    own, parents = fit.skeleton, np.asarray(fit.skeleton.parents)
    if fit.is_same:
        return replace(
            clip, skeleton=own, rotations=clip.rotations[:, fit.joints], translations=clip.translations[:, fit.joints]
        )
    rotations = np.empty((clip.n_frames, own.n_joints, 4))
    translations = np.tile(own.rest_translations, (clip.n_frames, 1, 1))
    block = max(_BLOCK // max(own.n_joints, clip.skeleton.n_joints), 1)
    for start in range(0, clip.n_frames, block):
        frames = slice(start, start + block)
        turned, placed = world_transforms(clip.rotations[frames], clip.translations[frames], clip.skeleton.parents)
        world = np.empty((len(turned), own.n_joints, 4))
        position = np.zeros(3)
        for joint, source in enumerate(fit.joints):
            above = world[:, parents[joint]] if joint else quat.IDENTITY
            if source >= 0:
                world[:, joint] = quat.multiply(turned[:, source], fit.turns[joint])
            else:
                world[:, joint] = quat.multiply(above, own.rest_rotations[joint])
            rotations[frames, joint] = quat.multiply(quat.inverse(above), world[:, joint])
        for joint in _carriers(own)[: fit.carriers[-1] + 1]:
            above = world[:, parents[joint]] if joint else quat.IDENTITY
            if joint in fit.carriers:
                place = fit.ratio * placed[:, fit.joints[joint]] + fit.shift
                translations[frames, joint] = quat.rotate(quat.inverse(above), place - position)
            position = position + quat.rotate(above, translations[frames, joint])
        yield Progress(min(start + block, clip.n_frames) / clip.n_frames, f"Importing {clip.name}")
    return replace(clip, skeleton=own, rotations=rotations, translations=translations, heading=None)


def _moving_part(own: Skeleton, joints: np.ndarray) -> tuple[Skeleton, np.ndarray]:
    """Return the joints with a counterpart and those above them, as a skeleton and as (K,) indices."""
    moving = {int(joint) for joint in np.flatnonzero(joints >= 0)}
    kept = np.array(sorted(moving.union({0}, *(own.ancestors(joint) for joint in moving))))
    place = {int(joint): new for new, joint in enumerate(kept)}
    parents = np.array([place.get(int(own.parents[joint]), -1) for joint in kept])
    names = tuple(own.names[joint] for joint in kept)
    return Skeleton(names, parents, own.rest_rotations[kept], own.rest_translations[kept], own.forward), kept


def _carriers(skeleton: Skeleton) -> tuple[int, ...]:
    """List the joints from the root down to where the body branches."""
    chain = [0]
    while len(below := np.flatnonzero(np.asarray(skeleton.parents) == chain[-1])) == 1:
        chain.append(int(below[0]))
    return tuple(chain)


def _leg_ratio(own: Skeleton, other: Skeleton, joints: np.ndarray, named: bool) -> float:
    """Return how much longer the own legs are, whatever the pose."""
    if named:
        # The way from the hips to the lowest joint.
        lowest = int(np.argmin(np.where(joints >= 0, own.rest_world[1][:, 2], np.inf)))
        leg = [
            joint for joint in (lowest, *own.ancestors(lowest)) if joint not in _carriers(own) and joints[joint] >= 0
        ]
        here = float(np.linalg.norm(own.rest_translations[leg], axis=1).sum())
        there = float(np.linalg.norm(other.rest_translations[joints[leg]], axis=1).sum())
    else:
        here, there = leg_length(own), leg_length(other)
    return here / there if here > 0 and there > 0 else 1.0


def _below_motion(other: Skeleton, example: MotionClip | None) -> float:
    """Return the metres that the ankles of a rest pose lie below those of someone who stands in the motion.

    0 where they are about alike: then the rest pose is the more exact.
    """
    feet = [other.roles[JointRole.FOOT, side][0] for side in SIDES]
    rest = float(other.rest_world[1][feet, 2].mean())
    if example is None:
        return 0.0 if _stands_on(other, 0.0) else _USUAL_ANKLE * leg_length(other) - rest
    standing = float(np.percentile(example.world[1][:, feet, 2], _STANDING))
    return 0.0 if abs(standing - rest) < _ALIKE * leg_length(other) else standing - rest


def _stands_on(skeleton: Skeleton, floor: float) -> bool:
    """Test whether the ankles of the rest pose are as high as those of someone on the floor; yes without legs."""
    if not all((role, side) in skeleton.roles for role in LEG for side in SIDES):
        return True
    feet = [skeleton.roles[JointRole.FOOT, side][0] for side in SIDES]
    height = float(skeleton.rest_world[1][feet, 2].mean()) - floor
    return abs(height - _USUAL_ANKLE * leg_length(skeleton)) < _ALIKE * leg_length(skeleton)


def lie_alike(own_offsets: np.ndarray, other_offsets: np.ndarray, tolerance: float) -> bool:
    """Test whether all bones of any length, (N, 3) in their joints' axes, have about the same direction."""
    lengths = [np.linalg.norm(offsets, axis=1) for offsets in (own_offsets, other_offsets)]
    long = (lengths[0] > 5 * tolerance) & (lengths[1] > 5 * tolerance)
    cosine = np.sum(own_offsets * other_offsets, axis=1)[long] / (lengths[0] * lengths[1])[long]
    return bool(np.all(cosine > np.cos(_SAME_DIRECTION)))


def _have_same_axes(own: Skeleton, other: Skeleton, joints: np.ndarray) -> bool:
    """Test whether joints of the same names have the same axes: then a pose is the same rotations in both."""
    carriers = _carriers(own)
    fixed = [joint for joint in range(own.n_joints) if joint not in carriers and joints[joint] >= 0]
    parents = np.asarray(own.parents)[fixed]
    if (joints[parents] != np.asarray(other.parents)[joints[fixed]]).any():
        return False
    turned = quat.angle_between(own.rest_rotations[fixed], other.rest_rotations[joints[fixed]])
    offsets = own.rest_translations[fixed], other.rest_translations[joints[fixed]]
    return bool(np.all(turned < _NEARLY_SAME_REST)) and lie_alike(*offsets, 0.002 * own.stature)


def _posed_like(own: Skeleton, other: Skeleton, joints: np.ndarray, named: bool) -> np.ndarray:
    """Return (J, 4) the world rotations of the own joints in the other's rest pose."""
    turns, places = own.rest_world
    goal = other.rest_world[1][joints]
    headings = [np.arctan2(ahead[1], ahead[0]) for ahead in (other.rest_forward, own.rest_forward)]
    facing = quat.about("z", headings[0] - headings[1])
    moved = np.tile(facing, (own.n_joints, 1))
    branch = _carriers(own)[-1]
    limbs = {found[0] for (role, _), found in own.roles.items() if role in _LIMBS}
    for joint in (branch, *own.descendants(branch)):
        above = moved[own.parents[joint]] if joint != branch else facing
        if joints[joint] < 0:
            moved[joint] = above
            continue
        # Hands and what hangs from them, and toes, go with the bone above them.
        aligned = named or joint in limbs
        straight = not named and not limbs.intersection([joint, *own.ancestors(joint)])
        moved[joint] = facing if straight else above
        if not named and _is_foot(own, joint):
            moved[joint] = facing
        below = _next_joints(own, places, goal, joints, joint) if aligned else []
        if below:
            start = quat.rotate(above, places[below] - places[joint])
            moved[joint] = quat.multiply(_best_turn(start, goal[below] - goal[joint]), above)
    return quat.multiply(moved, turns)


def _is_foot(skeleton: Skeleton, joint: int) -> bool:
    ends = [skeleton.roles.get((role, side), ()) for role in (JointRole.FOOT, JointRole.TOES) for side in SIDES]
    return any(joint in found for found in ends)


def _next_joints(skeleton: Skeleton, places, goal, joints, joint: int) -> list[int]:
    """List the nearest joints below one that have counterparts and lie elsewhere than it, in both poses (J, 3)."""
    found, open_joints = [], [joint]
    while open_joints:
        for child in np.flatnonzero(np.asarray(skeleton.parents) == open_joints.pop()):
            apart = min(np.linalg.norm(pose[child] - pose[joint]) for pose in (places, goal))
            if joints[child] >= 0 and apart > 1e-3 * skeleton.stature:
                found.append(int(child))
            else:
                open_joints.append(int(child))
    return found


def _best_turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the (4,) rotation that best turns (N, 3) vectors to others, the smallest if several do."""
    start, end = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True) for vectors in (start, end))
    u, sizes, v = np.linalg.svd(end.T @ start)
    if len(start) > 1 and sizes[1] > 0.05 * sizes[0]:
        return quat.from_matrix(u @ np.diag([1.0, 1.0, np.linalg.det(u) * np.linalg.det(v)]) @ v)
    cosine = float(start[0] @ end[0])
    # Exactly opposite directions have no smallest turn: any axis will do.
    return quat.between(start[0], end[0]) if cosine > -1 + 1e-9 else quat.about("x", np.pi)
