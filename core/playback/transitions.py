"""Transitions: what changes where one segment of a walk takes over from another."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import WalkError
from ..motion import quat
from ..motion.distance import joint_weights
from ..motion.graph import MotionGraph
from .walk import Walk


@dataclass(frozen=True)
class TransitionGaps:
    """The gaps between the source clips' poses at the S transitions of a walk, place and heading left out; J joints.

    Attributes
    ----------
    frames, ends : (S,) int array
        Frame of the walk at which the next segment starts, and at which the last one ends: the same, but for the
        transition of a closed walk between its end and its start.
    before, after : (S,) int array
        Number of the segment on the walk that ends there, and of the one that starts.
    turns : (S, J, 3) float array
        Rotation vectors (rad) from each joint's rotation before the transition to that after it, in the frame before.
    turn_rates : (S, 2, J, 3) float array
        Rates (rad/s) at the transition of the rotation vectors that are to be added before, and after it, so that the
        angular velocity of both sides is the same there.
    moves, move_rates : (S, J, 3) float array
        The same of the translations: metres, and what their velocities (m/s) change by.
    weighs : (J,) bool array
        The joints that poses are compared by: not fingers, nor bones outside the body.
    """

    frames: np.ndarray
    ends: np.ndarray
    before: np.ndarray
    after: np.ndarray
    turns: np.ndarray
    turn_rates: np.ndarray
    moves: np.ndarray
    move_rates: np.ndarray
    weighs: np.ndarray

    @cached_property
    def angles(self) -> np.ndarray:
        """(S, J) radians that each joint turns by at each transition; 0 for joints that do not weigh."""
        return np.where(self.weighs, np.linalg.norm(self.turns, axis=2), 0.0)


def transition_gaps(walk: Walk, closed: bool = False) -> TransitionGaps:
    """Measure the gaps at the transitions of a walk; if it is closed, at last the one between its end and its start.

    Rates are centred differences in the whole clips, so that a segment followed by its own continuation leaves no gap
    at all. WalkError if a closed walk does not end at the node that it starts from.
    """
    graph, n = walk.embedding.graph, len(walk)
    if closed and tuple(walk.states[0, 2:]) != tuple(walk.states[-1, 2:]):
        raise WalkError(
            "The walk does not return to the heading and the segment that it starts from, so that it cannot be "
            "repeated; ask for a loop."
        )
    before = np.arange(n if closed else n - 1)
    after = (before + 1) % n
    segments = [graph.segments[s] for s in walk.segments]
    clip = np.array([segment.clip for segment in segments])
    first, last = (np.array([getattr(segment, end) for segment in segments]) for end in ("first", "last"))
    rotations_a, translations_a = poses_at(graph, clip[before], last[before])
    rotations_b, translations_b = poses_at(graph, clip[after], first[after])
    turns = quat.to_rotvec(quat.multiply(quat.inverse(rotations_a), rotations_b))
    omega_a, velocity_a = _rates(graph, clip[before], last[before])
    omega_b, velocity_b = _rates(graph, clip[after], first[after])
    # Both sides meet in the middle of the gap, at the mean of their angular velocities as seen from there.
    half = quat.from_rotvec(turns / 2)
    seen_a, seen_b = quat.rotate(quat.inverse(half), omega_a), quat.rotate(half, omega_b)
    common = (seen_a + seen_b) / 2
    rates = [quat.rotvec_rate(turns / 2, common - seen_a), quat.rotvec_rate(-turns / 2, common - seen_b)]
    return TransitionGaps(
        frames=walk.node_frames[:-1][after],
        ends=walk.node_frames[1:][before],
        before=before,
        after=after,
        turns=turns,
        turn_rates=np.stack(rates, axis=1),
        moves=translations_b - translations_a,
        move_rates=velocity_b - velocity_a,
        weighs=joint_weights(graph.clips[0].skeleton) > 0,
    )


def poses_at(graph: MotionGraph, clips: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (N, J, 4) rotations, (N, J, 3) translations of N samples of the graph's clips, without place and heading.

    What is left of the root is its height and its tilt; where the heading is steadier than the root, the tilt holds
    the sway of the hips.
    """
    n_joints = graph.clips[0].skeleton.n_joints
    rotations, translations = np.empty((len(frames), n_joints, 4)), np.empty((len(frames), n_joints, 3))
    heading = np.empty(len(frames))
    for index in np.unique(clips):
        here, clip = clips == index, graph.clips[index]
        rotations[here], translations[here] = clip.rotations[frames[here]], clip.translations[frames[here]]
        heading[here] = clip.ground_path[frames[here], 2]
    rotations[:, 0] = quat.multiply(quat.about("z", -heading), rotations[:, 0])
    translations[:, 0, :2] = 0.0
    return rotations, translations


def closing(steps: np.ndarray, window: np.ndarray | int) -> tuple[np.ndarray, np.ndarray]:
    """Return the factors of a gap's value and of its slope (per frame), ``steps`` frames away from it.

    Cubic Hermite splines: at the gap (step 0) they are 1 and 0 with slopes 0 and 1; from the end of the window, of
    ``window`` frames, on both are 0 with slope 0.

    >>> closing(np.array([0, 2, 4]), 4)
    (array([1. , 0.5, 0. ]), array([0. , 0.5, 0. ]))
    """
    s = np.minimum(steps / window, 1.0)
    return 2 * s**3 - 3 * s**2 + 1, (s**3 - 2 * s**2 + s) * window


def window_steps(windows: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the transition, and the distance to it, of each frame of (S,) windows, from ``first`` to the last.

    >>> window_steps(np.array([2, 0, 1]), first=1)
    (array([0, 0, 2]), array([1, 2, 1]))
    """
    counts = np.where(windows > 0, windows + 1 - first, 0)
    transition = np.repeat(np.arange(len(windows)), counts)
    step = np.arange(len(transition)) - np.repeat(np.cumsum(counts) - counts, counts) + first
    return transition, step


def _rates(graph: MotionGraph, clips: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (N, J, 3) angular velocity (rad/s, in the joints' own frames) and (N, J, 3) velocity (m/s)."""
    length = np.array([clip.n_frames for clip in graph.clips])[clips]
    earlier, later = np.maximum(frames - 1, 0), np.minimum(frames + 1, length - 1)
    rotations_a, translations_a = poses_at(graph, clips, earlier)
    rotations_b, translations_b = poses_at(graph, clips, later)
    seconds = ((later - earlier) / graph.frame_rate)[:, None, None]
    turns = quat.to_rotvec(quat.multiply(quat.inverse(rotations_a), rotations_b))
    return turns / seconds, (translations_b - translations_a) / seconds
