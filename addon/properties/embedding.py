"""Settings of the embedding: how far motion may be edited to reach grid cells."""

import bpy

from ...core.embedding.embedding import EmbeddingSettings
from ...core.embedding.footprint import FootprintRule, FootprintSettings
from .definitions import EnumProperty, FloatProperty, enum_items

_FOOTPRINT = FootprintSettings()

_FOOTPRINT_ITEMS = enum_items(
    {
        FootprintRule.SNAP: ("Snap", "A segment may always end on the nearest cell and heading"),
        FootprintRule.CONSERVATIVE: (
            "Conservative",
            "A segment may end only on cells and headings within the limits, even if there is none",
        ),
    }
)


class WayfarerEmbeddingSettings(bpy.types.PropertyGroup):
    """Settings of the embedding: how far motion may be edited to reach grid cells."""

    footprint_rule: EnumProperty(
        items=_FOOTPRINT_ITEMS,
        name="Footprint",
        description="Which cells and headings a segment may end on",
        default=_FOOTPRINT.rule.name,
    )
    position_rate: FloatProperty(
        name="Position Edit",
        description="How far the end of a segment may be moved, as part of the length of its path: 0.08 is 8 cm for "
        "each metre",
        subtype="FACTOR",
        default=_FOOTPRINT.position_rate,
        min=0.0,
        soft_max=0.3,
        precision=3,
    )
    heading_rate: FloatProperty(
        name="Heading Edit",
        description="How far the end of a segment may be turned, for each metre of its path",
        subtype="ANGLE",
        default=_FOOTPRINT.heading_rate,
        min=0.0,
        soft_max=0.5,
    )

    def to_core(self) -> EmbeddingSettings:
        rule = FootprintRule[self.footprint_rule]
        return EmbeddingSettings(
            FootprintSettings(position_rate=self.position_rate, heading_rate=self.heading_rate, rule=rule)
        )


CLASSES = (WayfarerEmbeddingSettings,)
