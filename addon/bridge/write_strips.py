"""A walk as strips in the NLA editor: an action for each segment, laid end to end."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import WalkError
from ...core.motion.clip import MotionClip
from .carriers import find_carriers
from .owned import WALK_PROPERTY
from .rig import RigBinding, bind_rig, placement_obstacle
from .tags import write_tags
from .write_action import (
    Placements,
    at_scene_rate,
    bone_channels,
    carried_placements,
    keyed_bones,
    object_channels,
    stash_assigned,
    write_channels,
)

_PLACE_PROPERTY = "wayfarer_placement"
"""Custom property of an armature object that strips place: where it stood before, as its 16 basis matrix entries."""


def strip_cuts(clip: MotionClip, seams: np.ndarray) -> np.ndarray:
    """(n + 1,) frames of the scene at which the strips of a motion begin, and the last one ends.

    WalkError if one of them would be shorter than a frame of the scene.
    """
    resampled = at_scene_rate(clip)
    frames = np.rint(np.asarray(seams) * resampled.frame_rate / clip.frame_rate).astype(int)
    cuts = np.minimum(frames, resampled.n_frames - 1)
    if np.any(np.diff(cuts) < 1):
        raise WalkError("A segment of the walk is shorter than one frame of the scene; raise the scene's frame rate.")
    return cuts


def write_strips(
    armature_object,
    clip: MotionClip,
    seams: Sequence[int] | np.ndarray,
    names: Sequence[str],
    track_name: str = "Wayfarer Walk",
    first_frame: int = 1,
    binding: RigBinding | None = None,
) -> bpy.types.NlaTrack:
    """Lay ``clip``, the motion of a walk, on a new NLA track of ``armature_object``, a strip for each segment.

    Each strip has an action of its own: the blended motion between two seams, seen from where the segment starts, and
    one key of the armature object's location and rotation, which is where that is. So whatever the strips show end to
    end is exactly the clip, a pose can be edited in one strip alone, and a strip is moved or turned as a whole by
    editing that key. Where the object's own keys cannot say where it stands (it is constrained, or its parent is
    animated), the bones hold the whole way; so they do, with a key of the object on every frame, where the character's
    actions carry it by the object.

    The strips replace what lies below them, and earlier ones of the same name must be gone (:func:`remove_strips`).
    An action assigned to the object, which would hide them, is put on a muted stash track. No action is changed.

    Parameters
    ----------
    clip : MotionClip
        At any frame rate; it is resampled to the scene's, and cut at the frames nearest to the seams.
    seams : n + 1 frames of the clip
        Where the segments start and end: the first is 0, the last the last frame.
    names : n strings
        What the strips and their actions are called, after a number.
    first_frame : int
        Frame of the scene where the first strip starts.

    Raises
    ------
    WalkError
        The seams are not those of the clip.
    ClipError
        For the reasons of :func:`.write_action.write_clip`.
    """
    seams = np.asarray(seams)
    if len(seams) != len(names) + 1 or seams[0] != 0 or seams[-1] != clip.n_frames - 1 or np.any(np.diff(seams) < 1):
        raise WalkError(
            f"The seams do not cut the {clip.n_frames} frames of '{clip.name}' into {len(names)} strips; give those "
            "of the walk that the motion was made of."
        )
    binding = binding or bind_rig(armature_object)
    cuts, clip = strip_cuts(clip, seams), at_scene_rate(clip)
    # The frame of a seam belongs to both strips.
    lengths = np.diff(cuts) + 1
    starts = np.cumsum(lengths) - lengths
    frames = np.concatenate([np.arange(a, b + 1) for a, b in pairwise(cuts)])
    played = replace(clip, heading=clip.ground_path[:, 2]).taken(frames)

    carriers = find_carriers(armature_object, binding)
    keys = carriers.object_keys
    if not carriers.object_moves and not placement_obstacle(armature_object):
        keys = {"location", "rotation"}
        moving = carried_placements(binding, played, replace(carriers, object_moves=keys))
        placements = _held(moving, np.repeat(starts, lengths))
        of_object = object_channels(armature_object, _held(moving, starts), keys, len(starts))
        of_object = {name: np.split(values, len(starts)) for name, values in of_object.items()}
        armature_object[_PLACE_PROPERTY] = [float(x) for row in armature_object.matrix_basis for x in row]
    else:
        placements = carried_placements(binding, played, carriers)
        of_object = object_channels(armature_object, placements, keys, played.n_frames)
        of_object = {name: np.split(values, starts[1:]) for name, values in of_object.items()}
    channels = bone_channels(binding, played, keyed_bones(armature_object, binding), carriers, placements)
    pieces = {key: np.split(values, starts[1:]) for key, values in channels.items()}

    animation = armature_object.animation_data_create()
    stash_assigned(animation)
    track = animation.nla_tracks.new()
    track.name = track_name
    digits = len(str(len(names)))
    for i, name in enumerate(names):
        title = f"{i + 1:0{digits}d} {name}"
        action = write_channels(
            armature_object,
            title,
            {key: piece[i] for key, piece in pieces.items()},
            {key: piece[i] for key, piece in of_object.items()},
        )
        write_tags(action, {tag: mask[starts[i] : starts[i] + lengths[i]] for tag, mask in played.tags.items()}, 1)
        action[WALK_PROPERTY] = armature_object.name
        strip = track.strips.new(title, int(first_frame + cuts[i]), action)
        strip.action_slot = action.slots[0]
        strip.extrapolation = "HOLD" if i == 0 else "HOLD_FORWARD"
    return track


def find_strips(armature_object, track_name: str = "Wayfarer Walk") -> list:
    """Return (track, strips) of earlier walks: tracks so named, and the strips in them that play what we baked.

    The name alone decides nothing: a track of the artist's may be called so, too.
    """
    animation, found = armature_object.animation_data, []
    for track in animation.nla_tracks if animation else ():
        ours = [strip for strip in track.strips if strip.action and WALK_PROPERTY in strip.action]
        if ours and track.name.split(".")[0] == track_name:
            found.append((track, ours))
    return found


def remove_strips(armature_object, track_name: str = "Wayfarer Walk") -> int:
    """Remove earlier strips (:func:`find_strips`), and the actions that nobody else uses; how many strips there were.

    Actions that the artist has renamed or given a fake user stay, and so do strips that the artist has added. The
    object goes back to where it stood before.
    """
    removed = 0
    for track, strips in find_strips(armature_object, track_name):
        own = [strip.action for strip in strips if strip.action.name.startswith(strip.name)]
        removed += len(strips)
        if len(strips) == len(track.strips):
            armature_object.animation_data.nla_tracks.remove(track)
        else:
            for strip in strips:
                track.strips.remove(strip)
        for action in own:
            if action.users == 0:
                bpy.data.actions.remove(action)
    if removed and _PLACE_PROPERTY in armature_object:
        entries = list(armature_object[_PLACE_PROPERTY])
        armature_object.matrix_basis = Matrix([entries[i : i + 4] for i in range(0, 16, 4)])
        del armature_object[_PLACE_PROPERTY]
    return removed


def _held(placements: Placements, frames: np.ndarray) -> Placements:
    """For each entry of ``frames`` the placement on that frame."""
    return Placements(placements.rotation[frames], placements.translation[frames], placements.scale)
