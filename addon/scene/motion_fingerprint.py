"""Fingerprints of motion: of everything that decides what a character does when it plays an action.

Two that are equal make the same clip; two that differ may do so too, such as those of keys between frames.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping

import bpy
import numpy as np

from ...core.errors import ClipError
from ..bridge.action_curves import ActionCurves, action_curves
from ..bridge.read_actions import FRAME_RATE_PROPERTY
from ..bridge.rig import FORWARD_PROPERTY
from ..bridge.rotation_modes import REST_CHANNELS
from .fingerprint import fingerprint, named, plain, setting_values, settings_of

_STRAIGHT = 1
"""Interpolations up to this value, constant and linear, know no handles."""

_BEZIER = 2
"""The interpolation of this value knows handles; those beyond know how they ease."""

_ON_SHAPES = {"CLAMP_TO", "FOLLOW_PATH", "SHRINKWRAP", "SPLINE_IK"}
"""Constraints that go by the shape of their target, not by its place alone."""

_PATH = ("use_path", "path_duration", "eval_time", "dimensions", "twist_mode", "use_path_follow", "use_path_clamp")
"""What else than its splines decides where a curve leads those who follow it."""


def actions_fingerprint(scene, known: Mapping[str, str] | None = None) -> str:
    """Of the character's rig and of what it plays of the actions in use, whatever they are called.

    ``known`` are the fingerprints of actions, by name, that were just taken.
    """
    used = scene.wayfarer.used_actions()
    # Two of one name there may be where one comes from another file; what is known may be of the one not in use.
    often = Counter(action.name for action in bpy.data.actions) if known else {}
    alone = {name: seen for name, seen in (known or {}).items() if often[name] == 1}
    actions = (alone.get(action.name) or action_fingerprint(scene, action) for action in used)
    return fingerprint(_rig_fingerprint(scene.wayfarer.character, used), *sorted(actions))


def action_fingerprint(scene, action) -> str:
    """Of what the scene's character plays of an action: its curves, frame range and tags, but not of its name; and of
    the character's size and rest pose, by which it goes as far as it does.
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
    for place, curve in (*curves.bones.items(), *curves.placement.items()):
        parts += [place, *_curve_parts(curve)]
    if _is_steered(character):
        for curve in _other_curves(curves):
            parts += [(curve.data_path, curve.array_index), *_curve_parts(curve)]
    return fingerprint(*parts)


def _curve_parts(curve) -> list:
    """Everything that decides the values of an f-curve."""
    points = curve.keyframe_points
    keys, interpolation = np.empty(2 * len(points), np.float32), np.empty(len(points), np.int32)
    points.foreach_get("co", keys)
    points.foreach_get("interpolation", interpolation)
    parts: list = [keys, interpolation, curve.extrapolation]
    highest = interpolation.max(initial=0)
    if highest > _STRAIGHT:
        handles = np.empty((2, 2 * len(points)), np.float32)
        points.foreach_get("handle_left", handles[0])
        points.foreach_get("handle_right", handles[1])
        parts.append(handles)
    if highest > _BEZIER:
        parts.append([(point.easing, point.amplitude, point.back, point.period) for point in points])
    if len(curve.sampled_points):
        samples = np.empty(2 * len(curve.sampled_points), np.float32)
        curve.sampled_points.foreach_get("co", samples)
        parts.append(samples)
    return [*parts, *(setting_values(modifier) for modifier in curve.modifiers)]


def _other_curves(curves: ActionCurves) -> list:
    """Curves of the slot that are no transforms: influences and properties, by which constraints and drivers may go."""
    known = {curve.as_pointer() for curve in (*curves.bones.values(), *curves.placement.values())}
    return [curve for curve in _slot_curves(curves.action, curves.slot) if curve.as_pointer() not in known]


def _slot_curves(action, slot) -> list:
    """All curves of an action's slot that play."""
    if action is None or slot is None:
        return []
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves if not curve.mute]


def _is_steered(character) -> bool:
    """Whether constraints or drivers have a say, so that curves of other things than transforms do."""
    return bool(_constraints(character) or _drivers(character) or _drivers(character.data))


class _Moving(dict):
    """Data paths of what moves with the frame, of each data-block: its present values say nothing. What moves it does:
    its curves and drivers.
    """

    def __missing__(self, block) -> frozenset[str]:
        self[block] = frozenset(curve.data_path for curve in _playing_curves(block))
        return self[block]


def _rig_fingerprint(character, actions) -> str:
    """Of the character's bones, what moves them besides keys, in the rig or outside, its size and which way is up.

    Not of its place and heading, which change with every walk.
    """
    if character is None:
        return ""
    bones, posed = character.data.bones, character.pose.bones
    moving = _Moving({character: _moving_paths(character, actions)})
    parts = [
        [(bone.name, bone.parent.name if bone.parent else "") for bone in bones],
        [(b.use_connect, b.use_inherit_rotation, b.inherit_scale, b.use_local_location, b.use_deform) for b in bones],
        [bone.rotation_mode for bone in posed],
        *_body_parts(character),
        _constraint_parts(character, moving),
    ]
    for curve in (*_drivers(character), *_drivers(character.data)):
        parts += _driver_parts(curve, character, moving)
    turned = any(path.startswith(("rotation_", "delta_rotation_")) for path in moving[character])
    if not turned and not any(_turns_object(character, action) for action in actions):
        up = _own_matrix(character).to_3x3().normalized().row[2]
        parts.append((np.round(up, 3) + 0.0).tolist())
    return fingerprint(*parts, *_outside_parts(character, moving))


def _body_parts(character) -> list:
    """The character's rest pose, which way is forward in it, and its size."""
    sizes = [f"{factor:.4g}" for factor in _own_matrix(character).to_scale()]
    # Whatever kind of value it is: one that is no direction is refused only where it is used.
    return [_rest_pose(character.data), plain(character.get(FORWARD_PROPERTY, ())), sizes]


def _rest_pose(armature) -> np.ndarray:
    matrices = np.empty(16 * len(armature.bones), dtype=np.float32)
    armature.bones.foreach_get("matrix_local", matrices)
    return matrices


def _own_matrix(character):
    """The character's world matrix; without its parents and constraints if those move it with the frame."""
    carried = len(character.constraints) > 0 or _parents_move(character)
    return character.matrix_basis if carried else character.matrix_world


def _turns_object(character, action) -> bool:
    """Whether an action turns the character as a whole: then it may tilt as it plays."""
    try:
        return any(name.startswith("rotation") for name, _ in action_curves(character, action).placement)
    except ClipError:
        return False


def _drivers(block) -> list:
    animation = getattr(block, "animation_data", None)
    return list(animation.drivers) if animation else []


def _strips(animation) -> list:
    """All strips of the NLA, those within others too."""
    found = [strip for track in animation.nla_tracks for strip in track.strips]
    for strip in found:  # which grows meanwhile
        found += strip.strips
    return found


def _playing_curves(block) -> list:
    """Curves of the actions, strips and drivers that move a data-block."""
    animation = getattr(block, "animation_data", None)
    if not animation:
        return []
    played = [(animation.action, animation.action_slot)]
    played += [(s.action, s.action_slot) for s in _strips(animation) if animation.use_nla and not s.mute]
    curves = [curve for action, slot in played for curve in _slot_curves(action, slot)]
    return [*curves, *(curve for curve in _drivers(block) if not curve.mute)]


def _constraints(block) -> list:
    """(owner's name, constraint) of an object and its bones."""
    posed = block.pose.bones if getattr(block, "pose", None) else ()
    return [(owner.name, constraint) for owner in (block, *posed) for constraint in getattr(owner, "constraints", ())]


def _constraint_parts(block, moving: _Moving) -> list:
    return [(owner, setting_values(each, each.path_from_id(), moving[block])) for owner, each in _constraints(block)]


def _moving_paths(character, actions) -> frozenset[str]:
    """Data paths of the character's properties that are driven, or that any of the actions in use moves."""
    paths = {curve.data_path for curve in _drivers(character) if not curve.mute}
    if _is_steered(character):
        for action in actions:
            try:
                paths.update(curve.data_path for curve in _other_curves(action_curves(character, action)))
            except ClipError:
                continue
    return frozenset(paths)


def _driver_parts(curve, character, moving: _Moving) -> list:
    """Everything that decides what a driver does, but for what moves with the frame."""
    driver = curve.driver
    targets = [target for variable in driver.variables for target in variable.targets]
    return [
        (curve.data_path, curve.array_index, curve.mute, driver.type, driver.expression, driver.use_self),
        [(variable.name, variable.type, plain(variable.targets)) for variable in driver.variables],
        [_standing_value(target, character, moving) for target in targets],
        *_curve_parts(curve),
    ]


def _standing_value(target, character, moving: _Moving):
    """The value that a driver's target reads, such as a switch of the rig, if it is one that stands until it is edited.

    Of the character that is custom properties only: its pose is what plays.
    """
    block, path = target.id, target.data_path
    whole = re.sub(r"\[\d+\]$|\.[wxyz]$", "", path)
    if block is None or not path or any(whole == each or whole.startswith(f"{each}.") for each in moving[block]):
        return ""
    try:
        if not whole.endswith('"]'):
            owner, _, name = whole.rpartition(".")
            known = (block.path_resolve(owner) if owner else block).bl_rna.properties.get(name)
            # What cannot be animated, such as the frame and world matrices, follows from what can.
            if block == character or known is None or known.is_readonly or not known.is_animatable or name == "matrix":
                return ""
        return plain(block.path_resolve(path))
    except (ValueError, AttributeError):
        return ""


def _outside_parts(character, moving: _Moving) -> list:
    """Of everything outside the rig that moves it: what its constraints and drivers refer to, parents that move, and
    whatever those hang from in turn; but for what moves with the frame.
    """
    seen = {character, character.data}
    waiting = [*_referred(character, moving), *_referred(character.data, moving)]
    if _parents_move(character):
        waiting += _above(character)
    parts = []
    for block in waiting:  # which grows meanwhile
        if block is not None and block not in seen:
            seen.add(block)
            parts += _block_parts(block, character, moving)
            waiting += [*_referred(block, moving), *_above(block)]
    return parts


def _above(block) -> list:
    """An object's parent, with the shape that it hangs from if that is a part of it."""
    parent = block.parent if isinstance(block, bpy.types.Object) else None
    return [] if parent is None else [parent] if block.parent_type == "OBJECT" else [parent, parent.data]


def _parents_move(thing) -> bool:
    above = thing.parent
    return above is not None and (bool(_playing_curves(above) or _constraints(above)) or _parents_move(above))


def _referred(block, moving: _Moving) -> Iterator:
    """What a data-block's constraints and drivers refer to."""
    for curve in _drivers(block):
        yield from (target.id for variable in curve.driver.variables for target in variable.targets)
    for _, constraint in _constraints(block):
        if constraint.mute and f"{constraint.path_from_id()}.mute" not in moving[block]:
            continue
        for holder in (constraint, *getattr(constraint, "targets", ())):
            for target in (getattr(holder, name) for name in settings_of(type(holder))):
                if isinstance(target, bpy.types.ID):
                    yield target
                if isinstance(target, bpy.types.Object) and (
                    constraint.type in _ON_SHAPES or getattr(holder, "subtarget", "") or target.type == "ARMATURE"
                ):
                    yield target.data


def _block_parts(block, character, moving: _Moving) -> list:
    """What a data-block outside the rig is by itself, and how it moves."""
    parts: list = []
    for curve in _playing_curves(block):
        parts += [(curve.data_path, curve.array_index), *_curve_parts(curve)]
    for curve in _drivers(block):
        parts += _driver_parts(curve, character, moving)
    if animation := getattr(block, "animation_data", None):
        parts.append((animation.use_nla, [(track.mute, track.is_solo) for track in animation.nla_tracks]))
        parts.append((animation.action_blend_type, animation.action_extrapolation, animation.action_influence))
        parts += [setting_values(s, "", {f".{curve.data_path}" for curve in s.fcurves}) for s in _strips(animation)]
    if isinstance(block, bpy.types.Object):
        parts += [
            _channels(block),
            (block.rotation_mode, named(block.parent), block.parent_type, block.parent_bone),
            (list(block.parent_vertices), plain(block.matrix_parent_inverse)),
            _constraint_parts(block, moving),
            *(_pose_parts(block) if block.pose else ()),
        ]
    elif isinstance(block, bpy.types.Armature):
        parts.append(_rest_pose(block))
    elif isinstance(block, bpy.types.Action):
        for slot in block.slots:
            for curve in _slot_curves(block, slot):
                parts += [(slot.identifier, curve.data_path, curve.array_index), *_curve_parts(curve)]
    elif isinstance(block, bpy.types.Mesh):
        places = np.empty(3 * len(block.vertices), np.float32)
        block.vertices.foreach_get("co", places)
        parts.append(places)
    elif isinstance(block, bpy.types.Curve):
        parts.append([(name, getattr(block, name)) for name in _PATH if name not in moving[block]])
        parts.append(plain(block.splines))
    return parts


def _channels(block) -> list:
    """An object's transform channels, but for the components that move."""
    moved = {(curve.data_path, curve.array_index) for curve in _playing_curves(block)}
    names = [*REST_CHANNELS, *(f"delta_{name}" for name in REST_CHANNELS if name != "rotation_axis_angle")]
    return [
        (name, [None if (name, index) in moved else value for index, value in enumerate(getattr(block, name))])
        for name in names
    ]


def _pose_parts(block) -> list:
    """The pose of another armature, but for the components that move."""
    bones = block.pose.bones
    places = {f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"]': place for place, bone in enumerate(bones)}
    pose = {name: np.empty(len(bones) * len(rest), np.float32) for name, rest in REST_CHANNELS.items()}
    for name, values in pose.items():
        bones.foreach_get(name, values)
    for curve in _playing_curves(block):
        owner, _, name = curve.data_path.rpartition(".")
        if owner in places and name in pose and curve.array_index < len(REST_CHANNELS[name]):
            pose[name][places[owner] * len(REST_CHANNELS[name]) + curve.array_index] = 0.0
    return [[bone.rotation_mode for bone in bones], *pose.values()]
