"""Ground, obstacles, regions and the grid over them."""

from enum import Enum

import bpy
from bpy.props import CollectionProperty

from ...core.environment.environment import EnvironmentSettings
from ...core.environment.grid import MOST_HEADINGS
from ...core.environment.regions import RegionRule
from .definitions import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
    enum_items,
)

_BODY = EnvironmentSettings()

_RULE_ITEMS = enum_items(
    {
        RegionRule.REQUIRE: ("Require", "Inside it, only frames that carry the tag may be played"),
        RegionRule.FORBID: ("Forbid", "Inside it, frames that carry the tag may not be played"),
        RegionRule.CONFINE: ("Confine", "Frames that carry the tag may be played inside it only"),
    }
)


class GroundSource(Enum):
    """The source of the ground rectangle."""

    OBJECT = "object"
    BOUNDS = "obstacles' bounds"
    TYPED = "typed in"


_GROUND_ITEMS = enum_items(
    {
        GroundSource.OBJECT: ("Object", "As large as an object, at its top; without one, as the obstacles"),
        GroundSource.BOUNDS: ("Obstacles' Bounds", "As large as all obstacles together, at the height of the lowest"),
        GroundSource.TYPED: ("Typed In", "From corner to corner, in numbers"),
    }
)


REGION_TYPES = frozenset({"MESH", "CURVE", "SURFACE", "META", "FONT"})
"""Objects that have faces."""


class WayfarerRegion(bpy.types.PropertyGroup):
    """A part of the ground where only some motion may be played."""

    object: PointerProperty(
        type=bpy.types.Object,
        name="Object",
        description="The region is the shadow of this object on the ground",
        poll=lambda _, obj: obj.type in REGION_TYPES,
    )
    rule: EnumProperty(
        items=_RULE_ITEMS, name="Rule", description="What the region asks of motion", default=RegionRule.REQUIRE.name
    )
    tag: StringProperty(
        name="Tag",
        description="Frames of actions carry tags: a pose marker with the tag's name begins it, one with a slash "
        "before the name ends it",
        default="step",
    )
    margin: FloatProperty(
        name="Margin",
        description="Grow the region by this much, to keep feet clear of what stands there (Require and Forbid)",
        subtype="DISTANCE",
        default=0.0,
        min=0.0,
        soft_max=1.0,
    )


class WayfarerEnvironmentSettings(bpy.types.PropertyGroup):
    """Ground, obstacles, regions and the grid over them."""

    ground_source: EnumProperty(
        items=_GROUND_ITEMS,
        name="Ground From",
        description="Where the ground rectangle comes from",
        default=GroundSource.OBJECT.name,
    )
    ground: PointerProperty(
        type=bpy.types.Object,
        name="Ground",
        description="Its extent is the ground rectangle and its top the floor; without it, the obstacles' extent is "
        "used",
        poll=lambda _, obj: obj.type in {"MESH", "EMPTY", "CURVE", "SURFACE"},
    )
    ground_low: FloatVectorProperty(
        name="Min",
        description="The corner of the ground with the lowest coordinates",
        size=2,
        subtype="XYZ",
        unit="LENGTH",
        default=(-4.0, -4.0),
    )
    ground_high: FloatVectorProperty(
        name="Max",
        description="The corner of the ground with the highest coordinates",
        size=2,
        subtype="XYZ",
        unit="LENGTH",
        default=(4.0, 4.0),
    )
    ground_height: FloatProperty(
        name="Height",
        description="Height of the ground above the world's origin",
        subtype="DISTANCE",
        default=_BODY.ground_height,
    )
    obstacles: PointerProperty(
        type=bpy.types.Collection,
        name="Obstacles",
        description="What the character must walk around: all objects of this collection",
    )
    regions: CollectionProperty(type=WayfarerRegion)
    active_region: IntProperty(name="Active Region", description="The region chosen in the list")
    cell_size: FloatProperty(
        name="Cell Size",
        description="Side of a grid cell",
        subtype="DISTANCE",
        default=0.1,
        min=0.02,
        soft_max=0.5,
        precision=3,
    )
    n_headings: IntProperty(
        name="Headings",
        description="Directions that the character can face in a cell, evenly spaced",
        default=24,
        min=4,
        max=MOST_HEADINGS,
        soft_max=72,
    )
    radius: FloatProperty(
        name="Radius",
        description="Distance that the character's root keeps from every obstacle",
        subtype="DISTANCE",
        default=_BODY.radius,
        min=0.0,
        soft_max=1.0,
    )
    step_height: FloatProperty(
        name="Step Height",
        description="Geometry up to this height above the ground is walked on, not around",
        subtype="DISTANCE",
        default=_BODY.step_height,
        min=0.0,
        soft_max=0.5,
    )
    head_height: FloatProperty(
        name="Head Height",
        description="Geometry from this height above the ground on is walked under",
        subtype="DISTANCE",
        default=_BODY.head_height,
        min=0.1,
        soft_max=3.0,
    )
    tiled: BoolProperty(
        name="Tiled", description="The ground repeats: who leaves it on one side enters it on the other", default=False
    )

    @property
    def source(self) -> GroundSource:
        return GroundSource[self.ground_source]

    @property
    def has_ground(self) -> bool:
        """True if the source of the ground rectangle has been chosen."""
        if self.source is GroundSource.TYPED:
            return True
        return self.obstacles is not None or (self.source is GroundSource.OBJECT and self.ground is not None)

    def to_core(self, ground_height: float) -> EnvironmentSettings:
        return EnvironmentSettings(self.radius, self.step_height, self.head_height, ground_height)


CLASSES = (WayfarerRegion, WayfarerEnvironmentSettings)
