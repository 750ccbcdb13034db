"""Blender's properties, as settings are made of: of a whole scene, so that none can have keyframes."""

from enum import Enum
from functools import partial

import bpy

BoolProperty = partial(bpy.props.BoolProperty, options=set())
EnumProperty = partial(bpy.props.EnumProperty, options=set())
FloatProperty = partial(bpy.props.FloatProperty, options=set())
FloatVectorProperty = partial(bpy.props.FloatVectorProperty, options=set())
IntProperty = partial(bpy.props.IntProperty, options=set())
PointerProperty = partial(bpy.props.PointerProperty, options=set())
StringProperty = partial(bpy.props.StringProperty, options=set())


def enum_items(texts: dict[Enum, tuple[str, str]]) -> list[tuple[str, str, str]]:
    """Make items of an EnumProperty: the members' names, with label and description."""
    return [(member.name, label, description) for member, (label, description) in texts.items()]
