"""Fingerprints of motion: of everything that decides what a character does when it plays an action.

Two that are equal make the same clip; two that differ may do so too, such as those of keys between frames.
"""

import contextlib
from collections import Counter
from collections.abc import Mapping

import bpy
import numpy as np

from ...core.errors import ClipError
from ..bridge.action_curves import action_curves
from ..bridge.read_actions import FRAME_RATE_PROPERTY
from ..bridge.rig import FORWARD_PROPERTY, ROOT_PROPERTY
from .fingerprint import fingerprint
from .settings_reader import SettingsReader, plain, playing_curves, rest_pose, slot_curves


def actions_fingerprint(scene, known: Mapping[str, str] | None = None) -> str:
    """Return that of the character's rig and of what it plays of the actions in use, whatever they are called.

    ``known`` are the fingerprints of actions, by name, that were just taken.
    """
    used = scene.wayfarer.used_actions()
    # Two of one name there may be where one comes from another file; what is known may be of the one not in use.
    often = Counter(action.name for action in bpy.data.actions) if known else {}
    alone = {name: seen for name, seen in (known or {}).items() if often[name] == 1}
    actions = (alone.get(action.name) or action_fingerprint(scene, action) for action in used)
    return fingerprint(_rig_fingerprint(scene.wayfarer.character, used), *sorted(actions))


def action_fingerprint(scene, action) -> str:
    """Return that of what the scene's character plays of an action: its curves, frame range and tags, but not its name;
    and of the character's size and rest pose, by which it goes as far as it does.
    """
    character = scene.wayfarer.character
    if character is None:
        return ""
    try:
        curves = action_curves(character, action)
    except ClipError as error:
        return str(error)
    parts = [
        *_body_parts(character),
        (action.use_frame_range, tuple(action.frame_range)),
        (action.get(FRAME_RATE_PROPERTY), scene.render.fps / scene.render.fps_base),
        (sorted((m.name, m.frame) for m in action.pose_markers), action.get("wayfarer_tags")),
    ]
    reader = SettingsReader(character, set())
    # Of properties too, by which constraints and drivers may go.
    for curve in slot_curves(action, curves.slot):
        parts += reader.curve(curve)
    return fingerprint(*parts)


def _rig_fingerprint(character, actions) -> str:
    """Return that of the character's bones, what moves them besides keys, in the rig or outside, its size and which way
    is up; not of its place and heading, which change with every walk.
    """
    if character is None:
        return ""
    bones, moving = character.data.bones, _moving(character, actions)
    reader = SettingsReader(character, moving)
    parts = [
        [(bone.name, bone.parent.name if bone.parent else "") for bone in bones],
        [(b.use_connect, b.use_inherit_rotation, b.inherit_scale, b.use_local_location, b.use_deform) for b in bones],
        [bone.rotation_mode for bone in character.pose.bones],
        *_body_parts(character),
        [(owner, reader.settings(constraint)) for owner, constraint in _constraints(character)],
    ]
    for curve in _drivers(character):
        parts += reader.driver(curve)
    # What is turned as a whole may tilt as it plays.
    if not any(path.startswith(("rotation_", "delta_rotation_")) for path, _ in moving):
        up = _own_matrix(character).to_3x3().normalized().row[2]
        parts.append((np.round(up, 3) + 0.0).tolist())
    if _parents_move(character):
        reader.referred += [character.parent, character.parent.data]
    read = {None, character, character.data}
    for block in reader.referred:  # which grows meanwhile
        if block not in read:
            read.add(block)
            parts += reader.block(block)
    return fingerprint(*parts)


def _body_parts(character) -> list:
    """Return the character's rest pose, which way is forward in it, which bone is its root, and its size."""
    sizes = [f"{factor:.4g}" for factor in _own_matrix(character).to_scale()]
    # Whatever kind of value it is: one that is no direction, or no bone, is refused only where it is used.
    chosen = [plain(character.get(name, ())) for name in (FORWARD_PROPERTY, ROOT_PROPERTY)]
    return [rest_pose(character.data), *chosen, sizes]


def _own_matrix(character):
    """Return the character's world matrix; without its parents and constraints if those move it with the frame."""
    carried = len(character.constraints) > 0 or _parents_move(character)
    return character.matrix_basis if carried else character.matrix_world


def _parents_move(thing) -> bool:
    above = thing.parent
    return above is not None and (bool(playing_curves(above) or _constraints(above)) or _parents_move(above))


def _drivers(character) -> list:
    """Return the drivers of the character and of its armature."""
    animated = (block.animation_data for block in (character, character.data))
    return [curve for animation in animated if animation for curve in animation.drivers]


def _constraints(block) -> list:
    """Return (owner's name, constraint) of an object and its bones."""
    posed = block.pose.bones if block.pose else ()
    return [(owner.name if owner != block else "", each) for owner in (block, *posed) for each in owner.constraints]


def _moving(character, actions) -> set[tuple[str, int]]:
    """Return data path and index of properties of the character that are driven, or that an action in use moves."""
    animation = character.animation_data
    curves = [curve for curve in (animation.drivers if animation else ()) if not curve.mute]
    for action in actions:
        with contextlib.suppress(ClipError):
            curves += slot_curves(action, action_curves(character, action).slot)
    return {(curve.data_path, curve.array_index) for curve in curves}
