"""Synthesis: a walk becomes poses (paper, section 3; blends by quaternion splines).

Every segment is laid along its edited root path. Where one takes over from another the poses differ a little: the gap
of every joint, of the root's height and of its tilt, and the gap of their velocities, are closed over a window on
both sides by cubic Hermite splines in the tangent space of rotations, so that poses and velocities are continuous
and nothing changes outside the windows. Both sides meet half way.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import WalkError
from ..motion import quat
from ..motion.body_size import relative_size
from ..motion.clip import MotionClip
from .root_path import played_root_path
from .transitions import TransitionGaps, closing, poses_at, transition_gaps, window_steps
from .walk import Walk


@dataclass(frozen=True)
class SynthesisSettings:
    """Settings of how the gaps at transitions are closed.

    Attributes
    ----------
    blend_duration : float
        Seconds on each side of a transition; never more than half of a segment.
    root_tolerance : float
        Metres by which the root may leave the walk's path near a transition, so that its velocity is continuous: where
        two edits meet, it is not by itself. 0 to follow the path exactly. For a character of a person's size, in
        proportion for others.
    """

    blend_duration: float = 0.3
    root_tolerance: float = 0.01

    def __post_init__(self):
        if not (np.isfinite(self.blend_duration) and self.blend_duration >= 0):
            raise WalkError(f"A blend of {self.blend_duration} s cannot be made; give zero or more seconds.")
        if not (np.isfinite(self.root_tolerance) and self.root_tolerance >= 0):
            raise WalkError(f"A root tolerance of {self.root_tolerance} m is no distance; give zero or more metres.")


def synthesize(
    walk: Walk,
    settings: SynthesisSettings | None = None,
    name: str = "Walk",
    blend_durations: np.ndarray | None = None,
    closed: bool = False,
) -> MotionClip:
    """Make the walk a motion clip at the motion graph's frame rate.

    The root passes along the walk's edited path (``walk.root_path``: the one that was checked against obstacles),
    exactly at the grid elements and outside the blends, within the settings' tolerance elsewhere. Tags are those of
    the segments played.

    Parameters
    ----------
    blend_durations : (n - 1,) float array, optional
        Seconds on each side of every transition of a walk of n segments, instead of what the settings and the sizes of
        the gaps make them; n of them if the walk is closed. Never more than half of a segment.
    closed : bool
        The walk ends at the node that it starts from: its end is blended into its start as well, so that the clip
        can be repeated.

    Raises
    ------
    WalkError
        The walk has no links, a closed one does not return to its start, or ``blend_durations`` do not fit.
    """
    settings = settings or SynthesisSettings()
    if len(walk) == 0:
        raise WalkError("The walk has no steps; ask for a longer Duration.")
    graph = walk.embedding.graph
    skeleton = graph.clips[0].skeleton
    gaps = transition_gaps(walk, closed)
    windows = _windows(walk, gaps, settings, blend_durations)
    clips, frames = _played(walk)
    rotations, translations = poses_at(graph, clips, frames)
    for after in (False, True):
        transition, step = window_steps(windows[:, int(after)], first=0 if after else 1)
        at = gaps.frames[transition] + step if after else gaps.ends[transition] - step
        value, slope = closing(step, windows[transition, int(after)])
        sign = -1.0 if after else 1.0
        value, slope = sign * value[:, None, None] / 2, -slope[:, None, None] / graph.frame_rate
        # Time runs towards the transition before it: its slopes are counted backwards there.
        rate = -gaps.turn_rates[transition, 1] if after else gaps.turn_rates[transition, 0]
        turn = value * gaps.turns[transition] + slope * rate
        rotations[at] = quat.multiply(rotations[at], quat.from_rotvec(turn))
        translations[at] += value * gaps.moves[transition] + slope * gaps.move_rates[transition] / 2
    if closed:
        rotations[-1], translations[-1] = rotations[0], translations[0]

    path = played_root_path(walk, gaps, windows, settings.root_tolerance * relative_size(skeleton))
    rotations[:, 0] = quat.multiply(quat.about("z", path[:, 2]), rotations[:, 0])
    translations[:, 0, :2] = path[:, :2]
    return MotionClip(name, skeleton, graph.frame_rate, rotations, translations, _tags(walk), heading=path[:, 2])


def _played(walk: Walk) -> tuple[np.ndarray, np.ndarray]:
    """Return (F,) clip and (F,) sample of each frame of the walk; at a transition those of the segment that starts."""
    segments = [walk.embedding.graph.segments[s] for s in walk.segments]
    clips, frames = np.empty((2, walk.node_frames[-1] + 1), dtype=int)
    for segment, first, last in zip(segments, walk.node_frames[:-1], walk.node_frames[1:], strict=True):
        clips[first : last + 1] = segment.clip
        frames[first : last + 1] = np.arange(segment.first, segment.last + 1)
    return clips, frames


def _tags(walk: Walk) -> dict[str, np.ndarray]:
    segments = walk.embedding.graph.segments
    tags = {tag: np.zeros(walk.node_frames[-1] + 1, dtype=bool) for s in segments for tag in s.tags}
    for i, index in enumerate(walk.segments):
        for tag, mask in segments[index].tags.items():
            tags[tag][walk.node_frames[i] : walk.node_frames[i + 1] + 1] |= mask
    return tags


def _windows(walk: Walk, gaps: TransitionGaps, settings: SynthesisSettings, durations: np.ndarray | None) -> np.ndarray:
    """Return (S, 2) frames before and after each transition in which its gap is closed; both 0 where no time is."""
    frame_rate = walk.embedding.graph.frame_rate
    if durations is None:
        durations = np.full(len(gaps.frames), settings.blend_duration)
    durations = np.asarray(durations, dtype=float)
    if durations.shape != (len(gaps.frames),) or not np.all(np.isfinite(durations) & (durations >= 0)):
        raise WalkError(
            f"The walk has {len(gaps.frames)} transitions, and each needs a blend duration of zero or more seconds."
        )
    half = np.diff(walk.node_frames) // 2
    before = np.column_stack([half[gaps.before], half[gaps.after]])
    windows = np.minimum(np.rint(durations * frame_rate).astype(int)[:, None], before)
    return windows * (windows.min(axis=1, keepdims=True) > 0)
