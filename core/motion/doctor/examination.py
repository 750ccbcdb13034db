"""The examination of clips, one by one and compared with each other."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ... import wording
from ...errors import ClipError
from ..clip import MotionClip
from ..contacts import Feet, foot_joints
from ..in_place import missing_speed
from ..skeleton import Skeleton
from .finding import (
    Finding,
    FindingKind,
    Remedy,
    RemedyKind,
    bones_in_words,
    in_words,
    source_frames,
    without_frames,
)
from .frozen import frozen_joints, lost_root
from .pops import PopSettings, pops
from .posture import posture_findings
from .rest_frames import rest_frames

_LOST = (FindingKind.REST_POSE, FindingKind.ROOT_LOST, FindingKind.FROZEN)
"""Kinds of lost data, at whose ends the motion jumps."""


@dataclass(frozen=True)
class DoctorSettings:
    """Thresholds of what counts as a defect.

    Attributes
    ----------
    min_segment_duration : float
        Seconds; shorter clips cannot hold a segment of a motion graph.
    pops : PopSettings
    in_place_speed : float
        Statures per second at which the ground slides under the standing feet of a clip on the spot.
    proportions : float
        Relative difference of bone lengths from which two characters do not share motions.
    feet : pair of tuple of str, optional
        Bone names of the left and right foot, ankle first, then toes; guessed if not given.
    """

    min_segment_duration: float = 0.9
    pops: PopSettings = field(default_factory=PopSettings)
    in_place_speed: float = 0.12
    proportions: float = 0.05
    feet: Feet | None = None


def examine(clip: MotionClip, settings: DoctorSettings | None = None) -> tuple[Finding, ...]:
    """Find what is wrong with a clip, in order of time.

    Looks for rest poses before and after the motion, channels and roots frozen or without data, pops, legs that
    walk while the root stays, characters that lie, are no person's size, face elsewhere than they go or
    stand off the floor, and clips too short to hold a segment. The clip is not changed.
    """
    settings = settings or DoctorSettings()
    found = list(posture_findings(clip))
    if any(finding.kind is FindingKind.LYING for finding in found):
        return tuple(found)  # what lies has no heading that the others could go by
    found += [*_lost_data(clip, settings), *_in_place(clip, settings)]
    found += _pops(clip, settings, [finding.frames for finding in found if finding.kind in _LOST])
    if clip.duration < settings.min_segment_duration - 1e-9:
        sentence = (
            f"Clip '{clip.name}' lasts {wording.time(clip.duration)}, less than one segment of "
            f"{wording.exact(settings.min_segment_duration)} s; drop it or shorten Min Segment."
        )
        found.append(_of_the_whole(clip, FindingKind.TOO_SHORT, (), sentence))
    return tuple(sorted(found, key=lambda finding: finding.frames))


def examine_all(clips: Sequence[MotionClip], settings: DoctorSettings | None = None) -> tuple[Finding, ...]:
    """Examine each clip, and find those that are of another skeleton than most.

    Same names and hierarchy, but bones of another length, is a finding of its own kind: such clips can be linked,
    but their feet slide.
    """
    settings = settings or DoctorSettings()
    found = [finding for clip in clips for finding in examine(clip, settings)]
    if not clips:
        return ()
    # Each clip by the first one of its skeleton.
    labels = [next(i for i, other in enumerate(clips) if clip.skeleton.is_like(other.skeleton)) for clip in clips]
    usual = Counter(labels).most_common(1)[0][0]
    alike = [clip for clip, label in zip(clips, labels, strict=True) if label == usual]
    lengths = np.array([_bone_lengths(clip.skeleton) for clip in alike])
    typical = np.median(lengths, axis=0)
    found += [_other_skeleton(clip, alike[0]) for clip, label in zip(clips, labels, strict=True) if label != usual]
    for clip, own in zip(alike, lengths, strict=True):
        found += _other_proportions(clip, own, typical, settings)
    names = [clip.name for clip in clips]
    return tuple(sorted(found, key=lambda finding: (names.index(finding.clip), finding.frames)))


def _lost_data(clip: MotionClip, settings: DoctorSettings) -> list[Finding]:
    found = []
    for first, last in rest_frames(clip):
        what = f"is in its rest pose or a T-pose at {source_frames(clip, first, last)} and then jumps"
        found.append(_cut_out(clip, settings, FindingKind.REST_POSE, first, last, (), what))
    taken = [finding.frames for finding in found]
    for first, last in lost_root(clip):
        if not _covered(first, last, taken, 0):
            what = f"loses its root at {source_frames(clip, first, last)}: it stays at one place and then jumps"
            joints = clip.skeleton.names[:1]
            found.append(_cut_out(clip, settings, FindingKind.ROOT_LOST, first, last, joints, what))
    for first, last, joints in frozen_joints(clip):
        if not _covered(first, last, taken, 0):
            names = tuple(clip.skeleton.names[joint] for joint in joints)
            what = f"has no motion in {bones_in_words(names)} at {source_frames(clip, first, last)}, then a jump"
            found.append(_cut_out(clip, settings, FindingKind.FROZEN, first, last, names, what))
    return found


def _pops(clip: MotionClip, settings: DoctorSettings, taken: list[tuple[int, int]]) -> list[Finding]:
    found = []
    for first, last, joints in pops(clip, settings.pops):
        # The jump at either end of lost data is no finding of its own.
        if not _covered(first, last, taken, 2):
            names = tuple(clip.skeleton.names[joint] for joint in joints)
            what = f"pops at {source_frames(clip, first, last)}: {bones_in_words(names)} "
            what += "jumps" if len(names) == 1 else "jump"
            found.append(_cut_out(clip, settings, FindingKind.POP, first, last, names, what))
    return found


def _in_place(clip: MotionClip, settings: DoctorSettings) -> list[Finding]:
    try:
        feet = foot_joints(clip.skeleton, settings.feet)
        path = clip.ground_path
    except ClipError:
        return []  # it takes feet and a heading
    # Seen from the character, and without regard to sway or to a jump.
    steps = np.diff(path[:, 0] + 1j * path[:, 1]) * np.exp(-1j * path[:-1, 2]) * clip.frame_rate
    travelled = float(np.hypot(np.median(steps.real), np.median(steps.imag)))
    least = settings.in_place_speed * clip.skeleton.stature
    try:
        missing = missing_speed(clip, settings.feet)
    except ClipError as error:
        # The feet are never seen to stand: do they run nevertheless, while the root stays?
        ankles = clip.world[1][:, [foot[0] for foot in feet], :2] - path[:, None, :2]
        passing = float(np.median(np.linalg.norm(np.diff(ankles, axis=0), axis=2))) * clip.frame_rate
        if passing < least or travelled > 0.2 * passing:
            return []
        return [_of_the_whole(clip, FindingKind.IN_PLACE, clip.skeleton.names[:1], str(error))]
    if missing < least or travelled > 0.2 * missing:
        return []
    sentence = (
        f"Clip '{clip.name}' walks on the spot: at {source_frames(clip, 0, clip.n_frames - 1)} its feet slide at "
        f"{wording.speed(missing)} and its root does not travel; synthesise root motion from its standing feet."
    )
    return [_of_the_whole(clip, FindingKind.IN_PLACE, clip.skeleton.names[:1], sentence, RemedyKind.ROOT_MOTION)]


def _cut_out(
    clip: MotionClip,
    settings: DoctorSettings,
    kind: FindingKind,
    first: int,
    last: int,
    joints: tuple[str, ...],
    what: str,
) -> Finding:
    """A finding whose remedy is to leave out its frames."""
    min_frames = round(settings.min_segment_duration * clip.frame_rate) + 1
    remedy = without_frames(clip, first, last, min_frames)
    return Finding(
        clip.name, kind, (first, last), joints, f"Clip '{clip.name}' {what}; {in_words(clip, remedy)}.", remedy
    )


def _of_the_whole(
    clip: MotionClip, kind: FindingKind, joints: tuple[str, ...], sentence: str, remedy: RemedyKind = RemedyKind.DROP
) -> Finding:
    return Finding(clip.name, kind, (0, clip.n_frames - 1), joints, sentence, Remedy(remedy))


def _covered(first: int, last: int, taken: list[tuple[int, int]], margin: int) -> bool:
    return any(first >= a - margin and last <= b + margin for a, b in taken)


def _bone_lengths(skeleton: Skeleton) -> np.ndarray:
    """(J - 1,) metres from each joint to its parent in the rest pose."""
    return np.linalg.norm(skeleton.rest_translations[1:], axis=1)


def _other_skeleton(clip: MotionClip, usual: MotionClip) -> Finding:
    ours, theirs = usual.skeleton, clip.skeleton
    missing = tuple(name for name in ours.names if name not in theirs.names)
    added = tuple(name for name in theirs.names if name not in ours.names)
    if missing:
        problem = f"it lacks {bones_in_words(missing)}"
    elif added:
        problem = f"it has {bones_in_words(added)} besides"
    else:
        problem = "its bones are arranged otherwise"
    sentence = f"Clip '{clip.name}' is of another skeleton than '{usual.name}': {problem}; drop it or retarget it."
    return _of_the_whole(clip, FindingKind.OTHER_SKELETON, missing or added, sentence)


def _other_proportions(
    clip: MotionClip, own: np.ndarray, typical: np.ndarray, settings: DoctorSettings
) -> list[Finding]:
    # Relative differences of very short bones say nothing.
    share = np.abs(own - typical) / np.maximum(typical, 0.05 * clip.skeleton.stature)
    off = np.flatnonzero(share > settings.proportions)
    if len(off) == 0:
        return []
    worst = int(off[np.argmax(share[off])])
    names = tuple(clip.skeleton.names[joint + 1] for joint in off)
    sentence = (
        f"Clip '{clip.name}' has a character of other proportions: bone '{clip.skeleton.names[worst + 1]}' is "
        f"{wording.small(own[worst])} long, and {wording.small(typical[worst])} in most clips; drop it or retarget it."
    )
    return [_of_the_whole(clip, FindingKind.OTHER_PROPORTIONS, names, sentence)]
