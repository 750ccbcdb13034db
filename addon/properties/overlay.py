"""What is drawn over the viewport."""

from enum import Enum

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty


class ShowEnvironment(Enum):
    """In which viewports the environment is in sight.

    Files keep the numbers; 0 and 1 are what they kept while this was a check box, which could be off and on.
    """

    NEVER = 0
    ALWAYS = 1
    WITH_PANEL = 2


_SHOW_ENVIRONMENT = {
    ShowEnvironment.WITH_PANEL: ("While Panel Is Open", "In each viewport while this panel is open in its sidebar"),
    ShowEnvironment.ALWAYS: ("Always", "In all viewports, whatever their sidebars show"),
    ShowEnvironment.NEVER: ("Never", "In no viewport"),
}


class WayfarerOverlaySettings(bpy.types.PropertyGroup):
    """What is drawn over the viewport."""

    show_legend: BoolProperty(
        name="Legend",
        description="Show in the viewport what the colours of the floor mean",
        default=True,
        options=set(),
    )
    show_environment: EnumProperty(
        items=[
            (kind.name, label, description, "NONE", kind.value)
            for kind, (label, description) in _SHOW_ENVIRONMENT.items()
        ],
        name="In Viewport",
        description="When to draw the ground rectangle, what obstacles block, the regions and the size of the "
        "character at the 3D cursor",
        default=ShowEnvironment.WITH_PANEL.name,
        options=set(),
    )
    place: StringProperty(
        name="Place",
        description="What was found out about the place that was clicked last, in lines",
        options=set(),
    )


CLASSES = (WayfarerOverlaySettings,)
