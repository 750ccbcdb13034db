"""Fingerprints of motion: of everything that decides what a character does when it plays an action.

Two that are equal make the same clip; two that differ may do so too, such as those of keys between frames.
"""

from collections import Counter
from collections.abc import Mapping, Set
from functools import cache

import bpy
import numpy as np

from ..core.errors import ClipError
from .bridge.action_curves import ActionCurves, action_curves
from .bridge.read_actions import FRAME_RATE_PROPERTY
from .bridge.skeleton import FORWARD_PROPERTY
from .fingerprint import fingerprint

_STRAIGHT = 1
"""Interpolations up to this value, constant and linear, know no handles."""

_BEZIER = 2
"""The interpolation of this value knows handles; those beyond know how they ease."""

_SHOWN = {"active", "name", "show_expanded", "rna_type"}
"""Values of constraints and modifiers that make no difference to what they do."""


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
    if _is_constrained(character):
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
    return [*parts, *(_values(modifier) for modifier in curve.modifiers)]


def _other_curves(curves: ActionCurves) -> list:
    """Curves of the slot that are no transforms: influences and properties, by which constraints may go."""
    known = {curve.as_pointer() for curve in (*curves.bones.values(), *curves.placement.values())}
    bags = [strip.channelbag(curves.slot) for layer in curves.action.layers for strip in layer.strips]
    found = [curve for bag in bags if bag is not None for curve in bag.fcurves]
    return [curve for curve in found if curve.as_pointer() not in known and not curve.mute]


def _is_constrained(character) -> bool:
    return len(character.constraints) > 0 or any(len(bone.constraints) for bone in character.pose.bones)


def _rig_fingerprint(character, actions) -> str:
    """Of the character's bones, what moves them besides keys, its size and which way is up for it.

    Not of its place and heading, which change with every walk.
    """
    if character is None:
        return ""
    bones, posed = character.data.bones, character.pose.bones
    moving = _moving_paths(character, actions)
    constraints = [(owner.name, constraint) for owner in (character, *posed) for constraint in owner.constraints]
    parts = [
        [(bone.name, bone.parent.name if bone.parent else "") for bone in bones],
        [(b.use_connect, b.use_inherit_rotation, b.inherit_scale, b.use_local_location, b.use_deform) for b in bones],
        [bone.rotation_mode for bone in posed],
        *_body_parts(character),
        [(owner, _values(constraint, constraint.path_from_id(), moving)) for owner, constraint in constraints],
    ]
    for curve in (*_drivers(character), *_drivers(character.data)):
        parts += _driver_parts(curve, character, moving)
    if not any(_turns_object(character, action) for action in actions):
        up = character.matrix_world.to_3x3().normalized().row[2]
        parts.append((np.round(up, 3) + 0.0).tolist())
    return fingerprint(*parts)


def _body_parts(character) -> list:
    """The character's rest pose, which way is forward in it, and its size."""
    matrices = np.empty(16 * len(character.data.bones), dtype=np.float32)
    character.data.bones.foreach_get("matrix_local", matrices)
    sizes = [f"{factor:.4g}" for factor in character.matrix_world.to_scale()]
    return [matrices, tuple(character.get(FORWARD_PROPERTY, ())), sizes]


def _turns_object(character, action) -> bool:
    """Whether an action turns the character as a whole: then it may tilt as it plays."""
    try:
        return any(name.startswith("rotation") for name, _ in action_curves(character, action).placement)
    except ClipError:
        return False


def _drivers(data) -> list:
    return list(data.animation_data.drivers) if data.animation_data else []


def _moving_paths(character, actions) -> frozenset[str]:
    """Data paths of the properties that are driven, or that actions move: their present values say nothing, since they
    differ from frame to frame. The curves and the drivers say it all.
    """
    paths = {curve.data_path for curve in _drivers(character) if not curve.mute}
    if _is_constrained(character):
        for action in actions:
            try:
                paths.update(curve.data_path for curve in _other_curves(action_curves(character, action)))
            except ClipError:
                continue
    return frozenset(paths)


def _driver_parts(curve, character, moving: Set[str]) -> list:
    """Everything that decides what a driver does, but for what moves with the frame."""
    driver = curve.driver
    targets = [target for variable in driver.variables for target in variable.targets]
    return [
        (curve.data_path, curve.array_index, curve.mute, driver.type, driver.expression, driver.use_self),
        [(variable.name, variable.type, _plain(variable.targets)) for variable in driver.variables],
        [_custom_value(character, target.data_path) for target in targets if _is_custom(target, character, moving)],
        *_curve_parts(curve),
    ]


def _is_custom(target, character, moving: Set[str]) -> bool:
    """Whether a driver's target is a custom property of the character, such as a switch of its rig, that stands."""
    return target.id == character and target.data_path.endswith('"]') and target.data_path not in moving


def _custom_value(character, path: str):
    try:
        return _plain(character.path_resolve(path))
    except ValueError:
        return ""


def _values(thing, path: str = "", moving: Set[str] = frozenset()) -> list:
    """The settings of a constraint or a modifier of a curve, with the names of what they refer to, but for those whose
    data path is among the ``moving``.
    """
    names = [name for name in _settings(type(thing)) if f"{path}.{name}" not in moving]
    return [(thing.type, *((name, _plain(getattr(thing, name), f"{path}.{name}", moving)) for name in names))]


@cache
def _settings(kind: type) -> tuple[str, ...]:
    properties = kind.bl_rna.properties
    return tuple(
        prop.identifier
        for prop in properties
        if prop.identifier not in _SHOWN and (not prop.is_readonly or prop.type == "COLLECTION")
    )


def _plain(value, path: str = "", moving: Set[str] = frozenset()):
    """A value of a property as one that can be told from others by its text."""
    if isinstance(value, bpy.types.bpy_prop_collection):
        return [
            [(name, _plain(getattr(item, name))) for name in _settings(type(item)) if f"{own}.{name}" not in moving]
            for own, item in ((f"{path}[{place}]", item) for place, item in enumerate(value))
        ]
    if isinstance(value, bpy.types.ID):
        return _named(value)
    if isinstance(value, set):
        return sorted(value)
    if isinstance(value, bpy.types.bpy_struct):
        return ""
    return list(map(_plain, value)) if hasattr(value, "__len__") and not isinstance(value, str) else value


def _named(block) -> str:
    return block.name if block is not None else ""
