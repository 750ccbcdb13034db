"""The root path that is played: the walk's own, without the jolts where two edits meet."""

import numpy as np

from ..embedding.footprint import edit_profile
from ..motion.graph import MotionSegment
from .transitions import TransitionGaps, closing, window_steps
from .walk import Walk

_PEAK = 4 / 27
"""The most that a spline of slope 1 at one end leaves zero by, for each frame of its window."""


def played_root_path(walk: Walk, gaps: TransitionGaps, windows: np.ndarray, tolerance: float) -> np.ndarray:
    """Return (F, 3) world x, y (m) and unwrapped heading (rad): ``walk.root_path`` with continuous velocities.

    Each segment's path is edited by itself, so that speed, direction and turn rate change abruptly at transitions.
    The changes are spread over the (S, 2) ``windows`` of frames around them, or less, so that the path is never left
    by more than ``tolerance`` metres. It passes exactly through every grid element, and does not change outside the
    windows. Nor does it where it would come too near to an obstacle or into another region.
    """
    if tolerance == 0 or len(gaps.frames) == 0:
        return walk.root_path.copy()
    frame_rate = walk.embedding.graph.frame_rate
    starting, ending = _end_rates(walk)
    jumps = (starting[gaps.after] - ending[gaps.before]) / frame_rate
    speeds = np.linalg.norm(jumps[:, :2], axis=1) / 2
    longest = np.floor(np.minimum(tolerance / np.maximum(speeds * _PEAK, 1e-12), windows.max())).astype(int)
    while True:
        path, owner = walk.root_path.copy(), np.full(walk.root_path.shape[0], -1)
        for after in (False, True):
            reach = np.minimum(windows[:, int(after)], longest)
            transition, step = window_steps(reach, first=1)
            at = gaps.frames[transition] + step if after else gaps.ends[transition] - step
            # Half of the change on each side; before the transition time runs against the steps.
            path[at] -= closing(step, reach[transition])[1][:, None] * jumps[transition] / 2
            owner[at] = transition
        astray = owner[_is_elsewhere(walk, path) & (owner >= 0)]
        if not len(astray):
            return path
        longest[astray] = 0


def _is_elsewhere(walk: Walk, path: np.ndarray) -> np.ndarray:
    """Test where a path lies off the ground, in what is blocked or in other regions than the walk's own path."""
    environment = walk.embedding.environment
    grid, size = environment.grid, np.array(environment.blocked.shape)
    places = [np.floor((p[:, :2] - grid.origin) / grid.sample_size).astype(int) for p in (path, walk.root_path)]
    off = np.zeros(len(path), dtype=bool)
    if grid.tiled:
        places = [place % size for place in places]
    else:
        off = np.any((places[0] < 0) | (places[0] >= size), axis=1)
        places = [np.clip(place, 0, size - 1) for place in places]
    here, there = (tuple(place.T) for place in places)
    off |= environment.blocked[here] & ~environment.blocked[there]
    for region in environment.regions:
        off |= region.mask[here] != region.mask[there]
    return off


def _end_rates(walk: Walk) -> tuple[np.ndarray, np.ndarray]:
    """Return (n, 3), (n, 3) rates of x, y and heading (m/s, rad/s) at both ends of each segment's edited path.

    Those of the clips are centred differences, so that a segment goes on smoothly in its own continuation.
    """
    graph, grid, stencils = walk.embedding.graph, walk.embedding.environment.grid, walk.embedding.unrolling.stencils
    rates = np.empty((2, len(walk), 3))
    for i, (index, k) in enumerate(zip(walk.segments, walk.stencils, strict=True)):
        segment: MotionSegment = graph.segments[index]
        clip = graph.clips[segment.clip]
        profile = edit_profile(segment)
        angle = walk.states[i, 2] * grid.heading_step - clip.ground_path[segment.first, 2]
        error = np.array([*stencils.position_error[k], stencils.heading_error[k]])
        edits = (profile[1] - profile[0], profile[-1] - profile[-2])
        for end, frame in enumerate((segment.first, segment.last)):
            rates[end, i] = _turned(_clip_rate(clip.ground_path, frame), angle) + edits[end] * error
    return rates[0] * graph.frame_rate, rates[1] * graph.frame_rate


def _clip_rate(path: np.ndarray, frame: int) -> np.ndarray:
    earlier, later = max(frame - 1, 0), min(frame + 1, len(path) - 1)
    return (path[later] - path[earlier]) / (later - earlier)


def _turned(rate: np.ndarray, angle: float) -> np.ndarray:
    x, y, turn = rate
    return np.array([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, turn])
