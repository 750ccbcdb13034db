"""The clip doctor: finds what is wrong with a clip before it spoils a motion graph, and proposes the remedy.

:func:`examine` and :func:`examine_all` only look; :func:`apply_remedy` gives a new clip and is called when the
artist asks for it.
"""

from .examination import DoctorSettings, examine, examine_all
from .finding import Finding, FindingKind, Remedy, RemedyKind, apply_remedy
from .health import ClipHealth, ClipMotion, clip_health, clip_motion, clip_motions

__all__ = [
    "ClipHealth",
    "ClipMotion",
    "DoctorSettings",
    "Finding",
    "FindingKind",
    "Remedy",
    "RemedyKind",
    "apply_remedy",
    "clip_health",
    "clip_motion",
    "clip_motions",
    "examine",
    "examine_all",
]
