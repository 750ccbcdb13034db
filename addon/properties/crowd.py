"""Settings of a crowd, and what came of it."""

import bpy

from ...core.playback.crowd import CrowdSettings
from .definitions import EnumProperty, FloatProperty, IntProperty, StringProperty

_CROWD = CrowdSettings()

WEIGHTING_ITEMS = [
    ("LINKS", "Links", "Every link is equally likely, also those that only shuffle"),
    ("GOODNESS", "Goodness", "Smooth transitions are more likely than rough ones"),
    ("VARIABILITY", "Variability", "Places with many ways in and out are more likely"),
    ("PLACES", "Places Evenly", "Places where the walker has seldom been are more likely"),
    ("CLIPS", "Clip Weights", "Each clip is as likely as its weight says"),
]
"""Links that a walker takes more often than others."""


class WayfarerCrowdSettings(bpy.types.PropertyGroup):
    """Settings of a crowd, and what came of it."""

    n_walkers: IntProperty(
        name="Walkers",
        description="How many copies of the character walk at the same time",
        default=10,
        min=1,
        soft_max=100,
        max=1000,
    )
    duration: FloatProperty(
        name="Duration",
        description="For how long they walk without meeting one another",
        subtype="TIME_ABSOLUTE",
        default=30.0,
        min=0.1,
        soft_max=600.0,
    )
    seed: IntProperty(name="Seed", description="Another number, another crowd", default=0, min=0)
    spacing: FloatProperty(
        name="Spacing",
        description="What the roots of any two walkers keep between them at every frame",
        subtype="DISTANCE",
        default=2 * _CROWD.radius,
        min=0.0,
        soft_max=2.0,
    )
    weighting: EnumProperty(
        items=WEIGHTING_ITEMS,
        name="Prefer",
        description="Which links walkers take more often than others",
        default="PLACES",
    )
    n_walking: IntProperty(name="Walking", description="How many walkers got a walk")
    n_wanted: IntProperty(name="Wanted", description="How many walkers were asked for")
    closest: FloatProperty(
        name="Closest",
        description="What the two walkers that come closest have between them; 0 if there are no two",
        subtype="DISTANCE",
    )
    unserved: StringProperty(name="Unserved", description="Why walkers got no walk, in lines")


CLASSES = (WayfarerCrowdSettings,)
