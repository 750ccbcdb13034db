"""Spikes: moments of a walk that are rougher than its clips ever are, and lurches."""

from dataclasses import dataclass

import numpy as np

from ..errors import ClipError
from ..motion import quat
from ..motion.body_size import relative_size
from ..motion.clip import MotionClip
from ..motion.contacts import ContactSettings, foot_joints
from ..motion.graph import MotionGraph
from ..motion.skeleton import Skeleton
from .two_bone import Leg, find_leg
from .walk import Walk

#: Percentile of the clips' own roughness, and times that, beyond which something is rougher than they are.
USUAL, BEYOND = 99.9, 1.25

#: Smoother than that is smooth to every eye, however smooth the clips are: a knee in rad/s^2, a joint in rad/s^3.
SMOOTH_KNEE, SMOOTH_JOINT = 100.0, 500.0

#: Metres per second squared of a person's hips, over so many seconds: beyond, one stumbles, or is pushed.
LURCH, LURCH_TIME = 5.0, 0.2

#: Times the roughness of the clip that is played at that moment that are no spike, either: some comes from the clip.
_OWN = 1.1

#: Frames within which spikes count as one.
_NEAR = 2


@dataclass(frozen=True)
class Spike:
    """A moment at which something is too rough: its frame, the joint, and how many times what is tolerable it is."""

    frame: int
    joint: int
    severity: float


@dataclass(frozen=True)
class GraphRoughness:
    """Roughness of the clips of a motion graph, in times of what is tolerable.

    Attributes
    ----------
    legs : tuple of Leg
    knee_limit : float
        The angular acceleration of a knee's bend that is tolerable, rad/s^2.
    joint_limits : (J,) float array
        The jerk of each joint's rotation that is, rad/s^3; infinite for bones that are no part of the body.
    knees : for each clip (F - 2, L) float array
    joints : for each clip (F - 3, J) float array
    """

    legs: tuple[Leg, ...]
    knee_limit: float
    joint_limits: np.ndarray
    knees: tuple[np.ndarray, ...]
    joints: tuple[np.ndarray, ...]


def graph_roughness(graph: MotionGraph, contacts: ContactSettings | None = None) -> GraphRoughness:
    """Measure the clips of a motion graph: what they hardly ever exceed, and a quarter more, is tolerable."""
    skeleton = graph.clips[0].skeleton
    legs, body = _legs(skeleton, contacts or ContactSettings()), _body(skeleton)
    knees, joints = [_knees(clip, legs) for clip in graph.clips], [_jerks(clip) for clip in graph.clips]
    limits = np.full(skeleton.n_joints, np.inf)
    every = np.concatenate(joints)[:, body]
    limits[body] = BEYOND * np.maximum(np.percentile(every, USUAL, axis=0) if len(every) else 0.0, SMOOTH_JOINT)
    bends = np.concatenate(knees).ravel()
    limit = BEYOND * max(float(np.percentile(bends, USUAL)) if len(bends) else 0.0, SMOOTH_KNEE)
    return GraphRoughness(legs, limit, limits, tuple(k / limit for k in knees), tuple(j / limits for j in joints))


def segment_spikes(graph: MotionGraph, rough: GraphRoughness) -> np.ndarray:
    """Return (S,) how often the clips themselves are rougher than they usually are, in each segment."""
    counts = np.zeros(len(graph.segments), dtype=int)
    for number, segment in enumerate(graph.segments):
        for of_clips in (rough.knees, rough.joints):
            inside = of_clips[segment.clip][segment.first : segment.last - 1]
            counts[number] += len(_peaks(inside, np.arange(inside.shape[1]), 0))
    return counts


def find_spikes(walk: Walk, clip: MotionClip, rough: GraphRoughness) -> tuple[list[Spike], list[Spike], list[Spike]]:
    """Find the spikes of the knees, of all joints, and the lurches of the motion that a walk became.

    What the clip that is played has at that moment itself is none. A lurch is a change of the hips' horizontal
    velocity over ``LURCH_TIME``. Of neighbouring frames the worst counts.
    """
    knees = _knees(clip, rough.legs) / rough.knee_limit
    joints = _jerks(clip) / rough.joint_limits
    knees = np.where(knees > _OWN * _played(walk, rough.knees, len(knees)), knees, 0.0)
    joints = np.where(joints > _OWN * _played(walk, rough.joints, len(joints)), joints, 0.0)
    lurches, hips = _lurches(clip), clip.skeleton.hips
    middle = (max(round(LURCH_TIME * clip.frame_rate), 1) + 1) // 2
    shins = np.array([leg.shin for leg in rough.legs], dtype=int)
    return (
        _peaks(knees, shins, 1),
        _peaks(joints, np.arange(clip.skeleton.n_joints), 2),
        _peaks(lurches[:, None], np.array([hips]), middle),
    )


def _played(walk: Walk, of_clips: tuple[np.ndarray, ...], n_rows: int) -> np.ndarray:
    """Return (n_rows, ...) the clips' own values at what is played, or at the frame before it or after it."""
    played = np.zeros((n_rows, of_clips[0].shape[1]))
    for index, start in zip(walk.segments, walk.node_frames[:-1], strict=True):
        segment = walk.embedding.graph.segments[index]
        own = of_clips[segment.clip][segment.first : segment.last + 1]
        rows = played[start : start + len(own)]
        np.maximum(rows, own[: len(rows)], out=rows)
    around = np.pad(played, ((1, 1), (0, 0)))
    return np.maximum(np.maximum(around[:-2], around[1:-1]), around[2:])


def _jerks(clip: MotionClip) -> np.ndarray:
    """(F - 3, J) rad/s^3: second differences of the joints' angular velocities."""
    turns = quat.to_rotvec(quat.multiply(quat.inverse(clip.rotations[:-1]), clip.rotations[1:]))
    return np.linalg.norm(np.diff(turns, 2, axis=0), axis=2) * clip.frame_rate**3


def _knees(clip: MotionClip, legs: tuple[Leg, ...]) -> np.ndarray:
    """(F - 2, L) rad/s^2 of the bend of each knee."""
    positions, bends = clip.world[1], np.empty((clip.n_frames, len(legs)))
    for bend, leg in zip(bends.T, legs, strict=True):
        thigh, shin = positions[:, leg.shin] - positions[:, leg.thigh], positions[:, leg.foot] - positions[:, leg.shin]
        cosine = np.sum(thigh * shin, axis=1) / (np.linalg.norm(thigh, axis=1) * np.linalg.norm(shin, axis=1))
        bend[:] = np.arccos(np.clip(cosine, -1.0, 1.0))
    return np.abs(np.diff(bends, 2, axis=0)) * clip.frame_rate**2


def _lurches(clip: MotionClip) -> np.ndarray:
    """(n,) changes of the hips' velocity around each frame, in times of a lurch."""
    span = max(round(LURCH_TIME * clip.frame_rate), 1)
    velocity = np.diff(clip.world[1][:, clip.skeleton.hips, :2], axis=0) * clip.frame_rate
    changes = np.linalg.norm(velocity[span:] - velocity[:-span], axis=1) * clip.frame_rate / span
    return changes / (LURCH * relative_size(clip.skeleton))


def _peaks(severity: np.ndarray, joints: np.ndarray, first: int) -> list[Spike]:
    """List the worst of each stretch of (n, J) severities beyond 1; row 0 is frame ``first``."""
    found = []
    most = severity.max(axis=1, initial=0.0)
    beyond = np.flatnonzero(most > 1)
    for stretch in np.split(beyond, np.flatnonzero(np.diff(beyond) > _NEAR) + 1) if len(beyond) else ():
        row = int(stretch[np.argmax(most[stretch])])
        found.append(Spike(first + row, int(joints[np.argmax(severity[row])]), float(most[row])))
    return found


def _body(skeleton: Skeleton) -> list[int]:
    """The joints known as parts of the body; all of them where names say nothing."""
    known = sorted({joint for joints in skeleton.roles.values() for joint in joints})
    return known or list(range(skeleton.n_joints))


def _legs(skeleton: Skeleton, contacts: ContactSettings) -> tuple[Leg, ...]:
    try:
        feet = foot_joints(skeleton, contacts.feet)
    except ClipError:
        return ()
    return tuple(leg for leg in (find_leg(skeleton, side, feet) for side in (0, 1)) if isinstance(leg, Leg))
