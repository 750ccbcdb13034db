"""The settings of a scene, ``scene.wayfarer``: what the panels show and the operators read.

Defaults are those of the core's settings; nothing is repeated here. Settings are saved with the scene, results are
not (see :mod:`.state`).
"""

from enum import Enum

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..core.embedding.embedding import EmbeddingSettings
from ..core.embedding.footprint import FootprintRule, FootprintSettings
from ..core.environment.environment import EnvironmentSettings
from ..core.environment.regions import RegionRule
from ..core.motion.graph import MotionGraphSettings
from .clip_actions import character_actions


class MapQuantity(Enum):
    """What can be painted on the floor."""

    VARIABILITY = "variability"
    COVERAGE = "coverage"


class WalkStart(Enum):
    """Where a walk can start."""

    RANDOM = "random"
    CURSOR = "cursor"
    ACTIVE_OBJECT = "active object"


def enum_items(texts: dict[Enum, tuple[str, str]]) -> list[tuple[str, str, str]]:
    """Items of an EnumProperty: the members' names, with label and description."""
    return [(member.name, label, description) for member, (label, description) in texts.items()]


_GRAPH = MotionGraphSettings()
_BODY = EnvironmentSettings()
_FOOTPRINT = FootprintSettings()

_RULE_ITEMS = enum_items(
    {
        RegionRule.REQUIRE: ("Require", "Inside it, only frames that carry the tag may be played"),
        RegionRule.FORBID: ("Forbid", "Inside it, frames that carry the tag may not be played"),
        RegionRule.CONFINE: ("Confine", "Frames that carry the tag may be played inside it only"),
    }
)
_FOOTPRINT_ITEMS = enum_items(
    {
        FootprintRule.SNAP: ("Snap", "A segment may always end on the nearest cell and heading"),
        FootprintRule.CONSERVATIVE: (
            "Conservative",
            "A segment may end only on cells and headings within the limits, even if there is none",
        ),
    }
)


class WayfarerClip(bpy.types.PropertyGroup):
    """An action of the character and whether it takes part."""

    action: PointerProperty(
        type=bpy.types.Action, name="Action", description="A motion of the character", options=set()
    )
    use: BoolProperty(
        name="Use", description="Let this action take part in the motion graph", default=True, options=set()
    )


class WayfarerRegion(bpy.types.PropertyGroup):
    """A part of the ground where only some motion may be played."""

    object: PointerProperty(
        type=bpy.types.Object,
        name="Object",
        description="The region is the shadow of this object on the ground",
        poll=lambda _, obj: obj.type in {"MESH", "CURVE", "SURFACE", "META", "FONT"},
        options=set(),
    )
    rule: EnumProperty(
        items=_RULE_ITEMS,
        name="Rule",
        description="What the region asks of motion",
        default=RegionRule.REQUIRE.name,
        options=set(),
    )
    tag: StringProperty(
        name="Tag",
        description="Frames of actions carry tags: a pose marker with the tag's name begins it, one with a slash "
        "before the name ends it",
        default="step",
        options=set(),
    )
    margin: FloatProperty(
        name="Margin",
        description="Grow the region by this much, to keep feet clear of what stands there (Require and Forbid)",
        subtype="DISTANCE",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        options=set(),
    )


class WayfarerGraphSettings(bpy.types.PropertyGroup):
    """How clips are cut and linked."""

    frame_rate: FloatProperty(
        name="Frame Rate",
        description="Samples per second at which motion is compared and cut",
        default=_GRAPH.frame_rate,
        min=5.0,
        soft_max=120.0,
        precision=1,
        options=set(),
    )
    min_segment_duration: FloatProperty(
        name="Min Segment",
        description="Shortest time between two cuts of a clip; shorter segments respond faster, longer ones keep "
        "more of the recorded motion",
        subtype="TIME_ABSOLUTE",
        default=_GRAPH.min_segment_duration,
        min=0.05,
        soft_max=2.0,
        options=set(),
    )
    max_cost: FloatProperty(
        name="Threshold",
        description="How different two poses may be to be linked; lower makes smoother transitions, higher more "
        "of them (squared angles of the joints, in square radians)",
        default=_GRAPH.max_cost,
        min=0.001,
        soft_max=1.0,
        step=1,
        precision=3,
        options=set(),
    )

    def to_core(self) -> MotionGraphSettings:
        return MotionGraphSettings(
            frame_rate=self.frame_rate,
            min_segment_duration=self.min_segment_duration,
            max_cost=self.max_cost,
        )


class WayfarerEnvironmentSettings(bpy.types.PropertyGroup):
    """Ground, obstacles, regions and the grid over them."""

    ground: PointerProperty(
        type=bpy.types.Object,
        name="Ground",
        description="Its extent is the ground rectangle and its lowest point the floor; without it, the obstacles' "
        "extent is used",
        poll=lambda _, obj: obj.type in {"MESH", "EMPTY", "CURVE", "SURFACE"},
        options=set(),
    )
    obstacles: PointerProperty(
        type=bpy.types.Collection,
        name="Obstacles",
        description="What the character must walk around: all objects of this collection",
        options=set(),
    )
    regions: CollectionProperty(type=WayfarerRegion)
    active_region: IntProperty(name="Active Region", options=set())
    cell_size: FloatProperty(
        name="Cell Size",
        description="Side of a grid cell",
        subtype="DISTANCE",
        default=0.125,
        min=0.02,
        soft_max=0.5,
        precision=3,
        options=set(),
    )
    n_headings: IntProperty(
        name="Headings",
        description="Directions that the character can face in a cell, evenly spaced",
        default=24,
        min=4,
        soft_max=72,
        options=set(),
    )
    radius: FloatProperty(
        name="Radius",
        description="Distance that the character's root keeps from every obstacle",
        subtype="DISTANCE",
        default=_BODY.radius,
        min=0.0,
        soft_max=1.0,
        options=set(),
    )
    step_height: FloatProperty(
        name="Step Height",
        description="Geometry up to this height above the ground is walked on, not around",
        subtype="DISTANCE",
        default=_BODY.step_height,
        min=0.0,
        soft_max=0.5,
        options=set(),
    )
    head_height: FloatProperty(
        name="Head Height",
        description="Geometry from this height above the ground on is walked under",
        subtype="DISTANCE",
        default=_BODY.head_height,
        min=0.1,
        soft_max=3.0,
        options=set(),
    )
    tiled: BoolProperty(
        name="Tiled",
        description="The ground repeats: who leaves it on one side enters it on the other",
        default=False,
        options=set(),
    )

    def to_core(self, ground_height: float) -> EnvironmentSettings:
        return EnvironmentSettings(self.radius, self.step_height, self.head_height, ground_height)


class WayfarerEmbeddingSettings(bpy.types.PropertyGroup):
    """How far motion may be edited to reach grid cells."""

    footprint_rule: EnumProperty(
        items=_FOOTPRINT_ITEMS,
        name="Footprint",
        description="Which cells and headings a segment may end on",
        default=_FOOTPRINT.rule.name,
        options=set(),
    )
    position_rate: FloatProperty(
        name="Position Edit",
        description="How far the end of a segment may be moved, as part of the length of its path",
        default=_FOOTPRINT.position_rate,
        min=0.0,
        soft_max=0.3,
        precision=3,
        options=set(),
    )
    heading_rate: FloatProperty(
        name="Heading Edit",
        description="How far the end of a segment may be turned, for each metre of its path",
        subtype="ANGLE",
        default=_FOOTPRINT.heading_rate,
        min=0.0,
        soft_max=0.5,
        options=set(),
    )

    def to_core(self) -> EmbeddingSettings:
        rule = FootprintRule[self.footprint_rule]
        return EmbeddingSettings(
            FootprintSettings(position_rate=self.position_rate, heading_rate=self.heading_rate, rule=rule)
        )


class WayfarerMapSettings(bpy.types.PropertyGroup):
    """What is painted on the floor."""

    quantity: EnumProperty(
        items=enum_items(
            {
                MapQuantity.VARIABILITY: ("Variability", "In how many ways the character can pass through a cell"),
                MapQuantity.COVERAGE: ("Coverage", "In how many headings the character can pass through a cell"),
            }
        ),
        name="Map",
        description="What to paint on the floor",
        default=MapQuantity.VARIABILITY.name,
        options=set(),
    )


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
    n_walks: IntProperty(
        name="Variants",
        description="Make so many random walks and keep the one that sees most of the floor",
        default=30,
        min=1,
        soft_max=100,
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


def _on_character(settings, _) -> None:
    settings.refresh_clips()


class WayfarerSceneSettings(bpy.types.PropertyGroup):
    """Everything that Wayfarer keeps in a scene."""

    character: PointerProperty(
        type=bpy.types.Object,
        name="Character",
        description="The armature that is to walk",
        poll=lambda _, obj: obj.type == "ARMATURE",
        update=_on_character,
        options=set(),
    )
    clips: CollectionProperty(type=WayfarerClip)
    active_clip: IntProperty(name="Active Clip", options=set())
    graph: PointerProperty(type=WayfarerGraphSettings)
    environment: PointerProperty(type=WayfarerEnvironmentSettings)
    embedding: PointerProperty(type=WayfarerEmbeddingSettings)
    map: PointerProperty(type=WayfarerMapSettings)
    walk: PointerProperty(type=WayfarerWalkSettings)

    def refresh_clips(self) -> int:
        """List the actions that animate the character, keeping what was switched off; returns how many are new."""
        unused = {clip.action for clip in self.clips if not clip.use}
        known = {clip.action for clip in self.clips}
        actions = character_actions(self.character) if self.character else []
        self.clips.clear()
        for action in actions:
            clip = self.clips.add()
            clip.action = action
            clip.use = action not in unused
        self.active_clip = min(self.active_clip, max(len(self.clips) - 1, 0))
        return sum(action not in known for action in actions)

    def used_actions(self) -> list[bpy.types.Action]:
        return [clip.action for clip in self.clips if clip.use and clip.action is not None]


_CLASSES = (
    WayfarerClip,
    WayfarerRegion,
    WayfarerGraphSettings,
    WayfarerEnvironmentSettings,
    WayfarerEmbeddingSettings,
    WayfarerMapSettings,
    WayfarerWalkSettings,
    WayfarerSceneSettings,
)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.wayfarer = PointerProperty(type=WayfarerSceneSettings)


def unregister():
    del bpy.types.Scene.wayfarer
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
