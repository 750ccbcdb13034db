"""Synthesis: a walk becomes poses (paper, section 3; blends by quaternion splines).

Every segment is laid along its edited root path. Where one takes over from another the poses differ a little: the gap
of every joint, of the root's height and of its tilt, and the gap of their velocities, are closed over a window on
both sides by cubic Hermite splines in the tangent space of rotations, so that poses and velocities are continuous
and nothing changes outside the windows.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ..errors import WalkError
from ..motion.clip import MotionClip
from ..motion.kinematics import as_quaternions, as_rotation
from .walk import Walk


@dataclass(frozen=True)
class SynthesisSettings:
    """How the gaps at the seams are closed.

    Attributes
    ----------
    blend_duration : float
        Seconds on each side of a seam; never more than half of a segment.
    """

    blend_duration: float = 0.25

    def __post_init__(self):
        if not (np.isfinite(self.blend_duration) and self.blend_duration >= 0):
            raise WalkError(f"A blend of {self.blend_duration} s cannot be made; give zero or more seconds.")


def synthesize(walk: Walk, settings: SynthesisSettings | None = None, name: str = "Walk") -> MotionClip:
    """The walk as a motion clip at the motion graph's frame rate.

    The root passes exactly along the walk's edited path (``walk.root_path``: the one that was checked against
    obstacles). Tags are those of the segments played.

    Raises
    ------
    WalkError
        The walk has no links.
    """
    settings = settings or SynthesisSettings()
    if len(walk) == 0:
        raise WalkError("The walk has no steps; ask for a longer duration.")
    graph = walk.embedding.graph
    skeleton = graph.clips[0].skeleton
    grounded = [_grounded(clip) for clip in graph.clips]
    n_frames, n_joints = walk.seams[-1] + 1, skeleton.n_joints
    rotations, translations = np.empty((n_frames, n_joints, 4)), np.empty((n_frames, n_joints, 3))
    tags = {tag: np.zeros(n_frames, dtype=bool) for s in graph.segments for tag in s.tags}
    played = [graph.segments[s] for s in walk.segments]
    for i, segment in enumerate(played):
        window = min(round(settings.blend_duration * graph.frame_rate), (segment.n_frames - 1) // 2)
        pose = _Pose.of(grounded[segment.clip], segment.first, segment.last)
        if window > 0 and i > 0:
            gap = _Gap.between(grounded, played[i - 1], segment, graph.frame_rate)
            pose.add(gap.correction(window, graph.frame_rate, after=True), slice(0, window + 1))
        if window > 0 and i + 1 < len(played):
            gap = _Gap.between(grounded, segment, played[i + 1], graph.frame_rate)
            pose.add(
                gap.correction(window, graph.frame_rate, after=False),
                slice(segment.n_frames - 1 - window, None),
            )
        frames = slice(walk.seams[i], walk.seams[i + 1] + 1)
        rotations[frames], translations[frames] = pose.rotations, pose.translations
        for tag, mask in segment.tags.items():
            tags[tag][frames] |= mask

    path = walk.root_path
    rotations[:, 0] = as_quaternions(_about_z(path[:, 2]) * as_rotation(rotations[:, 0]), (n_frames,))
    translations[:, 0, :2] = path[:, :2]
    return MotionClip(name, skeleton, graph.frame_rate, rotations, translations, tags, heading=path[:, 2])


def _about_z(angles: np.ndarray) -> Rotation:
    return Rotation.from_rotvec(angles[:, None] * [0.0, 0.0, 1.0])


def _grounded(clip: MotionClip) -> MotionClip:
    """The clip with its place and heading taken away: what is left of the root is its height and its tilt.

    Where the heading is steadier than the root, the tilt holds the sway of the hips.
    """
    rotations, translations = clip.rotations.copy(), clip.translations.copy()
    tilt = _about_z(-clip.ground_path[:, 2]) * as_rotation(rotations[:, 0])
    rotations[:, 0] = as_quaternions(tilt, (clip.n_frames,))
    translations[:, 0, :2] = 0.0
    return MotionClip(clip.name, clip.skeleton, clip.frame_rate, rotations, translations)


@dataclass
class _Pose:
    """Poses of some frames: rotations (F, J, 4) and translations (F, J, 3), with the root's tilt and height only."""

    rotations: np.ndarray
    translations: np.ndarray

    @classmethod
    def of(cls, clip: MotionClip, first: int, last: int) -> "_Pose":
        return cls(clip.rotations[first : last + 1].copy(), clip.translations[first : last + 1].copy())

    def add(self, correction: tuple[np.ndarray, np.ndarray], frames: slice) -> None:
        """Turn the joints by rotation vectors (in their own frames) and move them."""
        turn, move = correction
        turned = as_rotation(self.rotations[frames]) * Rotation.from_rotvec(turn.reshape(-1, 3))
        self.rotations[frames] = as_quaternions(turned, turn.shape[:2])
        self.translations[frames] += move


@dataclass
class _Gap:
    """What changes at a seam: (J, 3) rotation vectors and metres, and their rates per second."""

    turn: np.ndarray
    turn_rate: np.ndarray
    move: np.ndarray
    move_rate: np.ndarray

    @classmethod
    def between(cls, grounded: list[MotionClip], before, after, frame_rate: float) -> "_Gap":
        a, b = grounded[before.clip], grounded[after.clip]
        i, j = before.last, after.first
        turn = (as_rotation(a.rotations[i]).inv() * as_rotation(b.rotations[j])).as_rotvec()
        (turn_a, move_a), (turn_b, move_b) = _rates(a, i), _rates(b, j)
        return cls(turn, turn_b - turn_a, b.translations[j] - a.translations[i], move_b - move_a)

    def correction(self, window: int, frame_rate: float, after: bool) -> tuple[np.ndarray, np.ndarray]:
        """(window + 1, J, 3) rotation vectors and metres to add after the seam, or before it, in order of time.

        Both sides meet half way: value and slope at the seam are half of the gap's, and both are zero at the far end.
        """
        s = np.arange(window + 1)[:, None, None] / window
        value, slope = 2 * s**3 - 3 * s**2 + 1, (s**3 - 2 * s**2 + s) * window / frame_rate
        if after:
            return (
                -self.turn / 2 * value - self.turn_rate / 2 * slope,
                -self.move / 2 * value - self.move_rate / 2 * slope,
            )
        # Time runs towards the seam here: the spline is the mirror image, and its slope changes sign.
        turn = self.turn / 2 * value - self.turn_rate / 2 * slope
        move = self.move / 2 * value - self.move_rate / 2 * slope
        return turn[::-1], move[::-1]


def _rates(clip: MotionClip, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """(J, 3) angular velocity (rad/s, in the joints' own frames) and velocity (m/s) at a frame, by centred differences.

    Taken from the whole clip, so that a segment followed by its own continuation leaves no gap at all.
    """
    a, b = max(frame - 1, 0), min(frame + 1, clip.n_frames - 1)
    seconds = (b - a) / clip.frame_rate
    turn = (as_rotation(clip.rotations[a]).inv() * as_rotation(clip.rotations[b])).as_rotvec()
    return turn / seconds, (clip.translations[b] - clip.translations[a]) / seconds
