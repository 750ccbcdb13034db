"""Results of a walk in the scene: an action, strips or a copy of the character, a curve, markers, and its numbers."""

import json
import re

import bpy
import numpy as np

from ...core.files import from_json
from ...core.motion.clip import MotionClip
from ...core.playback.walk import Walk
from ...core.playback.walk_motion import WalkMotion
from ..bridge.copies import add_copy, remove_copies, remove_if_empty
from ..bridge.owned import OUTPUT, WALK_PROPERTY, ensure_collection
from ..bridge.write_action import assign_action, keyed_channels, put_to_rest, walk_channels, write_clip
from ..bridge.write_strips import find_strips, remove_strips, strip_cuts, write_strips
from ..render.walk_curve import remove_walk_curve, walk_curve
from ..results.shown import keep_walk
from ..results.store import WalkNumbers, results

WALK_NAME = "Wayfarer Walk"
FIRST_FRAME = 1
COPY_COLLECTION = "Wayfarer Copy"

_MARKER = "Walk: "
"""Start of the names of timeline markers."""
_UNKNOWN_SLIDE = -1.0
"""Slide of feet that are not known."""


def bake_motion(scene, motion: WalkMotion) -> bpy.types.Action:
    """Bake a walk's motion, see :func:`bake_walk`, and show how good it is in the panel."""
    action = bake_walk(scene, motion.walk, motion.clip, motion.closed)
    _fill_report(scene, motion)
    return action


def bake_walk(scene, walk: Walk, clip: MotionClip, closed: bool = False) -> bpy.types.Action:
    """Bake a walk, synthesised as ``clip``, into what the scene's settings ask for, draw its path, set the timeline.

    Returns its action, the first of them if there is one for each segment. Earlier walks of the character are removed,
    but for those that the artist has use for. Nothing has changed if the motion does not fit the character.
    """
    found, character, settings = results(scene), scene.wayfarer.character, scene.wayfarer.walk
    output = settings.output
    if output == "STRIPS":
        action, last_frame = _bake_strips(character, walk, clip)
    elif output == "COPY":
        action = write_clip(character, clip, WALK_NAME, FIRST_FRAME)
        remove_copies(scene, COPY_COLLECTION)
        action.name = WALK_NAME
        add_copy(scene, COPY_COLLECTION, action, f"{character.name} Walk", walk_channels(character))
        last_frame = action.frame_range[1]
    else:
        action = _bake_action(character, clip)
        last_frame = action.frame_range[1]
    if output != "COPY":
        # Earlier walks go, in whatever form; a copy that the artist has moved elsewhere is no longer ours.
        remove_copies(scene, COPY_COLLECTION)
        remove_if_empty(scene, COPY_COLLECTION)
    if closed and output != "STRIPS":
        action.use_frame_range, action.use_cyclic = True, True
        action.frame_start, action.frame_end = FIRST_FRAME, last_frame
    if settings.draw_path:
        walk_curve(walk.root_path, found.ground_height, ensure_collection(scene, OUTPUT))
    else:
        remove_walk_curve(scene)
    # The last frame of a loop is the first of its next round.
    set_timeline(scene, int(np.ceil(last_frame)) - int(closed))
    _set_markers(scene, walk if settings.use_markers else None)
    settings.report.clear()
    length = float(np.linalg.norm(np.diff(walk.root_path[:, :2], axis=0), axis=1).sum())
    keep_walk(scene, walk, WalkNumbers(walk.duration, length, len(walk)), action)
    return action


def _fill_report(scene, motion: WalkMotion) -> None:
    """Put the quality of a walk where the panel shows it."""
    report, before, after = scene.wayfarer.walk.report, motion.before, motion.after
    report.clear()
    feet = before.feet_unknown or (motion.cleanup.describe() if motion.cleanup is not None else "Feet are not held.")
    report.feet = feet
    if after.feet:
        report.slide_before, report.slide_after = before.mean_slide, after.mean_slide
        report.slide_in_clips = sum(foot.source_mean for foot in after.feet) / len(after.feet)
    else:
        report.slide_before = report.slide_after = report.slide_in_clips = _UNKNOWN_SLIDE
    frames_per_sample = scene.render.fps / scene.render.fps_base / motion.walk.embedding.graph.frame_rate

    def frame_of(sample: int) -> int:
        return FIRST_FRAME + round(sample * frames_per_sample)

    if after.largest_gap is not None:
        report.gap, report.gap_joint = after.largest_gap.angle, after.largest_gap.joint
        report.gap_frame = frame_of(after.largest_gap.frame)
    report.edit, report.turn_edit = after.position_edit, after.heading_edit
    report.idle, report.turns_back = after.idle, after.turns_back
    for found in after.worst_frames:
        entry = report.worst.add()
        entry.frame, entry.what, entry.severity = frame_of(found.frame), found.what, found.severity
        entry.amount = found.amount


def set_timeline(scene, last_frame: int) -> None:
    """Play from the first frame to the last, and show the first."""
    scene.frame_start, scene.frame_end = FIRST_FRAME, max(last_frame, FIRST_FRAME)
    scene.frame_set(FIRST_FRAME)


def _bake_action(character, clip: MotionClip) -> bpy.types.Action:
    action, walked = write_clip(character, clip, clip.name, FIRST_FRAME), walk_channels(character)
    _claim_played(character)
    if find_strips(character):
        # They would move the object under the action; where it stands without them is known only now.
        remove_strips(character)
        bpy.context.view_layer.update()
        bpy.data.actions.remove(action)
        action = write_clip(character, clip, clip.name, FIRST_FRAME)
    _remove_earlier(character)
    action.name = WALK_NAME
    action[WALK_PROPERTY] = character.name
    assign_action(character, action)
    put_to_rest(character, walked - keyed_channels(character, [action]))
    return action


def _bake_strips(character, walk: Walk, clip: MotionClip) -> tuple[bpy.types.Action, float]:
    # Fails here, before anything is changed, if it is going to.
    strip_cuts(clip, walk.node_frames)
    bpy.data.actions.remove(write_clip(character, clip, clip.name, FIRST_FRAME))
    walked = walk_channels(character)
    _claim_played(character)
    remove_strips(character)
    _remove_earlier(character)
    bpy.context.view_layer.update()
    names = [walk.embedding.graph.segments[s].name for s in walk.segments]
    track = write_strips(character, clip, walk.node_frames, names, WALK_NAME, FIRST_FRAME)
    put_to_rest(character, walked - keyed_channels(character, [strip.action for strip in track.strips]))
    action = track.strips[0].action
    assert action is not None
    return action, track.strips[-1].frame_end


def _claim_played(character) -> None:
    """Write the character's name into the walks that only it plays: those of a copied or renamed one name another."""
    animation = character.animation_data
    if animation is None:
        return
    played = [animation.action, *(strip.action for track in animation.nla_tracks for strip in track.strips)]
    ours = [action for action in played if action is not None and WALK_PROPERTY in action and action.is_editable]
    for action in ours:
        if action.users <= played.count(action):
            action[WALK_PROPERTY] = character.name


def _remove_earlier(character) -> None:
    """Remove earlier walks of the character that nobody has use for."""
    for action in [action for action in bpy.data.actions if action.get(WALK_PROPERTY) == character.name]:
        if not _is_kept(action, character):
            bpy.data.actions.remove(action)


def _is_kept(action, character) -> bool:
    """Return True if the artist has use for an earlier walk: it has a fake user, another name, or other users."""
    assigned = character.animation_data is not None and character.animation_data.action == action
    ours = re.fullmatch(rf"{WALK_NAME}(\.\d+)?", action.name)
    return action.use_fake_user or ours is None or action.users > int(assigned)


def _known_markers(text: str) -> list[tuple[str, int]]:
    """Return names and frames of the markers that we set; none if the text, which a .blend file keeps, is damaged."""
    try:
        return [(name, frame) for name, frame in from_json(text or "[]")]
    except (ValueError, TypeError):
        return []


def _set_markers(scene, walk: Walk | None) -> None:
    """Mark the transitions of a walk; those of an earlier one go, as long as they are as they were set.

    Markers cannot carry a mark of their own in Blender 5: which ones are ours is written in the scene's settings.
    """
    settings, markers = scene.wayfarer.walk, scene.timeline_markers
    for name, frame in _known_markers(settings.markers):
        ours = next((marker for marker in markers if (marker.name, marker.frame) == (name, frame)), None)
        if ours is not None:
            markers.remove(ours)
    made = []
    if walk is not None:
        graph = walk.embedding.graph
        frames_per_sample = scene.render.fps / scene.render.fps_base / graph.frame_rate
        for start, segment in zip(walk.node_frames[:-1], walk.segments, strict=True):
            clip = graph.clips[graph.segments[segment].clip].name
            frame = FIRST_FRAME + round(float(start) * frames_per_sample)
            made.append((markers.new(_MARKER + clip, frame=frame).name, frame))
    settings.markers = json.dumps(made) if made else ""
