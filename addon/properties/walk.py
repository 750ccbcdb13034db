"""How the character walks."""

import math
from enum import Enum

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ...core.playback.cleanup import CleanupSettings
from ...core.playback.curve import CurveSettings
from ...core.playback.synthesis import SynthesisSettings
from . import crowd, walk_report
from .crowd import WayfarerCrowdSettings
from .enums import enum_items
from .graph_names import clip_names, tag_names
from .walk_report import WayfarerWalkReport
from .walk_weighting import WEIGHTING_ITEMS, WalkWeighting

_CLEANUP, _CURVE, _SYNTHESIS = CleanupSettings(), CurveSettings(), SynthesisSettings()


class WalkStart(Enum):
    """Where a walk can start."""

    RANDOM = "random"
    CURSOR = "cursor"
    ACTIVE_OBJECT = "active object"
    OBJECT = "object"


class WalkStyle(Enum):
    """How a walk chooses its links."""

    WANDER = "wander"
    RANDOM = "random"
    PLACE = "to a place"
    WAYPOINTS = "waypoints"
    CURVE = "along a curve"
    LOOP = "loop"
    PERFORM = "perform"


class WalkTarget(Enum):
    """What tells where to go."""

    CURSOR = "cursor"
    OBJECT = "object"


class WalkFacing(Enum):
    """Which way to face at the end."""

    ANY = "any"
    X = "x"
    Y = "y"
    NEGATIVE_X = "-x"
    NEGATIVE_Y = "-y"


class ActionKind(Enum):
    """How the motion to be performed is named."""

    CLIP = "clip"
    TAG = "tag"


class WalkOutput(Enum):
    """What a walk is baked into."""

    ACTION = "action"
    STRIPS = "strips"
    COPY = "copy"


#: Styles that have a place to go to, those that last as long as asked, those that choose links by weight, and those
#: that start where they are told to.
TO_A_TARGET = frozenset({WalkStyle.PLACE, WalkStyle.PERFORM})
ARRIVING = frozenset({WalkStyle.PLACE, WalkStyle.WAYPOINTS, WalkStyle.CURVE, WalkStyle.PERFORM})
WEIGHTED = frozenset({WalkStyle.RANDOM, WalkStyle.LOOP})
FACING = frozenset({WalkStyle.PLACE, WalkStyle.WAYPOINTS})


class WayfarerWalkSettings(bpy.types.PropertyGroup):
    """How the character walks."""

    style: EnumProperty(
        items=enum_items(
            {
                WalkStyle.WANDER: ("Wander", "From place to place, all parts of the floor alike"),
                WalkStyle.RANDOM: ("Random", "Link after link by chance"),
                WalkStyle.PLACE: ("To a Place", "The quickest way to the 3D cursor or to an object"),
                WalkStyle.WAYPOINTS: (
                    "Waypoints",
                    "The quickest way past all objects of a collection, in the order of their names",
                ),
                WalkStyle.CURVE: ("Along a Curve", "As near to a curve as possible, from its start to its end"),
                WalkStyle.LOOP: ("Loop", "Back to where the walk starts, to be repeated without a seam"),
                WalkStyle.PERFORM: ("Perform", "The quickest way to where a motion can be played at a place, and it"),
            }
        ),
        name="Style",
        description="How the character chooses its way",
        default=WalkStyle.WANDER.name,
        options=set(),
    )
    weighting: EnumProperty(
        items=WEIGHTING_ITEMS,
        name="Prefer",
        description="Which links are taken more often than others",
        default=WalkWeighting.LINKS.name,
        options=set(),
    )
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
    start: EnumProperty(
        items=enum_items(
            {
                WalkStart.RANDOM: ("Anywhere", "Anywhere that the character can be"),
                WalkStart.CURSOR: ("3D Cursor", "As near as possible to the 3D cursor"),
                WalkStart.ACTIVE_OBJECT: ("Active Object", "As near as possible to the active object"),
                WalkStart.OBJECT: ("Object", "As near as possible to an object of your choice"),
            }
        ),
        name="Start",
        description="Where the walk starts",
        default=WalkStart.RANDOM.name,
        options=set(),
    )
    start_object: PointerProperty(
        type=bpy.types.Object, name="Start Object", description="The object to start from", options=set()
    )
    target: EnumProperty(
        items=enum_items(
            {
                WalkTarget.CURSOR: ("3D Cursor", "Where the 3D cursor is"),
                WalkTarget.OBJECT: ("Object", "Where the origin of an object is"),
            }
        ),
        name="To",
        description="Where the character goes",
        default=WalkTarget.CURSOR.name,
        options=set(),
    )
    target_object: PointerProperty(
        type=bpy.types.Object, name="Target Object", description="The object to go to", options=set()
    )
    nearness: FloatProperty(
        name="Within",
        description="How far from the place the root may be when it gets there",
        subtype="DISTANCE",
        default=0.25,
        min=0.0,
        soft_max=2.0,
        options=set(),
    )
    facing: EnumProperty(
        items=enum_items(
            {
                WalkFacing.ANY: ("Any Way", "However it comes"),
                WalkFacing.X: ("X Axis", "Along the X axis of the object or of the 3D cursor"),
                WalkFacing.Y: ("Y Axis", "Along the Y axis of the object or of the 3D cursor"),
                WalkFacing.NEGATIVE_X: ("-X Axis", "Against the X axis of the object or of the 3D cursor"),
                WalkFacing.NEGATIVE_Y: (
                    "-Y Axis",
                    "Against the Y axis of the object or of the 3D cursor, as characters face in their own space",
                ),
            }
        ),
        name="Face",
        description="Which way the character faces when it arrives",
        default=WalkFacing.ANY.name,
        options=set(),
    )
    facing_tolerance: FloatProperty(
        name="Give or Take",
        description="By how much it may face another way; the nearest heading of the grid is always allowed",
        subtype="ANGLE",
        default=math.radians(15.0),
        min=0.0,
        max=math.pi,
        options=set(),
    )
    waypoints: PointerProperty(
        type=bpy.types.Collection,
        name="Waypoints",
        description="The objects of this collection are passed in the order of their names",
        options=set(),
    )
    path_curve: PointerProperty(
        type=bpy.types.Object,
        name="Curve",
        description="The curve to follow, from its first point to its last",
        poll=lambda _, obj: obj.type == "CURVE",
        options=set(),
    )
    path_width: FloatProperty(
        name="Width",
        description="How far the root may stray from the curve to either side",
        subtype="DISTANCE",
        default=_CURVE.width,
        min=0.01,
        soft_max=2.0,
        options=set(),
    )
    action_kind: EnumProperty(
        items=enum_items(
            {
                ActionKind.CLIP: ("Clip", "All of what the motion graph has of a clip"),
                ActionKind.TAG: ("Tag", "A segment with frames that carry a tag"),
            }
        ),
        name="Motion",
        description="What is performed",
        default=ActionKind.CLIP.name,
        options=set(),
    )
    action_clip: StringProperty(name="Clip", description="The clip that is performed", search=clip_names, options=set())
    action_tag: StringProperty(
        name="Tag", description="The tag of the frames that are performed", search=tag_names, options=set()
    )
    walk_on: BoolProperty(
        name="Wander On",
        description="Wander on from there until the walk has lasted as long as asked",
        default=False,
        options=set(),
    )
    hold_feet: BoolProperty(
        name="Hold Feet",
        description="Keep planted feet where they stand, so that they do not slide",
        default=True,
        options=set(),
    )
    hold_window: FloatProperty(
        name="Ease Time",
        description="How long before and after a foot is planted it may be moved, together with its leg and the hips",
        subtype="TIME_ABSOLUTE",
        default=_CLEANUP.window,
        min=0.02,
        soft_max=1.0,
        precision=2,
        options=set(),
    )
    hold_shift: FloatProperty(
        name="Farthest",
        description="How far a planted foot may be moved; one that slides farther takes a step in between",
        subtype="DISTANCE",
        default=_CLEANUP.max_shift,
        min=0.001,
        soft_max=0.5,
        options=set(),
    )
    hold_drop: FloatProperty(
        name="Hips Down",
        description="How far the hips may be lowered so that no leg is stretched",
        subtype="DISTANCE",
        default=_CLEANUP.max_drop,
        min=0.0,
        soft_max=0.2,
        options=set(),
    )
    blend_duration: FloatProperty(
        name="Blend",
        description="On each side of a transition, the longest time in which poses are blended",
        subtype="TIME_ABSOLUTE",
        default=_SYNTHESIS.blend_duration,
        min=0.0,
        soft_max=1.0,
        precision=2,
        options=set(),
    )
    output: EnumProperty(
        items=enum_items(
            {
                WalkOutput.ACTION: ("Action", "One action of the character"),
                WalkOutput.STRIPS: ("NLA Strips", "A strip for each segment, each with an action of its own to edit"),
                WalkOutput.COPY: ("Copy of Character", "One action of a copy; the character itself stays as it is"),
            }
        ),
        name="Bake Into",
        description="What the walk becomes",
        default=WalkOutput.ACTION.name,
        options=set(),
    )
    use_markers: BoolProperty(
        name="Markers",
        description="Mark on the timeline where each segment starts, with the name of its clip",
        default=False,
        options=set(),
    )
    draw_path: BoolProperty(
        name="Path", description="Draw the way of the root as a curve on the floor", default=True, options=set()
    )
    report: PointerProperty(type=WayfarerWalkReport)
    crowd: PointerProperty(type=WayfarerCrowdSettings)

    def cleanup_settings(self, contacts) -> CleanupSettings:
        """As the core's settings, with the given ContactSettings."""
        return CleanupSettings(self.hold_window, self.hold_shift, self.hold_drop, contacts)

    def synthesis_settings(self) -> SynthesisSettings:
        return SynthesisSettings(blend_duration=self.blend_duration)


CLASSES = (*walk_report.CLASSES, *crowd.CLASSES, WayfarerWalkSettings)
