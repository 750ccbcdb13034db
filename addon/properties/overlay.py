"""What is drawn over the viewport."""

import bpy
from bpy.props import BoolProperty, StringProperty


class WayfarerOverlaySettings(bpy.types.PropertyGroup):
    """What is drawn over the viewport."""

    show_legend: BoolProperty(
        name="Legend",
        description="Show in the viewport what the colours of the floor mean",
        default=True,
        options=set(),
    )
    # It was a choice once: files keep 0 for never, 1 for always and 2 for while the panel is open, which is read as on.
    show_environment: BoolProperty(
        name="Show in Viewport",
        description="Draw the ground rectangle, what obstacles block, the regions and the size of the character at the "
        "3D cursor",
        default=False,
        options=set(),
    )
    place: StringProperty(
        name="Place",
        description="What was found out about the place that was clicked last, in lines",
        options=set(),
    )


CLASSES = (WayfarerOverlaySettings,)
