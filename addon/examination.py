"""What the clip doctor said about each action, and saying it."""

from dataclasses import dataclass

from ..core.errors import ClipError
from ..core.motion.clip import MotionClip
from ..core.motion.doctor import DoctorSettings, Finding, Remedy, RemedyKind, examine


@dataclass(frozen=True)
class ClipHealth:
    """What is known about one action since it was examined.

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
    def is_healthy(self) -> bool:
        return not self.findings and not self.problem

    @property
    def sentences(self) -> list[str]:
        """All that there is to say, for the artist."""
        return [self.problem] if self.problem else [finding.sentence for finding in self.findings]

    @property
    def treatments(self) -> list[tuple[str, str, str]]:
        """For each finding its title, its sentence, and what its remedy's button says."""
        return [
            (finding.kind.value.title(), finding.sentence, self._remedy_label(finding.remedy))
            for finding in self.findings
        ]

    def frame_range(self, kept: tuple[int, int]) -> tuple[float, float]:
        """Frame numbers of the action that a range of samples stands for."""
        return self.first_frame + kept[0], self.first_frame + kept[1]

    def _remedy_label(self, remedy: Remedy) -> str:
        if remedy.kind is RemedyKind.TRIM:
            first, last = self.frame_range(remedy.kept[0])
            return f"Trim to Frames {first:g}-{last:g}"
        if remedy.kind is RemedyKind.SPLIT:
            return f"Split into {len(remedy.kept)} Clips"
        return "Drop Clip" if remedy.kind is RemedyKind.DROP else "Synthesise Root Motion"


def clip_health(clip: MotionClip, settings: DoctorSettings) -> ClipHealth:
    """Examine one clip, exactly as it was read.

    On its own: all actions of one armature have the same skeleton, so that comparing them would find nothing.
    """
    try:
        return ClipHealth(examine(clip, settings), clip.first_frame)
    except ClipError as error:
        return ClipHealth(problem=str(error))
