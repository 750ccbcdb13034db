"""Settings of data-blocks as plain values, and the data-blocks that they refer to."""

import re
from functools import cache

import bpy
import numpy as np

from ..bridge.rotation_modes import REST_CHANNELS

_DELTAS = tuple(f"delta_{name}" for name in REST_CHANNELS if name != "rotation_axis_angle")
_PARENT = ("parent", "parent_type", "parent_bone", "parent_vertices", "matrix_parent_inverse")
_PATH = ("use_path", "path_duration", "eval_time", "dimensions", "twist_mode", "use_path_follow", "use_path_clamp")

_READ = {
    "Object": (*REST_CHANNELS, *_DELTAS, "rotation_mode", *_PARENT, "constraints", "pose"),
    "Pose": ("bones",),
    "PoseBone": (*REST_CHANNELS, "rotation_mode", "constraints"),
    "Curve": (*_PATH, "splines"),
    "AnimData": ("use_nla", "nla_tracks", "action_blend_type", "action_extrapolation", "action_influence"),
    "NlaTrack": ("mute", "is_solo", "strips"),
    "Driver": ("type", "expression", "use_self", "variables"),
}
"""Settings that decide how things move, by type; all that can be set of those that are no data-blocks."""

_SHOWN = {"active", "name", "show_expanded", "rna_type", "select"}
_SHOWN |= {"select_control_point", "select_left_handle", "select_right_handle"}
"""Settings that make no difference to what a thing does."""

_ON_SHAPES = ("ClampToConstraint", "FollowPathConstraint", "ShrinkwrapConstraint", "SplineIKConstraint")
"""Constraints that go by the shape of their target, not by its place alone."""

_KEYS = {"co": 2, "interpolation": 1}
_BENT_KEYS = {"handle_left": 2, "handle_right": 2, "easing": 1, "amplitude": 1, "back": 1, "period": 1}
"""Number of components of what keys have, and of what only makes a difference to keys that are not straight."""

_STRAIGHT = 1
"""Interpolations up to this value, constant and linear, know neither handles nor easing."""


class SettingsReader:
    """Reads data-blocks, but for what moves with the frame: there the curves and drivers are read that move it.

    Attributes
    ----------
    referred : list of ID
        The data-blocks that were referred to by what was read.
    """

    def __init__(self, character, moving: set[tuple[str, int]]):
        """``moving`` are data path and index of what moves of the character."""
        self.referred: list = []
        self._moving = {character: moving}

    def settings(self, thing, follow: bool = True) -> list:
        """Return the settings of a thing by name, references too; they are noted if we ``follow``."""
        moving, path = self._moving_of(thing.id_data), _path_of(thing)
        follow = follow and not (getattr(thing, "mute", False) and (f"{path}mute", 0) not in moving)
        target = getattr(thing, "target", None)
        by_shape = type(thing).__name__ in _ON_SHAPES or getattr(thing, "subtarget", "")
        if isinstance(thing, bpy.types.Object):
            target, by_shape = thing.parent, thing.parent_type != "OBJECT"
        if follow and by_shape and isinstance(target, bpy.types.Object):
            self.referred.append(target.data)
        read: list = [type(thing).__name__]
        for name in _settings_of(type(thing)):
            value = getattr(thing, name)
            if isinstance(value, bpy.types.bpy_prop_collection):
                read.append((name, [self.settings(item, follow) for item in value]))
            elif isinstance(value, bpy.types.ID):
                read.append((name, value.name))
                if follow:
                    self.referred.append(value)
                    if isinstance(value, bpy.types.Object) and value.type == "ARMATURE":
                        self.referred.append(value.data)
            elif isinstance(value, bpy.types.bpy_struct):
                read.append((name, self.settings(value, follow) if type(value).__name__ in _READ else ""))
            elif (f"{path}{name}", 0) in moving and not hasattr(value, "__len__"):
                read.append((name, None))
            else:
                found = plain(value)
                if isinstance(found, list):
                    found = [None if (f"{path}{name}", k) in moving else each for k, each in enumerate(found)]
                read.append((name, found))
        return read

    def block(self, block) -> list:
        """Return what a data-block is by itself, and how it moves."""
        parts: list = [self.settings(block)]
        if isinstance(block, bpy.types.Armature):
            parts.append(rest_pose(block))
        elif isinstance(block, bpy.types.Mesh):
            parts.append(_values(block.vertices, "co", 3))
        elif isinstance(block, bpy.types.Action):
            for slot in block.slots:
                for curve in slot_curves(block, slot):
                    parts += [slot.identifier, *self.curve(curve)]
        animation = getattr(block, "animation_data", None)
        if animation is not None:
            for curve in playing_curves(block):
                parts += self.curve(curve)
            for curve in animation.drivers:
                parts += self.driver(curve)
            parts.append(self.settings(animation, follow=False))
        return parts

    def curve(self, curve) -> list:
        """Return everything that decides the values of an f-curve."""
        points = curve.keyframe_points
        keys = [_values(points, name, size) for name, size in _KEYS.items()]
        if keys[1].max(initial=0) > _STRAIGHT:
            keys += [_values(points, name, size) for name, size in _BENT_KEYS.items()]
        if not points:
            keys.append(_values(curve.sampled_points, "co", 2))
        place = curve.data_path, curve.array_index, curve.extrapolation
        return [place, *keys, *(self.settings(modifier) for modifier in curve.modifiers)]

    def driver(self, curve) -> list:
        """Return everything that decides what a driver does, but for what moves with the frame."""
        targets = [target for variable in curve.driver.variables for target in variable.targets]
        switches = [self._switch(target) for target in targets]
        return [curve.mute, self.settings(curve.driver), switches, *self.curve(curve)]

    def _moving_of(self, block) -> set[tuple[str, int]]:
        if block not in self._moving:
            moving = {(curve.data_path, curve.array_index) for curve in playing_curves(block)}
            for strip in _strips(getattr(block, "animation_data", None)):
                moving.update((f"{_path_of(strip)}{curve.data_path}", curve.array_index) for curve in strip.fcurves)
            self._moving[block] = moving
        return self._moving[block]

    def _switch(self, target):
        """Return the custom property that a driver's target reads, such as a switch of a rig, if it stands until it is
        edited. Other settings that drivers read are those of data-blocks that are read anyway.
        """
        block, whole = target.id, re.sub(r"\[\d+\]$", "", target.data_path)
        if block is None or not whole.endswith('"]') or any(whole == path for path, _ in self._moving_of(block)):
            return ""
        try:
            return plain(block.path_resolve(target.data_path))
        except ValueError:
            return ""


def _values(items, name: str, size: int) -> np.ndarray:
    """Return a property of ``size`` components of all items of a collection."""
    values = np.empty(size * len(items), np.int32 if name in ("interpolation", "easing") else np.float32)
    items.foreach_get(name, values)
    return values


def plain(value):
    """Return a value of a property as one that differs from others in its text."""
    if isinstance(value, set):
        return sorted(value)
    if hasattr(value, "to_dict"):  # custom properties within one
        return repr(value.to_dict())
    if isinstance(value, bpy.types.ID):
        return value.name
    return list(map(plain, value)) if hasattr(value, "__len__") and not isinstance(value, str) else value


def rest_pose(armature) -> np.ndarray:
    """Return the (16 * bones,) elements of the bones' matrices at rest."""
    return _values(armature.bones, "matrix_local", 16)


def slot_curves(action, slot) -> list:
    """Return all curves of an action's slot that play."""
    if action is None or slot is None:
        return []
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves if not curve.mute]


def playing_curves(block) -> list:
    """Return the curves of the actions, strips and drivers that move a data-block."""
    animation = getattr(block, "animation_data", None)
    if not animation:
        return []
    played = [(animation.action, animation.action_slot)]
    played += [(s.action, s.action_slot) for s in _strips(animation) if animation.use_nla and not s.mute]
    curves = [curve for action, slot in played for curve in slot_curves(action, slot)]
    return [*curves, *(curve for curve in animation.drivers if not curve.mute)]


def _strips(animation) -> list:
    """Return all strips of the NLA, those within others too."""
    found = [strip for track in animation.nla_tracks for strip in track.strips] if animation else []
    for strip in found:  # which grows meanwhile
        found += strip.strips
    return found


def _path_of(thing) -> str:
    """Return the data path of a thing, up to the names of its properties; of no use for one that has none."""
    if isinstance(thing, bpy.types.ID):
        return ""
    try:
        return f"{thing.path_from_id()}."
    except (ValueError, AttributeError):
        return "?."


@cache
def _settings_of(kind: type) -> tuple[str, ...]:
    """Return the names of the properties of a kind of thing that are read."""
    names = next((_READ[base.__name__] for base in kind.__mro__ if base.__name__ in _READ), None)
    if names is None and issubclass(kind, bpy.types.ID):
        return ()
    return names or tuple(
        prop.identifier
        for prop in kind.bl_rna.properties
        if prop.identifier not in _SHOWN and (not prop.is_readonly or prop.type == "COLLECTION")
    )
