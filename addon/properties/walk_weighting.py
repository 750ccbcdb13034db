"""Which links a walker takes more often than others."""

from enum import Enum

from .enums import enum_items


class WalkWeighting(Enum):
    """Which links a walker takes more often than others."""

    LINKS = "links"
    GOODNESS = "goodness"
    VARIABILITY = "variability"
    PLACES = "places"
    CLIPS = "clips"


WEIGHTING_ITEMS = enum_items(
    {
        WalkWeighting.LINKS: ("Links", "Every link is equally likely, also those that only shuffle"),
        WalkWeighting.GOODNESS: ("Goodness", "Smooth transitions are more likely than rough ones"),
        WalkWeighting.VARIABILITY: ("Variability", "Places with many ways in and out are more likely"),
        WalkWeighting.PLACES: ("Places Evenly", "Places where the walker has seldom been are more likely"),
        WalkWeighting.CLIPS: ("Clip Weights", "Each clip is as likely as its weight says"),
    }
)
