"""Which actions are motions of a character."""

import bpy

from ..core.errors import ClipError
from .bridge.action_curves import action_curves

WALK_PROPERTY = "wayfarer_walk"
"""Custom property of actions and curves that Wayfarer made: a baked walk is no clip to build from."""


def character_actions(armature_object) -> list[bpy.types.Action]:
    """All actions that move bones of the armature, in the order of their names; baked walks left out."""
    found = []
    for action in bpy.data.actions:
        if WALK_PROPERTY in action:
            continue
        try:
            action_curves(armature_object, action)
        except ClipError:
            continue
        found.append(action)
    return found
