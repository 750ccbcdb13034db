"""What is painted on the floor."""

from enum import Enum

import bpy
from bpy.props import EnumProperty

from .enums import enum_items


class MapQuantity(Enum):
    """What can be painted on the floor."""

    VARIABILITY = "variability"
    COVERAGE = "coverage"
    WHY_NOT = "why not"


class WayfarerMapSettings(bpy.types.PropertyGroup):
    """What is painted on the floor."""

    quantity: EnumProperty(
        items=enum_items(
            {
                MapQuantity.VARIABILITY: ("Variability", "In how many ways the character can pass through a cell"),
                MapQuantity.COVERAGE: ("Coverage", "In how many headings the character can pass through a cell"),
                MapQuantity.WHY_NOT: ("Why Not", "Why the character cannot go where it cannot go"),
            }
        ),
        name="Map",
        description="What to paint on the floor",
        default=MapQuantity.VARIABILITY.name,
        options=set(),
    )


CLASSES = (WayfarerMapSettings,)
