"""Motion clips of BVH files: on their own skeleton, or carried over to that of other files."""

from collections.abc import Generator
from pathlib import Path

import numpy as np

from ...progress import Progress, portion
from .. import quat
from ..clip import MotionClip
from ..retarget import Fit, fit_skeleton, lie_alike, retarget_steps
from .character import TO_Z_UP, BvhCharacter
from .file import BvhFile

_SAME_LENGTH = 0.01  # as a part of the hips' height
_BLOCK = 100_000  # joints times frames that are worked on at a time


def fit_character(own: BvhCharacter, other: BvhCharacter) -> Fit:
    """Find how motion of ``other`` moves ``own``; ClipError as for :func:`fit_skeleton`.

    Where they have the same joints, and the bones of both lie alike in their joints' axes, rotations are taken over.
    """
    order = _same_joints(own, other)
    if order is None:
        return fit_skeleton(own.skeleton, other.skeleton)
    own_offsets, other_offsets = own.skeleton.rest_translations, other.skeleton.rest_translations[order]
    fixed = np.setdiff1d(np.arange(len(order)), own.carriers)
    tolerance = _SAME_LENGTH * max(own.hip_height, 1e-9)
    no_turns = np.tile(quat.IDENTITY, (len(order), 1))
    is_same = not (np.linalg.norm(own_offsets - other_offsets, axis=1)[fixed] > tolerance).any()
    if is_same:
        return Fit(own.skeleton, order, no_turns, own.carriers, is_same=True)
    fit = fit_skeleton(own.skeleton, other.skeleton)
    if lie_alike(own_offsets[fixed], other_offsets[fixed], tolerance):
        return Fit(own.skeleton, order, no_turns, own.carriers, fit.ratio, fit.shift, reason="another size")
    return fit


def bvh_clip_steps(
    file: BvhFile, character: BvhCharacter, fit: Fit | None = None
) -> Generator[Progress, None, MotionClip]:
    """Make the clip of a file of ``character``, in metres, Z up: on its own skeleton, or on that of a fit.

    Rotations (F, J, 4) and translations (F, J, 3) are as in :class:`.clip.MotionClip`.

    Raises ClipError if the motion goes farther than any clip can.
    """
    up = TO_Z_UP[character.up]
    rotations = np.empty((file.n_frames, file.n_joints, 4))
    translations = np.empty((file.n_frames, file.n_joints, 3))
    block = max(_BLOCK // file.n_joints, 1)
    for start in range(0, file.n_frames, block):
        frames = slice(start, start + block)
        turned, placed = file.rotations(frames), character.unit * file.translations(frames)
        turned[:, 0], placed[:, 0] = quat.multiply(up, turned[:, 0]), quat.rotate(up, placed[:, 0])
        rotations[frames], translations[frames] = turned, placed
        yield Progress(0.5 * min(start + block, file.n_frames) / file.n_frames, f"Importing {file.name}")
    clip = MotionClip(
        name=Path(file.name).stem,
        skeleton=character.skeleton,
        frame_rate=file.frame_rate,
        rotations=rotations,
        translations=translations,
        first_frame=1.0,
    )
    if fit is None:
        return clip
    return (yield from portion(retarget_steps(clip, fit), 0.5, 1.0))


def _same_joints(own: BvhCharacter, other: BvhCharacter) -> np.ndarray | None:
    """Return the other's joint for each own one if both have the same tree of names."""

    def tree(character: BvhCharacter) -> dict[str, str]:
        names, parents = character.skeleton.names, character.skeleton.parents
        return {name: names[above] if above >= 0 else "" for name, above in zip(names, parents, strict=True)}

    if tree(own) != tree(other):
        return None
    return np.array([other.skeleton.names.index(name) for name in own.skeleton.names])
