"""The character as it was understood, and what was chosen instead."""

import contextlib
from math import atan2, pi

import bpy
from mathutils import Vector

from ...core.errors import ClipError
from ...core.motion.body_size import person_height
from ...core.motion.contacts import foot_joints
from ..bridge.rig import FORWARD_PROPERTY, ROOT_PROPERTY, bind_rig, chosen_forward, chosen_root
from .definitions import EnumProperty, FloatProperty, StringProperty
from .graph_names import bone_names

_DIRECTIONS = {"X": (1, 0, 0), "NEGATIVE_X": (-1, 0, 0), "Y": (0, 1, 0), "NEGATIVE_Y": (0, -1, 0)}
_GUESSED, _OTHER = 0, len(_DIRECTIONS) + 1
_ALIGNED = 0.999
"""Cosine of the angle to an axis from which a direction is that axis."""


def _character(settings):
    return settings.id_data.wayfarer.character


def _root(settings) -> str:
    character = _character(settings)
    # What is no name is refused, with a sentence, where it is used.
    with contextlib.suppress(ClipError):
        return chosen_root(character) if character else ""
    return ""


def _set_root(settings, name: str) -> None:
    _choose(settings, ROOT_PROPERTY, name)


def _facing(settings) -> int:
    character = _character(settings)
    try:
        value = chosen_forward(character) if character else None
    except ClipError:
        return _OTHER
    if value is None:
        return _GUESSED
    world = (character.matrix_world.to_3x3() @ Vector(value)).normalized()
    cosines = [world.dot(axis) for axis in _DIRECTIONS.values()]
    return 1 + cosines.index(max(cosines)) if max(cosines) > _ALIGNED else _OTHER


def _set_facing(settings, number: int) -> None:
    if number == _OTHER:
        return
    character, value = _character(settings), ()
    if number != _GUESSED and character is not None:
        axis = Vector(list(_DIRECTIONS.values())[number - 1])
        value = tuple(character.matrix_world.to_3x3().inverted_safe() @ axis)
    _choose(settings, FORWARD_PROPERTY, value)


def _choose(settings, name: str, value) -> None:
    """Keep a choice with the character; an empty one leaves it to be guessed."""
    character = _character(settings)
    if character is None:
        return
    if value:
        character[name] = value
    elif name in character:
        del character[name]
    settings.look()


def _axis_words(up, height: float) -> str:
    """Name the axis that a rest pose stands along, and say if that is not upright; ``up`` is from feet to hips (m)."""
    place = max(range(3), key=lambda axis: abs(up[axis]))
    if abs(up[place]) < 0.2 * height:
        return "not known: folded at rest"
    lies = "" if place == 2 and up[2] > 0 else " (lies at rest)"
    return f"{'-' if up[place] < 0 else ''}{'XYZ'[place]}{lies}"


class WayfarerCharacterSettings(bpy.types.PropertyGroup):
    """The body's root and facing, as chosen; what is guessed where nothing is chosen, as of the last look."""

    root: StringProperty(
        name="Root",
        description="The bone that carries the body. Found from the shape of the rig and the names of its bones where "
        "none is chosen",
        search=bone_names,
        get=_root,
        set=_set_root,
    )
    facing: EnumProperty(
        items=[
            ("GUESSED", "Found", "The direction in which the feet of the rest pose point, or its left and right say"),
            ("X", "X", "The rest pose faces along the world's X axis"),
            ("NEGATIVE_X", "-X", "The rest pose faces against the world's X axis"),
            ("Y", "Y", "The rest pose faces along the world's Y axis"),
            ("NEGATIVE_Y", "-Y", "The rest pose faces against the world's Y axis"),
            ("OTHER", "Between", "The rest pose faces between the world's axes, as a remedy has set it"),
        ],
        name="Facing",
        description="Which way the character faces in its rest pose",
        get=_facing,
        set=_set_facing,
    )
    found_root: StringProperty(name="Root", description="The bone that carries the body")
    found_left: StringProperty(name="Left Foot", description="The bone of the left foot, at the ankle")
    found_right: StringProperty(name="Right Foot", description="The bone of the right foot, at the ankle")
    found_facing: FloatProperty(
        name="Facing",
        description="Which way the rest pose faces, from world X to world Y",
        subtype="ANGLE",
    )
    found_up: StringProperty(name="Up", description="The axis of the world that the hips are above the feet along")
    height: FloatProperty(
        name="Height", description="How tall a person with legs of this length is", subtype="DISTANCE"
    )
    problem: StringProperty(name="Problem", description="Why nothing is understood of the character")

    def look(self) -> None:
        """Look at the character again."""
        for name in ("found_root", "found_left", "found_right", "found_facing", "found_up", "height", "problem"):
            self.property_unset(name)
        character = _character(self)
        if character is None:
            return
        try:
            skeleton = bind_rig(character).skeleton
        except ClipError as error:
            self.problem = str(error)
            return
        self.found_root, self.height = skeleton.names[0], person_height(skeleton)
        self.found_facing = atan2(*skeleton.rest_forward[1::-1])
        try:
            left, right = foot_joints(skeleton)
        except ClipError:
            # Asked for where feet are needed.
            return
        self.found_left, self.found_right = skeleton.names[left[0]], skeleton.names[right[0]]
        places = skeleton.rest_world[1]
        self.found_up = _axis_words(places[skeleton.hips] - 0.5 * (places[left[0]] + places[right[0]]), self.height)

    def facing_words(self) -> str:
        """Return which way the character faces, for people: an axis, or an angle from X to Y."""
        names = ("X", "Y", "-X", "-Y")
        quarter = self.found_facing / (pi / 2)
        nearest = round(quarter)
        return names[nearest % 4] if abs(quarter - nearest) < 0.05 else f"{self.found_facing * 180 / pi:.0f}° from X"


CLASSES = (WayfarerCharacterSettings,)
