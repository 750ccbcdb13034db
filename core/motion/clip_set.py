"""Clips that go into one graph: of the same skeleton, under distinct names."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..errors import ClipError
from .clip import MotionClip


def check_skeletons(clips: Sequence[MotionClip]) -> None:
    """Raise ClipError unless there are clips and all can be mixed; the message names clip and bone."""
    if not clips:
        raise ClipError("There are no clips to build a motion graph from; choose at least one action.")
    reference = clips[0]
    for clip in clips[1:]:
        if clip.skeleton is reference.skeleton or clip.skeleton.is_like(reference.skeleton):
            continue
        ours, theirs = reference.skeleton, clip.skeleton
        added = [bone for bone in theirs.names if bone not in ours.names]
        missing = [bone for bone in ours.names if bone not in theirs.names]
        if added:
            problem = f"bone '{added[0]}', which '{reference.name}' lacks"
        elif missing:
            problem = f"no bone '{missing[0]}', which '{reference.name}' has"
        else:
            other_order = np.array(theirs.names) != np.array(ours.names)
            moved = np.flatnonzero(other_order | (theirs.parents != ours.parents))[0]
            problem = f"bone '{theirs.names[moved]}' at another place in the hierarchy than '{reference.name}'"
        raise ClipError(f"Clip '{clip.name}' is of another skeleton: it has {problem}. Leave it out or retarget it.")


def distinctly_named(clips: Sequence[MotionClip]) -> list[MotionClip]:
    """Return the clips, those whose name has been used before as "walk (2)"."""
    taken = {clip.name for clip in clips}
    used: set[str] = set()
    named = []
    for clip in clips:
        name, number = clip.name, 2
        while name in used:
            name = f"{clip.name} ({number})"
            number += 1
            if name in taken:
                name = clip.name
        used.add(name)
        named.append(clip if name == clip.name else replace(clip, name=name))
    return named
