"""Motion clips of BVH files: on their own skeleton, or carried over to that of other files with the same joints."""

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import ClipError
from ...progress import Progress
from .. import quat
from ..clip import MotionClip
from ..skeleton import Skeleton
from .character import TO_Z_UP, BvhCharacter
from .file import BvhFile

_SAME_LENGTH = 0.01  # as a part of the hips' height
_SAME_DIRECTION = np.radians(25)  # of bones in their joints' axes: actors differ by less, rest poses by more
_BLOCK = 100_000  # joints times frames that are worked on at a time


@dataclass(frozen=True)
class Fit:
    """How the joints of one character follow those of another with the same names.

    Attributes
    ----------
    order : (J,) int array
        The other's joint for each of one's own.
    turns : (J, 4) float array
        Own world rotation = the other's * turn.
    ratio : float
        Own metres for one of the other's, for travel.
    is_same : bool
        The two are alike: motion is taken as it is.
    reason : str
        Where they are not, in what they differ: "another rest pose".
    """

    order: np.ndarray
    turns: np.ndarray
    ratio: float
    is_same: bool
    reason: str


def fit_character(own: BvhCharacter, other: BvhCharacter) -> Fit:
    """Find how motion of ``other`` moves ``own``; ClipError if they have other joints.

    Where the bones of both lie alike in their joints' axes, rotations are taken over. Otherwise both are brought into
    the same pose, the other's rest pose: from the hips down each bone turns the shortest way or, where several hang
    from one joint, as fits them best (Kabsch 1976).
    """
    order = _joints_of(own, other)
    own_offsets, other_offsets = own.skeleton.rest_translations, other.skeleton.rest_translations[order]
    fixed = np.setdiff1d(np.arange(len(order)), own.carriers)
    tolerance = _SAME_LENGTH * max(own.hip_height, 1e-9)
    no_turns = np.tile(quat.IDENTITY, (len(order), 1))
    is_same = not (np.linalg.norm(own_offsets - other_offsets, axis=1)[fixed] > tolerance).any()
    if is_same:
        return Fit(order, no_turns, 1.0, True, "")
    ratio = _leg_ratio(own, own_offsets, other_offsets)
    if _lie_alike(own_offsets[fixed], other_offsets[fixed], tolerance):
        return Fit(order, no_turns, ratio, False, "another size")
    turns = quat.multiply(quat.inverse(other.skeleton.rest_world[0][order]), _posed_like(own, other, order))
    return Fit(order, turns, ratio, False, "another rest pose")


def bvh_clip_steps(
    file: BvhFile, character: BvhCharacter, own: BvhCharacter, fit: Fit
) -> Generator[Progress, None, MotionClip]:
    """Make the clip of a file of ``character`` on the skeleton of ``own``, in metres, Z up.

    Rotations (F, J, 4) and translations (F, J, 3) are as in :class:`.clip.MotionClip`. On a skeleton of another size
    all travel is scaled with the legs, and every bone keeps its length.

    Raises ClipError if the motion goes farther than any clip can.
    """
    parents, carriers = np.asarray(own.skeleton.parents), list(own.carriers)
    up, turns = TO_Z_UP[character.up], fit.turns
    turns_above = np.where((parents >= 0)[:, None], turns[parents], quat.IDENTITY)
    rotations = np.empty((file.n_frames, file.n_joints, 4))
    translations = np.empty((file.n_frames, file.n_joints, 3))
    block = max(_BLOCK // file.n_joints, 1)
    for start in range(0, file.n_frames, block):
        frames = slice(start, start + block)
        turned, placed = file.rotations(frames), character.unit * file.translations(frames)
        turned[:, 0], placed[:, 0] = quat.multiply(up, turned[:, 0]), quat.rotate(up, placed[:, 0])
        turned, placed = turned[:, fit.order], placed[:, fit.order]
        if not fit.is_same:
            turned = quat.multiply(quat.inverse(turns_above), turned, turns)
            travel = fit.ratio * quat.rotate(quat.inverse(turns_above[carriers]), placed[:, carriers])
            placed = np.tile(own.skeleton.rest_translations, (len(placed), 1, 1))
            placed[:, carriers] = travel
        rotations[frames], translations[frames] = turned, placed
        yield Progress(min(start + block, file.n_frames) / file.n_frames, f"Importing {file.name}")
    return MotionClip(
        name=Path(file.name).stem,
        skeleton=own.skeleton,
        frame_rate=file.frame_rate,
        rotations=rotations,
        translations=translations,
        first_frame=1.0,
    )


def _joints_of(own: BvhCharacter, other: BvhCharacter) -> np.ndarray:
    def tree(character: BvhCharacter) -> dict[str, str]:
        names, parents = character.skeleton.names, character.skeleton.parents
        return {name: names[above] if above >= 0 else "" for name, above in zip(names, parents, strict=True)}

    here, there = tree(own), tree(other)
    if here != there:
        strange = sorted(set(here.items()) ^ set(there.items()))[0][0]
        raise ClipError(f"they differ in bone '{strange}'.")
    return np.array([other.skeleton.names.index(name) for name in own.skeleton.names])


def _leg_ratio(own: BvhCharacter, own_offsets: np.ndarray, other_offsets: np.ndarray) -> float:
    """Return how much longer the own way is from the hips to the lowest joint, whatever the pose."""
    lowest = int(np.argmin(own.skeleton.rest_world[1][:, 2]))
    leg = [joint for joint in (lowest, *own.skeleton.ancestors(lowest)) if joint not in own.carriers]
    here, there = (float(np.linalg.norm(offsets[leg], axis=1).sum()) for offsets in (own_offsets, other_offsets))
    return here / there if here > 0 and there > 0 else 1.0


def _lie_alike(own_offsets: np.ndarray, other_offsets: np.ndarray, tolerance: float) -> bool:
    """Test whether all bones of any length, (N, 3), have about the same direction."""
    lengths = [np.linalg.norm(offsets, axis=1) for offsets in (own_offsets, other_offsets)]
    long = (lengths[0] > 5 * tolerance) & (lengths[1] > 5 * tolerance)
    cosine = np.sum(own_offsets * other_offsets, axis=1)[long] / (lengths[0] * lengths[1])[long]
    return bool(np.all(cosine > np.cos(_SAME_DIRECTION)))


def _posed_like(own: BvhCharacter, other: BvhCharacter, order: np.ndarray) -> np.ndarray:
    """Return (J, 4) the world rotations of the own joints in the other's rest pose."""
    skeleton = own.skeleton
    turns, places = skeleton.rest_world
    goal = other.skeleton.rest_world[1][order]
    headings = [np.arctan2(ahead[1], ahead[0]) for ahead in (other.skeleton.rest_forward, skeleton.rest_forward)]
    facing = quat.about("z", headings[0] - headings[1])
    branch = own.carriers[-1]
    moved = np.tile(facing, (skeleton.n_joints, 1))
    for joint in (branch, *skeleton.descendants(branch)):
        above = moved[skeleton.parents[joint]] if joint != branch else facing
        below = _next_joints(skeleton, places, goal, joint)
        moved[joint] = above
        if below:
            start = quat.rotate(above, places[below] - places[joint])
            moved[joint] = quat.multiply(_best_turn(start, goal[below] - goal[joint]), above)
    return quat.multiply(moved, turns)


def _next_joints(skeleton: Skeleton, places: np.ndarray, goal: np.ndarray, joint: int) -> list[int]:
    """List the nearest joints below one that lie elsewhere than it, in both poses (J, 3)."""
    found, open_joints = [], [joint]
    while open_joints:
        for child in np.flatnonzero(skeleton.parents == open_joints.pop()):
            apart = min(np.linalg.norm(pose[child] - pose[joint]) for pose in (places, goal))
            if apart > 1e-3 * skeleton.stature:
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
