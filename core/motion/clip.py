"""A motion clip: one recorded motion, sampled at a constant rate."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from .. import wording
from ..errors import ClipError
from . import quat
from .kinematics import FARTHEST, are_positions, world_transforms
from .skeleton import Skeleton

SLOWEST_RATE, FASTEST_RATE = 0.1, 100_000.0
"""Frames per second: what is beyond them is a mistake, and would make a motion of no length, or of no end."""


@dataclass(frozen=True)
class MotionClip:
    """One recorded motion of a skeleton.

    Attributes
    ----------
    name : str
        The name of the action that it was read from.
    skeleton : Skeleton
    frame_rate : float
        Samples per second.
    rotations : (F, J, 4) float array
        Unit quaternions (w, x, y, z): the root's in world space, every other joint's relative to its parent
        (rest rotation included).
    translations : (F, J, 3) float array
        Joint positions in metres, in the same frames.
    tags : mapping of str to (F,) bool array
        For each tag, the frames that carry it.
    first_frame : float
        Frame number of the first sample in the source action, counted in samples of ``frame_rate``.
    heading : (F,) float array, optional
        Unwrapped heading in radians, where it is not that of the root's forward axis: see
        :func:`core.motion.heading.with_steady_heading`.
    """

    name: str
    skeleton: Skeleton
    frame_rate: float
    rotations: np.ndarray
    translations: np.ndarray
    tags: Mapping[str, np.ndarray] = field(default_factory=dict)
    first_frame: float = 0.0
    heading: np.ndarray | None = None

    def __post_init__(self):
        n_frames, n_joints = len(self.rotations), self.skeleton.n_joints
        if self.rotations.shape != (n_frames, n_joints, 4) or self.translations.shape != (
            n_frames,
            n_joints,
            3,
        ):
            raise ClipError(f"Clip '{self.name}' does not have one rotation and translation per frame and bone.")
        if n_frames < 2:
            raise ClipError(f"Clip '{self.name}' has {n_frames} frame; a motion needs at least two.")
        if not SLOWEST_RATE <= self.frame_rate <= FASTEST_RATE:
            raise ClipError(
                f"Clip '{self.name}' has a frame rate of {wording.exact(self.frame_rate)}; it must be between "
                f"{wording.exact(SLOWEST_RATE)} and {wording.exact(FASTEST_RATE)} frames per second."
            )
        if not (np.isfinite(self.rotations).all() and np.isfinite(self.translations).all()):
            bad = ~np.isfinite(self.rotations).all(axis=2) | ~np.isfinite(self.translations).all(axis=2)
            raise ClipError(
                f"Clip '{self.name}' holds a value that is not a number at {self._where(bad)}; repair or delete that "
                "key."
            )
        turned, placed = quat.are_rotations(self.rotations), are_positions(self.translations)
        if not turned.all():
            raise ClipError(
                f"Clip '{self.name}' holds a rotation that is none at {self._where(~turned)}; repair that key."
            )
        if not placed.all():
            raise ClipError(
                f"Clip '{self.name}' moves farther than {wording.amount(FARTHEST / 1000)} km at "
                f"{self._where(~placed)}; check the units of its source."
            )
        for tag, mask in self.tags.items():
            if np.shape(mask) != (n_frames,):
                raise ClipError(f"Clip '{self.name}': the tag '{tag}' needs one entry per frame.")
        if self.heading is not None and not (np.shape(self.heading) == (n_frames,) and np.isfinite(self.heading).all()):
            raise ClipError(f"Clip '{self.name}': the heading needs one angle per frame.")

    def _where(self, bad: np.ndarray) -> str:
        """Name the first place where the (F, J) mask is set, for people."""
        frame, joint = np.argwhere(bad)[0]
        return f"sample {frame}, bone '{self.skeleton.names[joint]}'"

    @property
    def n_frames(self) -> int:
        return len(self.rotations)

    @property
    def duration(self) -> float:
        """Seconds from the first to the last frame."""
        return (self.n_frames - 1) / self.frame_rate

    @cached_property
    def ground_path(self) -> np.ndarray:
        """(F, 3) x, y in metres and unwrapped heading in radians: the root projected on the ground.

        The heading is ``heading`` if that is given, that of the root's forward axis otherwise.
        """
        heading = self.root_heading if self.heading is None else self.heading
        return np.column_stack([self.translations[:, 0, :2], heading])

    @cached_property
    def root_heading(self) -> np.ndarray:
        """(F,) unwrapped heading of the root's forward axis in radians; ClipError where it points up or down."""
        forward = quat.rotate(self.rotations[:, 0], self.skeleton.forward)
        if np.any(np.hypot(forward[:, 0], forward[:, 1]) < 1e-3):
            raise ClipError(
                f"Clip '{self.name}': the forward axis of bone '{self.skeleton.names[0]}' points straight up or "
                "down, so that it has no heading; choose another forward axis or trim those frames."
            )
        return np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))

    @cached_property
    def world(self) -> tuple[np.ndarray, np.ndarray]:
        """World rotations (F, J, 4) and joint positions (F, J, 3) of every frame."""
        return world_transforms(self.rotations, self.translations, self.skeleton.parents)

    def taken(self, frames: slice | np.ndarray) -> "MotionClip":
        """Return some frames of the clip, one after the other; ``first_frame`` stays."""
        return replace(
            self,
            rotations=self.rotations[frames],
            translations=self.translations[frames],
            tags={tag: np.asarray(mask)[frames] for tag, mask in self.tags.items()},
            heading=None if self.heading is None else self.heading[frames],
        )

    def resampled(self, frame_rate: float) -> "MotionClip":
        """Return the motion at another rate; rotations by spherical interpolation, tags by the nearest frame."""
        if frame_rate == self.frame_rate:
            return self
        n_frames = int(np.floor(self.duration * frame_rate + 1e-6)) + 1
        if n_frames < 2:
            raise ClipError(
                f"Clip '{self.name}' lasts {wording.time(self.duration)}, less than one frame at "
                f"{wording.exact(frame_rate)} frames per second; drop it or raise Frame Rate."
            )
        times = np.minimum(np.arange(n_frames) / frame_rate, self.duration)
        before = np.minimum((times * self.frame_rate).astype(int), self.n_frames - 2)
        weight = (times * self.frame_rate - before)[:, None, None]
        rotations = quat.slerp(self.rotations[before], self.rotations[before + 1], weight)
        translations = self.translations[before] * (1 - weight) + self.translations[before + 1] * weight
        nearest = np.rint(times * self.frame_rate).astype(int)
        every = np.arange(self.n_frames)
        return replace(
            self,
            frame_rate=frame_rate,
            rotations=rotations,
            translations=translations,
            tags={tag: np.asarray(mask)[nearest] for tag, mask in self.tags.items()},
            first_frame=self.first_frame * frame_rate / self.frame_rate,
            heading=None if self.heading is None else np.interp(times * self.frame_rate, every, self.heading),
        )
