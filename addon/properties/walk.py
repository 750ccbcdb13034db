"""How the character walks."""

from enum import Enum

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from .enums import enum_items


class WalkStart(Enum):
    """Where a walk can start."""

    RANDOM = "random"
    CURSOR = "cursor"
    ACTIVE_OBJECT = "active object"


class WalkStyle(Enum):
    """How a walk chooses its links."""

    WANDER = "wander"
    RANDOM = "random"


class WayfarerWalkSettings(bpy.types.PropertyGroup):
    """How the character walks."""

    duration: FloatProperty(
        name="Duration",
        description="How long the walk lasts at least; it ends with a whole segment",
        subtype="TIME_ABSOLUTE",
        default=60.0,
        min=0.1,
        soft_max=600.0,
        options=set(),
    )
    seed: IntProperty(name="Seed", description="Another number, another walk", default=0, min=0, options=set())
    style: EnumProperty(
        items=enum_items(
            {
                WalkStyle.WANDER: ("Wander", "From place to place, all parts of the floor alike"),
                WalkStyle.RANDOM: ("Random Links", "Every link is equally likely, also those that only shuffle"),
            }
        ),
        name="Style",
        description="How the character chooses its way",
        default=WalkStyle.WANDER.name,
        options=set(),
    )
    start: EnumProperty(
        items=enum_items(
            {
                WalkStart.RANDOM: ("Random", "Anywhere that the character can be"),
                WalkStart.CURSOR: ("3D Cursor", "As near as possible to the 3D cursor"),
                WalkStart.ACTIVE_OBJECT: ("Active Object", "As near as possible to the active object"),
            }
        ),
        name="Start",
        description="Where the walk starts",
        default=WalkStart.RANDOM.name,
        options=set(),
    )
    use_markers: BoolProperty(
        name="Markers",
        description="Mark on the timeline where each segment starts, with the name of its clip",
        default=False,
        options=set(),
    )


CLASSES = (WayfarerWalkSettings,)
