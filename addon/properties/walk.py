"""Settings of walks."""

import math

import bpy

from ...core.playback.cleanup import CleanupSettings
from ...core.playback.curve import CurveSettings
from ...core.playback.styles import STYLES, WalkRequest, WalkStyle
from ...core.playback.synthesis import SynthesisSettings
from . import crowd, walk_report
from .crowd import WEIGHTING_ITEMS, WayfarerCrowdSettings
from .definitions import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from .graph_names import clip_names, tag_names
from .walk_report import WayfarerWalkReport

_CLEANUP, _CURVE, _SYNTHESIS = CleanupSettings(), CurveSettings(), SynthesisSettings()


def _when(settings, name: str, value: str, other: str) -> tuple[str, ...]:
    """The property ``name``, and another one while it has a value."""
    return (name, other) if getattr(settings, name) == value else (name,)


#: The properties in which a person gives each setting of a style (:class:`..core.playback.styles.WalkStyle`).
_SHOWN = {
    "action": lambda s: ("action_kind", "action_clip" if s.action_kind == "CLIP" else "action_tag"),
    "target": lambda s: _when(s, "target", "OBJECT", "target_object"),
    "waypoints": lambda _: ("waypoints",),
    "nearness": lambda _: ("nearness",),
    "smoothness": lambda _: ("smoothness",),
    "facing": lambda s: ("facing",) if s.facing == "ANY" else ("facing", "facing_tolerance"),
    "curve": lambda _: ("path_curve", "path_width"),
    "weighting": lambda _: ("weighting",),
    "start": lambda s: _when(s, "start", "OBJECT", "start_object"),
}


class WayfarerWalkSettings(bpy.types.PropertyGroup):
    """Settings of walks."""

    style: EnumProperty(
        items=[(name, style.label, style.description) for name, style in STYLES.items()],
        name="Style",
        description="How the character chooses its way",
        default="WANDER",
    )
    weighting: EnumProperty(
        items=WEIGHTING_ITEMS,
        name="Prefer",
        description="Which links are taken more often than others",
        default="LINKS",
    )
    duration: FloatProperty(
        name="Duration",
        description="How long the walk lasts at least; it ends with a whole segment",
        subtype="TIME_ABSOLUTE",
        default=60.0,
        min=0.1,
        soft_max=600.0,
    )
    seed: IntProperty(name="Seed", description="Another number, another walk", default=0, min=0)
    start: EnumProperty(
        items=[
            ("RANDOM", "Anywhere", "Anywhere that the character can be"),
            ("CURSOR", "3D Cursor", "As near as possible to the 3D cursor"),
            ("ACTIVE_OBJECT", "Active Object", "As near as possible to the active object"),
            ("OBJECT", "Object", "As near as possible to an object of your choice"),
        ],
        name="Start",
        description="Where the walk starts",
        default="RANDOM",
    )
    start_object: PointerProperty(type=bpy.types.Object, name="Start Object", description="The object to start from")
    target: EnumProperty(
        items=[
            ("CURSOR", "3D Cursor", "Where the 3D cursor is"),
            ("OBJECT", "Object", "Where the origin of an object is"),
        ],
        name="To",
        description="Where the character goes",
        default="CURSOR",
    )
    target_object: PointerProperty(type=bpy.types.Object, name="Target Object", description="The object to go to")
    nearness: FloatProperty(
        name="Within",
        description="How far from the place the root may be when it gets there",
        subtype="DISTANCE",
        default=0.25,
        min=0.0,
        soft_max=2.0,
    )
    facing: EnumProperty(
        items=[
            ("ANY", "Any Way", "However it comes"),
            ("X", "X Axis", "Along the X axis of the object or of the 3D cursor"),
            ("Y", "Y Axis", "Along the Y axis of the object or of the 3D cursor"),
            ("NEGATIVE_X", "-X Axis", "Against the X axis of the object or of the 3D cursor"),
            (
                "NEGATIVE_Y",
                "-Y Axis",
                "Against the Y axis of the object or of the 3D cursor, as characters face in their own space",
            ),
        ],
        name="Face",
        description="Which way the character faces when it arrives",
        default="ANY",
    )
    facing_tolerance: FloatProperty(
        name="Give or Take",
        description="By how much it may face another way; the nearest heading of the grid is always allowed",
        subtype="ANGLE",
        default=math.radians(15.0),
        min=0.0,
        max=math.pi,
    )
    smoothness: FloatProperty(
        name="Smoothness",
        description="0: the quickest way. 1: the smoothest, for which up to twice the time is taken. Between, time is "
        "traded for fewer rough transitions, edits, stops and turns",
        subtype="FACTOR",
        default=WalkRequest.smoothness,
        min=0.0,
        max=1.0,
    )
    waypoints: PointerProperty(
        type=bpy.types.Collection,
        name="Waypoints",
        description="The objects of this collection are passed in the order of their names",
    )
    path_curve: PointerProperty(
        type=bpy.types.Object,
        name="Curve",
        description="The curve to follow, from its first point to its last",
        poll=lambda _, obj: obj.type == "CURVE",
    )
    path_width: FloatProperty(
        name="Width",
        description="How far the root may stray from the curve to either side",
        subtype="DISTANCE",
        default=_CURVE.width,
        min=0.01,
        soft_max=2.0,
    )
    action_kind: EnumProperty(
        items=[
            ("CLIP", "Clip", "All of what the motion graph has of a clip"),
            ("TAG", "Tag", "A segment with frames that carry a tag"),
        ],
        name="Motion",
        description="What is performed",
        default="CLIP",
    )
    action_clip: StringProperty(name="Clip", description="The clip that is performed", search=clip_names)
    action_tag: StringProperty(name="Tag", description="The tag of the frames that are performed", search=tag_names)
    walk_on: BoolProperty(
        name="Wander On", description="Wander on from there until the walk has lasted as long as asked", default=False
    )
    hold_feet: BoolProperty(
        name="Hold Feet", description="Keep planted feet where they stand, so that they do not slide", default=True
    )
    hold_window: FloatProperty(
        name="Ease Time",
        description="How long before and after a foot is planted it may be moved, together with its leg and the hips",
        subtype="TIME_ABSOLUTE",
        default=_CLEANUP.window,
        min=0.02,
        soft_max=1.0,
        precision=2,
    )
    hold_shift: FloatProperty(
        name="Farthest",
        description="How far a planted foot may be moved; one that slides farther takes a step in between",
        subtype="DISTANCE",
        default=_CLEANUP.max_shift,
        min=0.001,
        soft_max=0.5,
    )
    hold_drop: FloatProperty(
        name="Hips Down",
        description="How far the hips may be lowered so that no leg is stretched",
        subtype="DISTANCE",
        default=_CLEANUP.max_drop,
        min=0.0,
        soft_max=0.2,
    )
    blend_duration: FloatProperty(
        name="Blend",
        description="On each side of a transition, the longest time in which poses are blended",
        subtype="TIME_ABSOLUTE",
        default=_SYNTHESIS.blend_duration,
        min=0.0,
        soft_max=1.0,
        precision=2,
    )
    output: EnumProperty(
        items=[
            ("ACTION", "Action", "One action of the character"),
            ("STRIPS", "NLA Strips", "A strip for each segment, each with an action of its own to edit"),
            ("COPY", "Copy of Character", "One action of a copy; the character itself stays as it is"),
        ],
        name="Bake Into",
        description="What the walk becomes",
        default="ACTION",
    )
    use_markers: BoolProperty(
        name="Markers",
        description="Mark on the timeline where each segment starts, with the name of its clip",
        default=False,
    )
    markers: StringProperty(name="Own Markers", description="Names and frames of the markers of the last walk, as JSON")
    draw_path: BoolProperty(name="Path", description="Draw the way of the root as a curve on the floor", default=True)
    report: PointerProperty(type=WayfarerWalkReport)
    crowd: PointerProperty(type=WayfarerCrowdSettings)

    @property
    def chosen_style(self) -> WalkStyle:
        return STYLES[self.style]

    def shown(self) -> tuple[tuple[str, ...], ...]:
        """Return the names of the properties that the style heeds: of its aim, of its start, and of its end."""
        style = self.chosen_style
        aim = tuple(
            name for used in style.settings if used in _SHOWN and used != "start" for name in _SHOWN[used](self)
        )
        start = _SHOWN["start"](self) if "start" in style.settings else ()
        end = ("walk_on",) if style.arrives else ()
        if not style.arrives or self.walk_on:
            end += ("duration", "seed")
        elif start and self.start == "RANDOM":
            # Chance decides where a walk starts that may start anywhere.
            end += ("seed",)
        return aim, start, end

    def cleanup_settings(self, contacts) -> CleanupSettings:
        """Return the core's settings, with the given ContactSettings."""
        return CleanupSettings(self.hold_window, self.hold_shift, self.hold_drop, contacts)

    def synthesis_settings(self) -> SynthesisSettings:
        return SynthesisSettings(blend_duration=self.blend_duration)


CLASSES = (*walk_report.CLASSES, *crowd.CLASSES, WayfarerWalkSettings)
