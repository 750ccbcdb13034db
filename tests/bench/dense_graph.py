"""Motion graphs by the textbook: every pair of frames compared joint by joint, every clip cut by itself.

The reference that the core's motion graphs are measured against. Vectorised over frames, so that it is as fast as
plain NumPy and SciPy make it.
"""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial.transform import Rotation

from core.motion.clip import MotionClip
from core.motion.component import largest_component
from core.motion.contacts import foot_contacts
from core.motion.distance import CostSettings, joint_weights
from core.motion.graph_settings import MotionGraphSettings
from tests.core.cuttings import greedy_cuts


def dense_motion_graph(clips: list[MotionClip], settings: MotionGraphSettings) -> tuple[int, int]:
    """Segments and links by the textbook: every pair of frames compared, every clip cut greedily by itself."""
    clips = [clip.resampled(settings.frame_rate) for clip in clips]
    clips = [clip for clip in clips if clip.n_frames > settings.min_gap]
    costs = np.concatenate([textbook_costs(clip, clips, settings.cost) for clip in clips])
    contacts = np.concatenate([foot_contacts(clip) for clip in clips])
    lengths = np.array([clip.n_frames for clip in clips])
    owner, frame = np.repeat(np.arange(len(clips)), lengths), np.arange(len(contacts))
    linkable = (costs <= settings.max_cost) & (contacts[:, None] == contacts).all(axis=2)
    linkable &= (owner[:, None] != owner) | (np.abs(frame[:, None] - frame) >= settings.min_gap)
    goodness = np.where(linkable, np.exp(-3 * costs / settings.max_cost), 0)
    cuts = greedy_cuts(csr_matrix(goodness), lengths, settings.min_gap)
    offsets = np.cumsum(lengths) - lengths
    first = np.concatenate([offset + own[:-1] for offset, own in zip(offsets, cuts, strict=True)])
    last = np.concatenate([offset + own[1:] for offset, own in zip(offsets, cuts, strict=True)])
    links = np.argwhere(linkable[np.ix_(last, first)] | (last[:, None] == first))
    kept = largest_component(len(first), links)
    return int(kept.sum()), int(kept[links].all(axis=1).sum())


def textbook_costs(clip: MotionClip, others: list[MotionClip], settings: CostSettings) -> np.ndarray:
    """(A, B) float64 costs D of Lee et al. 2002 between a clip's frames and those of others, joint by joint."""
    weights = joint_weights(clip.skeleton, settings.joint_weights)
    ours, theirs = _described(clip, weights), [_described(other, weights) for other in others]
    costs = np.zeros((clip.n_frames, sum(other.n_frames for other in others)))
    for joint, weight in zip(np.flatnonzero(weights), weights[weights > 0], strict=True):
        turns = Rotation.concatenate([of[0][joint] for of in theirs])
        for i, turn in enumerate(ours[0][joint]):
            costs[i] += weight * (turns.inv() * turn).magnitude() ** 2
        spins = np.concatenate([of[1][joint] for of in theirs])
        costs += settings.velocity_weight * weight * ((ours[1][joint][:, None] - spins) ** 2).sum(axis=2)
    costs += ((ours[2][:, None] - np.concatenate([of[2] for of in theirs])) ** 2).sum(axis=2)
    return costs


def _described(clip: MotionClip, weights: np.ndarray):
    """Rotations and angular velocities by weighted joint, and the root's scaled height, velocity and turn rate."""
    heading = clip.ground_path[:, 2]
    away = Rotation.from_euler("Z", -heading[:, None])
    turns, spins = {}, {}
    frame = np.arange(clip.n_frames)
    before, after = np.maximum(frame - 1, 0), np.minimum(frame + 1, clip.n_frames - 1)
    for joint in np.flatnonzero(weights):
        turn = Rotation.from_quat(clip.rotations[:, joint], scalar_first=True)
        turns[joint] = away * turn if joint == 0 else turn
        step = turns[joint][before].inv() * turns[joint][after]
        spins[joint] = step.as_rotvec() * (clip.frame_rate / (after - before))[:, None]
    settings = CostSettings()
    velocity = away.apply(np.gradient(clip.translations[:, 0], axis=0)) * clip.frame_rate
    turning = np.gradient(heading) * clip.frame_rate
    height = settings.height_weight * clip.translations[:, 0, 2]
    return turns, spins, np.column_stack([height, settings.travel_weight * velocity, settings.turn_weight * turning])
