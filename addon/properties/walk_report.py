"""The quality of the last walk, for the panel."""

import bpy
from bpy.props import CollectionProperty

from .definitions import FloatProperty, IntProperty, StringProperty


class WayfarerWorstFrame(bpy.types.PropertyGroup):
    """A frame worth looking at."""

    frame: IntProperty(name="Frame", description="Frame of the scene")
    what: StringProperty(name="What", description="What is to be seen there")
    amount: StringProperty(name="Amount", description="How much of it, with its unit")
    severity: FloatProperty(name="Severity", description="How many times that is what an onlooker begins to notice")


def _on_worst(report, _) -> None:
    if 0 <= report.active_worst < len(report.worst):
        report.id_data.frame_set(report.worst[report.active_worst].frame)


class WayfarerWalkReport(bpy.types.PropertyGroup):
    """The quality of the last walk. Kept with the scene's settings, so that undo takes it back with the walk."""

    feet: StringProperty(name="Feet", description="What was done about the feet, or why nothing could be done")
    slide_before: FloatProperty(
        name="Slide Before",
        description="How fast planted feet slide before they are held, on average; below 0 if they cannot be told",
        unit="VELOCITY",
        default=-1.0,
    )
    slide_after: FloatProperty(
        name="Slide After",
        description="How fast planted feet slide in the walk as it was baked, on average",
        unit="VELOCITY",
        default=-1.0,
    )
    slide_in_clips: FloatProperty(
        name="Slide in Clips",
        description="How fast planted feet slide in the clips that the walk is made of, on average",
        unit="VELOCITY",
        default=-1.0,
    )
    gap: FloatProperty(
        name="Pose Gap",
        description="The largest angle that a joint has to make up for where a segment follows another",
        subtype="ANGLE",
    )
    gap_joint: StringProperty(name="Joint", description="The joint with the largest pose gap")
    gap_frame: IntProperty(name="Gap Frame", description="Where the largest pose gap is")
    edit: FloatProperty(
        name="Root Edit",
        description="How far the root was moved from where the clips lead it, in metres for each metre of the way",
    )
    turn_edit: FloatProperty(
        name="Turn Edit",
        description="How far the root was turned from where the clips lead it, for each metre of the way",
        subtype="ANGLE",
    )
    idle: FloatProperty(
        name="Standing",
        description="In how much of the walk the character stands, turns on the spot or shuffles",
        subtype="FACTOR",
    )
    turns_back: FloatProperty(
        name="Turns Back",
        description="How often in a minute the character turns by more than 120° within two seconds",
    )
    worst: CollectionProperty(type=WayfarerWorstFrame)
    active_worst: IntProperty(
        name="Worst Frame",
        description="The frame chosen in the list; choosing one shows it",
        default=-1,
        update=_on_worst,
    )

    @property
    def is_there(self) -> bool:
        """True if a walk has been measured."""
        return len(self.worst) > 0 or self.feet != ""

    def clear(self) -> None:
        """Nothing has been measured."""
        for name in self.bl_rna.properties.keys():  # noqa: SIM118  (no mapping)
            if name not in ("rna_type", "name"):
                self.property_unset(name)


CLASSES = (WayfarerWorstFrame, WayfarerWalkReport)
