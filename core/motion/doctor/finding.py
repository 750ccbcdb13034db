"""Findings and remedies of the clip doctor, as data."""

from dataclasses import dataclass, replace
from enum import Enum

from ...errors import ClipError
from ..clip import MotionClip
from ..in_place import with_root_motion


class FindingKind(Enum):
    """Defects of a clip; the values are for people."""

    REST_POSE = "rest pose"
    FROZEN = "frozen channels"
    ROOT_LOST = "lost root"
    POP = "pop"
    IN_PLACE = "no root motion"
    LYING = "lying"
    SIZE = "unusual size"
    ROOT_STAYS = "root stays"
    FACING = "wrong facing"
    FLOOR = "not on the floor"
    ODD_REST = "odd rest pose"
    TOO_SHORT = "too short"
    OTHER_SKELETON = "other skeleton"
    OTHER_PROPORTIONS = "other proportions"


class RemedyKind(Enum):
    """Ways to deal with a finding; the values are for people."""

    TRIM = "trim"
    SPLIT = "split"
    DROP = "drop the clip"
    ROOT_MOTION = "synthesise root motion"
    STAND = "stand the character upright"
    SCALE = "scale the character"
    LIFT = "move the character to the floor"
    FACE = "turn the character's forward direction"
    ROOT = "choose the root bone"
    BY_HAND = "mend the rest pose by hand"

    @property
    def is_for_character(self) -> bool:
        """True for what is done to the character, once for all its clips, instead of to one clip."""
        return self not in (RemedyKind.TRIM, RemedyKind.SPLIT, RemedyKind.DROP, RemedyKind.ROOT_MOTION)


@dataclass(frozen=True)
class Remedy:
    """Something to do with a clip, or with its character.

    Attributes
    ----------
    kind : RemedyKind
    kept : tuple of (int, int)
        TRIM: the one range of samples to keep, first and last, both included; SPLIT: the ranges that become
        clips of their own, in order of time; empty otherwise.
    values : tuple of float
        STAND: the quaternion (w, x, y, z) that turns the character in the world; SCALE: the factor; LIFT: metres to
        move it up; FACE: the direction, in the world, that the rest pose faces; empty otherwise.
    bone : str
        ROOT: the bone to choose; empty otherwise.
    """

    kind: RemedyKind
    kept: tuple[tuple[int, int], ...] = ()
    values: tuple[float, ...] = ()
    bone: str = ""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a clip.

    Attributes
    ----------
    clip : str
        The clip's name.
    kind : FindingKind
    frames : (int, int)
        First and last sample concerned, both included, counted from 0 at the start of the clip.
    joints : tuple of str
        The bones concerned; empty if it is the clip as a whole.
    sentence : str
        For the artist: what is wrong, in frames of the source, and what to do about it.
    remedy : Remedy
        Proposed; nothing is done about it until :func:`apply_remedy` is called.
    """

    clip: str
    kind: FindingKind
    frames: tuple[int, int]
    joints: tuple[str, ...]
    sentence: str
    remedy: Remedy


def apply_remedy(clip: MotionClip, remedy: Remedy) -> tuple[MotionClip, ...]:
    """Return the clips that are left of ``clip``: none (DROP), one, or the parts of a SPLIT, named "walk (part 1)".

    A remedy that a finding proposes counts in the samples of the clip that was examined: examine again before
    another one is applied. ClipError if the remedy's ranges do not lie in the clip, or if it is one of the character.
    """
    if remedy.kind.is_for_character:
        raise ClipError(f"To {remedy.kind.value} is to change the character of clip '{clip.name}', not the clip.")
    if remedy.kind is RemedyKind.DROP:
        return ()
    if remedy.kind is RemedyKind.ROOT_MOTION:
        return (with_root_motion(clip),)
    for first, last in remedy.kept:
        if not 0 <= first < last < clip.n_frames:
            raise ClipError(
                f"Clip '{clip.name}' has {clip.n_frames} samples and cannot be cut to {first}-{last}; examine it again."
            )
    if remedy.kind is RemedyKind.TRIM:
        return (trimmed(clip, *remedy.kept[0]),)
    return tuple(
        replace(trimmed(clip, first, last), name=f"{clip.name} (part {number})")
        for number, (first, last) in enumerate(remedy.kept, start=1)
    )


def trimmed(clip: MotionClip, first: int, last: int) -> MotionClip:
    """Return the samples ``first`` to ``last``, both included; ``first_frame`` goes with them."""
    return replace(clip.taken(slice(first, last + 1)), first_frame=clip.first_frame + first)


def without_frames(clip: MotionClip, first: int, last: int, min_frames: int) -> Remedy:
    """Return the remedy that leaves out samples ``first`` to ``last``, and every rest of less than ``min_frames``."""
    rests = [(0, first - 1), (last + 1, clip.n_frames - 1)]
    kept = tuple((a, b) for a, b in rests if b - a + 1 >= max(2, min_frames))
    if not kept:
        return Remedy(RemedyKind.DROP)
    return Remedy(RemedyKind.TRIM if len(kept) == 1 else RemedyKind.SPLIT, kept)


def source_frames(clip: MotionClip, first: int, last: int) -> str:
    """Name samples for people: "frame 12" or "frames 12-17", numbered as in the source."""
    start = round(clip.first_frame)
    return f"frame {start + first}" if first == last else f"frames {start + first}-{start + last}"


def in_words(clip: MotionClip, remedy: Remedy) -> str:
    """Put the remedy as the end of a sentence, in frames of the source."""
    ranges = " and ".join(source_frames(clip, *kept).removeprefix("frames ") for kept in remedy.kept)
    if remedy.kind is RemedyKind.TRIM:
        return f"trim it to frames {ranges}"
    if remedy.kind is RemedyKind.SPLIT:
        return f"split it into frames {ranges}"
    return "drop it" if remedy.kind is RemedyKind.DROP else "synthesise root motion from its standing feet"


def bones_in_words(names: tuple[str, ...]) -> str:
    """Name bones for people: "bone 'A'", "bones 'A' and 'B'", "bones 'A', 'B' and 3 more"."""
    if len(names) == 1:
        return f"bone '{names[0]}'"
    if len(names) == 2:
        return f"bones '{names[0]}' and '{names[1]}'"
    return f"bones '{names[0]}', '{names[1]}' and {len(names) - 2} more"
