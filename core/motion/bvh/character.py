"""Characters of BVH files: which way is up, how long the unit is, and how the character stands at rest.

Files say none of it. What is up and how long the body is follow from the motion: a person's head is above the feet. The
offsets are a rest pose only where they make someone who stands; where they are folded, lie down, or stand elsewhere on
a stage, the character is taken as it stands in the motion.
"""

import re
from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ... import wording
from ...errors import ClipError
from ...progress import Progress
from .. import quat
from ..body_size import UNIT_NAMES, unit_of_person
from ..joint_roles import JointRole
from ..kinematics import descendants, local_transforms, world_transforms
from ..sides import mirrored_pairs
from ..skeleton import Skeleton
from .file import BvhFile

TO_Z_UP = {
    "Y": quat.about("x", np.pi / 2),
    "Z": quat.IDENTITY,
    "-Y": quat.about("x", -np.pi / 2),
    "-Z": quat.about("x", np.pi),
    "X": quat.about("y", -np.pi / 2),
    "-X": quat.about("y", np.pi / 2),
}
"""The rotation that brings a file's axes to those of Blender, by the axis that is up in the file."""

_USUAL = 1.7  # height in metres
_SMALLEST, _LARGEST = 0.8, 2.6  # of those who are no usual persons, but whose files are in plain metric units
_LEG_SHARE = 0.485  # thigh and shin as a part of the height
_N_SAMPLES = 48  # frames of a file that are looked at
_ARM = re.compile(r"arm|hand|finger|thumb|wrist|elbow|index|shoulder|shldr|collar|clavicle", re.IGNORECASE)


@dataclass(frozen=True)
class BvhCharacter:
    """What the files of one skeleton have in common.

    Attributes
    ----------
    up : str
        The axis of the files that points up, a key of ``TO_Z_UP``.
    unit : float
        Metres per unit.
    skeleton : Skeleton
        Joints in the order of the files, in metres, Z up, standing on the ground at the world's origin.
    tails : dict
        Joint name -> (3,) world position of its end site at rest, where there is one.
    carriers : tuple of int
        Joints from the root down to where the body branches: their places are travel, not proportions.
    height : float
        The body's height in metres.
    hip_height : float
        Metres between where the body branches and the ground, at rest.
    """

    up: str
    unit: float
    skeleton: Skeleton
    tails: dict[str, np.ndarray]
    carriers: tuple[int, ...]
    height: float
    hip_height: float

    def describe(self) -> str:
        """Say how the files were understood.

        "Y is up, lengths are in centimetres, and the character is 1.75 m tall".
        """
        unit = next((name for known, name in UNIT_NAMES.items() if np.isclose(known, self.unit, rtol=1e-4)), "")
        lengths = f"lengths are in {unit}" if unit else f"1 unit is {wording.exact(self.unit, 4)} m"
        return f"{self.up} is up, {lengths}, and the character is {wording.amount(self.height)} m tall"


@dataclass(frozen=True)
class _Samples:
    """Some frames of a file, spread over its motion: world places (S, J, 3) and local transforms in its own axes."""

    rotations: np.ndarray
    translations: np.ndarray
    places: np.ndarray


def understand_bvh_steps(
    files: Sequence[BvhFile], unit: float | None = None, up: str = ""
) -> Generator[Progress, None, list[BvhCharacter]]:
    """Return the character of each file: one for all files that have the same joints and offsets.

    ``unit`` and ``up`` are found from the motion where they are not given: up is the axis along which the head is above
    the feet in most frames of a character's files; where they do not tell (lying, crawling), as in the other files,
    or at rest, or Y. The unit is the one that makes the character a person, see :func:`.body_size.unit_of_person`;
    if none does, whatever makes it 1.7 m tall.

    Raises ClipError if a skeleton has no size.
    """
    groups: dict[tuple, list[int]] = {}
    samples: list[_Samples] = []
    of_files: list[dict[str, float]] = []
    for place, file in enumerate(files):
        yield Progress(0.7 * place / len(files), f"Looking at {file.name}")
        key = (file.names, tuple(file.parents), tuple(np.round(file.offsets, 3).ravel()))
        groups.setdefault(key, []).append(place)
        samples.append(_sample(file))
        of_files.append(_votes(file, samples[-1]))
    everyone = _total(of_files)
    result: dict[int, BvhCharacter] = {}
    for places in groups.values():
        yield Progress(0.7 + 0.3 * len(result) / len(files), f"Looking at {files[places[0]].name}")
        own = _elected(_total(of_files[k] for k in places))
        chosen = up or own or _elected(everyone) or _rest_up(files[places[0]]) or "Y"
        character = _character([files[k] for k in places], [samples[k] for k in places], chosen, unit)
        result.update(dict.fromkeys(places, character))
    return [result[place] for place in range(len(files))]


def _sample(file: BvhFile) -> _Samples:
    frames = np.unique(np.linspace(0, file.n_frames - 1, _N_SAMPLES).round().astype(int))
    rotations, translations = file.rotations(frames), file.translations(frames)
    return _Samples(rotations, translations, _places(rotations, translations, file.parents))


def _places(rotations, translations, parents) -> np.ndarray:
    return world_transforms(rotations, translations, parents)[1]


def _extremes(file: BvhFile) -> tuple[list[int], list[int]]:
    """Return the joints of the feet and those of the head: by their names, or by what stands still while the body
    travels."""
    roles = _plain_skeleton(file).roles
    low: list[int] = []
    for role in (JointRole.FOOT, JointRole.SHIN, JointRole.THIGH):
        sides = [roles.get((role, side), ()) for side in ("left", "right")]
        if all(sides):
            low = [joints[0] for joints in sides]
            break
    high = list(roles.get((JointRole.HEAD, ""), ()))[:1]
    if not high:
        arms = [roles.get((JointRole.UPPER_ARM, side), ()) for side in ("left", "right")]
        high = [joints[0] for joints in arms] if all(arms) else list(roles.get((JointRole.SPINE, ""), ()))[-1:]
    if low and high:
        return low, high
    low = _planted(file)
    return low, [joint for joint in range(file.n_joints) if joint not in low] if low else []


def _planted(file: BvhFile) -> list[int]:
    """List the last joints of chains that stand still again and again while the body travels."""
    frames = np.arange(min(file.n_frames, 600))
    places = _places(file.rotations(frames), file.translations(frames), file.parents)
    leaves = np.setdiff1d(np.arange(file.n_joints), file.parents)
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=2)
    body, size = places.mean(axis=1), np.ptp(places[0], axis=0).max()
    if len(leaves) == 0 or not np.linalg.norm(np.ptp(body, axis=0)) > 0.5 * size > 0:
        return []
    pace = np.linalg.norm(np.diff(body, axis=0), axis=1).mean()
    return [int(leaf) for leaf in leaves if np.percentile(speeds[:, leaf], 20) < 0.25 * pace]


def _votes(file: BvhFile, samples: _Samples) -> dict[str, float]:
    """Count the seconds in which the head is above the feet along each of the file's axes."""
    low, high = _extremes(file)
    if not low:
        return {}
    upwards = samples.places[:, high].mean(axis=1) - samples.places[:, low].mean(axis=1)
    length = np.linalg.norm(upwards, axis=1)
    share = upwards / np.maximum(length, 1e-9)[:, None]
    axis = np.argmax(np.abs(share), axis=1)
    travel = np.ptp(samples.places[:, high].mean(axis=1), axis=0)
    result: dict[str, float] = {}
    seconds = file.n_frames / file.frame_rate / len(share)
    for k in range(3):
        # Nobody walks upwards for longer than the body is: that is the way of someone who crawls.
        if travel[k] > 1.2 * np.median(length):
            continue
        along = share[axis == k, k]
        result["XYZ"[k]] = seconds * float(np.sum(along > 0.8))
        result["-" + "XYZ"[k]] = seconds * float(np.sum(along < -0.8))
    return {**result, "none": seconds * len(share) - sum(result.values())}


def _total(votes: Iterable[Mapping[str, float]]) -> dict[str, float]:
    result: dict[str, float] = {}
    for of_one in votes:
        for axis, seconds in of_one.items():
            result[axis] = result.get(axis, 0.0) + seconds
    return result


def _elected(votes: Mapping[str, float]) -> str:
    """Return the axis that has most of the seconds, or nothing."""
    axes = {axis: seconds for axis, seconds in votes.items() if axis != "none"}
    best = max(axes, key=axes.__getitem__, default="")
    return best if best and axes[best] > 0.5 * sum(votes.values()) else ""


def _rest_up(file: BvhFile) -> str:
    """Return the axis along which the head is above the feet at rest, or nothing."""
    rotations = np.tile(quat.IDENTITY, (1, file.n_joints, 1))
    places = _places(rotations, file.offsets[None], file.parents)
    low, high = _extremes(file)
    if not low:
        return ""
    upwards = places[0, high].mean(axis=0) - places[0, low].mean(axis=0)
    axis = int(np.argmax(np.abs(upwards)))
    steep = abs(upwards[axis]) > 0.8 * np.linalg.norm(upwards)
    return ("" if upwards[axis] > 0 else "-") + "XYZ"[axis] if steep else ""


def _plain_skeleton(file: BvhFile) -> Skeleton:
    """Return the file's joints at rest, in its own axes; of small lengths, whatever the unit."""
    size = max(float(np.abs(file.offsets).max()), 1e-9)
    rest = np.tile(quat.IDENTITY, (file.n_joints, 1))
    return Skeleton(file.names, file.parents, rest, file.offsets / size, np.array([0.0, 0.0, 1.0]))


def _character(files: Sequence[BvhFile], samples: Sequence[_Samples], up: str, unit: float | None) -> BvhCharacter:
    file = files[0]
    to_world = TO_Z_UP[up]
    carriers, branch = file.carriers, file.carriers[-1]
    low, _ = _extremes(file)
    low = low or _lowest(samples[0], to_world)
    turns, places = _placed(np.tile(quat.IDENTITY, (file.n_joints, 1)), file.offsets, file.parents, to_world)
    standing = _placed(*_standing_frame(samples, low, to_world), file.parents, to_world)
    is_sound = _stands(places, standing[1], low, branch)
    if not is_sound:
        turns, places = standing
    tips = places + quat.rotate(turns, np.nan_to_num(file.ends))
    height = _height(file, places, tips)
    if not height > 0:
        raise ClipError(f"'{file.name}' holds no skeleton of any size; it is not a BVH file or is damaged.")
    unit = unit or _unit(height, file.names)
    if not is_sound:
        ahead = _facing(file.names, places)
        turn = quat.about("z", -np.pi / 2 - np.arctan2(ahead[1], ahead[0]))
        turns, places, tips = quat.multiply(turn, turns), quat.rotate(turn, places), quat.rotate(turn, tips)

    # The body over the origin, its lowest point on the ground; what carries it there stays at the origin.
    lifted = max([joint for joint in carriers if file.moves(joint)], default=0)
    body = [lifted, *descendants(file.parents, lifted)]
    floor = min(places[body, 2].min(), tips[body, 2].min())
    shift = np.array([places[branch, 0], places[branch, 1], floor])
    hip_height = places[branch, 2] - floor
    places[body], tips[body] = places[body] - shift, tips[body] - shift
    places[[joint for joint in carriers if joint < lifted]] = 0.0
    places, tips = unit * places, unit * tips
    forward = quat.rotate(quat.inverse(turns[0]), _facing(file.names, places))
    return BvhCharacter(
        up=up,
        unit=float(unit),
        skeleton=Skeleton(file.names, file.parents, *local_transforms(turns, places, file.parents), forward),
        tails={file.names[k]: tips[k] for k in np.flatnonzero(np.isfinite(file.ends[:, 0]))},
        carriers=carriers,
        height=unit * height,
        hip_height=unit * hip_height,
    )


def _lowest(samples: _Samples, to_world) -> list[int]:
    heights = quat.rotate(to_world, samples.places)[..., 2].mean(axis=0)
    return [int(np.argmin(heights))]


def _placed(rotations, translations, parents, to_world) -> tuple[np.ndarray, np.ndarray]:
    """Return the (J, 4) rotations and (J, 3) places of one pose, Z up, in the file's unit."""
    turns, places = world_transforms(rotations, translations, parents)
    return quat.multiply(to_world, turns), quat.rotate(to_world, places)


def _standing_frame(samples: Sequence[_Samples], low: list[int], to_world) -> tuple[np.ndarray, np.ndarray]:
    """Return the local transforms of the straightest pose: the head high above both feet, and these side by side."""
    best, pose = -np.inf, (samples[0].rotations[0], samples[0].translations[0])
    for of_file in samples:
        places = quat.rotate(to_world, of_file.places)
        feet = places[:, low]
        apart = np.linalg.norm(feet[..., :2] - feet[..., :2].mean(axis=1, keepdims=True), axis=2).max(axis=1)
        score = places[..., 2].max(axis=1) - feet[..., 2].max(axis=1) - apart
        frame = int(np.argmax(score))
        if score[frame] > best:
            best, pose = score[frame], (of_file.rotations[frame], of_file.translations[frame])
    return pose


def _stands(rest: np.ndarray, standing: np.ndarray, low: list[int], branch: int) -> bool:
    """Test whether a rest pose stands as the body does in its motion: the feet as low, the head as high; (J, 3)."""
    top = int(np.argmax(standing[:, 2]))

    def extent(places: np.ndarray) -> tuple[float, float]:
        hips = places[branch, 2]
        return hips - places[low, 2].mean(), places[top, 2] - hips

    (leg, trunk), (rest_leg, rest_trunk) = extent(standing), extent(rest)
    return rest_leg >= 0.7 * leg and rest_trunk >= 0.6 * trunk and np.ptp(rest, axis=0).max() > 0


def _height(file: BvhFile, places: np.ndarray, tips: np.ndarray) -> float:
    """Return the height of a pose that stands, without its arms; what the legs say, where that is far from it."""
    body = [joint for joint, name in enumerate(file.names) if not _ARM.search(name)]
    ended = np.isfinite(file.ends[:, 0])
    points = np.concatenate([places[body], tips[[joint for joint in body if ended[joint]]]])
    if len(points) < 2:
        points = np.concatenate([places, tips[ended]])
    extent = np.ptp(points, axis=0)
    height = float(extent[2] if extent[2] > 0.3 * extent.max() else extent.max())
    roles = _plain_skeleton(file).roles
    leg = [roles.get((role, "left"), ()) for role in (JointRole.THIGH, JointRole.SHIN, JointRole.FOOT)]
    if all(leg):
        hip, knee, ankle = (places[joints[0]] for joints in leg)
        by_legs = float(np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee)) / _LEG_SHARE
        if by_legs > 0 and not 1 / 1.35 < height / by_legs < 1.35:
            return by_legs
    return height


def _unit(height: float, names: Sequence[str]) -> float:
    unit = unit_of_person(height, names)
    if unit is not None:
        return unit
    metric = [known for known in (1.0, 0.01, 0.001, 0.1) if _SMALLEST <= known * height <= _LARGEST]
    return metric[0] if metric else _USUAL / height


def _facing(names: Sequence[str], places: np.ndarray) -> np.ndarray:
    """Return the horizontal direction ahead of left and right joints, Blender's -Y without any."""
    index = {name: joint for joint, name in enumerate(names)}
    across = sum((places[index[left]] - places[index[right]] for left, right in mirrored_pairs(names)), np.zeros(3))
    ahead = np.cross(across, [0.0, 0.0, 1.0])
    length = np.linalg.norm(ahead)
    return ahead / length if length > 1e-6 * max(np.ptp(places, axis=0).max(), 1e-9) else np.array([0.0, -1.0, 0.0])
