"""Measures and findings of each action, as they are stored and shown."""

import contextlib
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...errors import ClipError
from ..clip import MotionClip
from .examination import DoctorSettings, examine
from .finding import Finding, Remedy, RemedyKind


@dataclass(frozen=True)
class ClipMotion:
    """The way that a clip goes.

    Attributes
    ----------
    distance : float
        Metres travelled over the ground.
    turn : float
        Radians between the first heading and the last, whole turns included; counter-clockwise is positive.
    """

    distance: float
    turn: float


def clip_motion(clip: MotionClip) -> ClipMotion:
    """Measure a clip; ClipError if it has no heading."""
    path = clip.ground_path
    distance = float(np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum())
    return ClipMotion(distance, float(path[-1, 2] - path[0, 2]))


def clip_motions(clips: Iterable[MotionClip]) -> dict[str, ClipMotion]:
    """Measure clips, by name; those that cannot be measured are left out."""
    motions = {}
    for clip in clips:
        with contextlib.suppress(ClipError):
            motions[clip.name] = clip_motion(clip)
    return motions


@dataclass(frozen=True)
class ClipHealth:
    """The state of one action when it was examined.

    Attributes
    ----------
    findings : tuple of Finding
    first_frame : float
        Frame number of the action that the findings' samples count from.
    problem : str
        Why the action could not be read, as a sentence; empty if it could.
    """

    findings: tuple[Finding, ...] = ()
    first_frame: float = 0.0
    problem: str = ""

    @property
    def doubts_character(self) -> bool:
        """True if the clip shows the character otherwise than it was understood."""
        return any(finding.remedy.kind.is_for_character for finding in self.findings)

    @property
    def is_healthy(self) -> bool:
        return not self.findings and not self.problem

    @property
    def sentences(self) -> list[str]:
        """List all that there is to say, for the artist."""
        return [self.problem] if self.problem else [finding.sentence for finding in self.findings]

    @property
    def treatments(self) -> list[tuple[str, str, str]]:
        """List for each finding its title, its sentence, and what its remedy's button says; empty if there is none."""
        return [
            (finding.kind.value.title(), finding.sentence, self._remedy_label(finding.remedy))
            for finding in self.findings
        ]

    def frame_range(self, kept: tuple[int, int]) -> tuple[float, float]:
        """Return the frame numbers of the action that a range of samples stands for."""
        return self.first_frame + kept[0], self.first_frame + kept[1]

    def _remedy_label(self, remedy: Remedy) -> str:
        if remedy.kind is RemedyKind.TRIM:
            first, last = self.frame_range(remedy.kept[0])
            return f"Trim to Frames {first:g}-{last:g}"
        if remedy.kind is RemedyKind.SPLIT:
            return f"Split into {len(remedy.kept)} Clips"
        if remedy.kind is RemedyKind.SCALE:
            return f"Scale Character by {remedy.values[0]:.3g}"
        if remedy.kind is RemedyKind.ROOT:
            return f"Choose '{remedy.bone}' as Root"
        return _LABELS[remedy.kind]


_LABELS = {
    RemedyKind.DROP: "Drop Clip",
    RemedyKind.ROOT_MOTION: "Synthesise Root Motion",
    RemedyKind.STAND: "Stand Character Upright",
    RemedyKind.LIFT: "Move Character to the Floor",
    RemedyKind.FACE: "Face Where the Body Does",
    RemedyKind.BY_HAND: "",
}


def clip_health(clip: MotionClip, settings: DoctorSettings) -> ClipHealth:
    """Examine one clip, exactly as it was read.

    On its own: all actions of one armature have the same skeleton, so that comparing them would find nothing.
    """
    try:
        return ClipHealth(examine(clip, settings), clip.first_frame)
    except ClipError as error:
        return ClipHealth(problem=str(error))
