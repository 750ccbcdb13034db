"""The lists of the panels."""

import math
from typing import Any

import bpy

from ...core.wording import time, turn
from ..bridge.clip_actions import action_seconds
from ..bridge.tags import tag_names
from ..bridge.units import scene_length
from ..results.clips import health_of, motion_of

_NAME_SHARES = (1.0, 0.7, 0.5, 0.36)
"""Part of a row's width for the name, by the number of columns beside it."""


class WAYFARER_UL_clips(bpy.types.UIList):
    """The character's actions, each with a tick, its numbers and an icon of its health."""

    def draw_item(self, context, layout, data, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        scene = context.scene
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        if item.action is None:
            row.label(text="Deleted Action", icon="ERROR")
            return
        numbers = clip_numbers(scene, item.action)
        # Names are told by their beginnings, numbers only by all of their digits.
        split = row.split(factor=_NAME_SHARES[len(numbers)], align=True)
        name = split.row(align=True)
        name.active = item.use
        icon = "LINKED" if item.action.library else "ACTION" if len(numbers) < 2 else "NONE"
        name.label(text=item.action.name, icon=icon, translate=False)
        if tag_names(item.action):
            name.label(text="", icon="BOOKMARKS")
        # One label: each of its own would lose its last digits to the margins around it.
        column = split.row(align=True)
        column.active, column.alignment = False, "RIGHT"
        column.label(text="  ".join(numbers), translate=False)
        health = health_of(scene, item.action)
        if health is not None:
            icon = "CANCEL" if health.problem else "ERROR" if health.findings else "CHECKMARK"
            row.operator("wayfarer.choose_clip", text="", icon=icon, emboss=False).clip = index

    def draw_filter(self, context, layout):
        settings = context.scene.wayfarer
        layout.prop(self, "filter_name", text="")
        row = layout.row(align=True)
        row.prop(settings, "clip_filter", text="")
        row.prop(settings, "clip_order", text="")
        layout.row(align=True).prop(settings, "clip_columns")

    def filter_items(self, context, data, property_name):
        scene, clips = context.scene, getattr(data, property_name)
        wanted = self.filter_name.lower()
        shown = [
            self.bitflag_filter_item if _is_shown(scene, clip) and _is_called(clip, wanted) else 0 for clip in clips
        ]
        keys = [_sort_key(scene, clip) for clip in clips]
        by_key = sorted(range(len(clips)), key=keys.__getitem__)
        places = [0] * len(clips)
        for place, index in enumerate(by_key):
            places[index] = place
        return shown, places if scene.wayfarer.clip_order != "NAME" else []


def clip_numbers(scene, action) -> list[str]:
    """Return what the chosen columns of the list say about an action."""
    columns, motion = scene.wayfarer.clip_columns, motion_of(scene, action)
    numbers = []
    if "DURATION" in columns:
        numbers.append(time(action_seconds(scene, action)))
    if "DISTANCE" in columns:
        numbers.append(scene_length(scene, motion.distance) if motion else "")
    if "TURN" in columns:
        numbers.append(turn(motion.turn) if motion else "")
    return numbers


def _is_called(clip, wanted: str) -> bool:
    return not wanted or (clip.action is not None and wanted in clip.action.name.lower())


def _is_shown(scene, clip) -> bool:
    kind = scene.wayfarer.clip_filter
    if kind == "ALL" or clip.action is None:
        return kind == "ALL"
    if kind == "USED":
        return clip.use
    if kind == "TAGGED":
        return bool(tag_names(clip.action))
    health = health_of(scene, clip.action)
    return health is not None and not health.is_healthy


def _sort_key(scene, clip) -> float:
    """Smaller comes first; what is not known comes last."""
    order, motion = scene.wayfarer.clip_order, motion_of(scene, clip.action) if clip.action else None
    if order == "DURATION" and clip.action is not None:
        return -action_seconds(scene, clip.action)
    if motion is None or order not in ("DISTANCE", "TURN"):
        return math.inf
    return -motion.distance if order == "DISTANCE" else -motion.turn


class WAYFARER_UL_joint_weights(bpy.types.UIList):
    """The bones of the character, and how much each counts."""

    def draw_item(self, context, layout, data, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.6)
        split.label(text=item.name, icon="BONE_DATA", translate=False)
        split.prop(item, "weight", text="")


class WAYFARER_UL_regions(bpy.types.UIList):
    """The environment's regions: object, rule and tag."""

    def draw_item(self, context, layout, data, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        if item.object is None:
            row.label(text="No Object", icon="ERROR")
        else:
            row.label(text=item.object.name, icon="MESH_PLANE", translate=False)
        rule = item.bl_rna.properties["rule"].enum_items[item.rule].name
        row.label(text=f"{rule} '{item.tag}'", translate=False)


class WAYFARER_UL_worst_frames(bpy.types.UIList):
    """Frames of the last walk that are worth looking at, the worst first; a click shows one."""

    def draw_item(self, context, layout, data, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.17, align=True)
        jump = split.operator("wayfarer.jump_to_frame", text=f"{item.frame}", emboss=False, translate=False)
        jump.worst = index
        # Numbers are told only by all of their digits.
        split = split.split(factor=0.54, align=True)
        split.label(text=item.what, translate=False)
        right = split.row(align=True)
        right.alignment = "RIGHT"
        right.active = item.severity >= 1.0
        right.label(text=item.amount, translate=False)

    def draw_filter(self, context, layout):
        layout.prop(self, "filter_name", text="")

    def filter_items(self, context, data, property_name):
        wanted = self.filter_name.lower()
        return [
            self.bitflag_filter_item if wanted in f"{entry.frame} {entry.what}".lower() else 0
            for entry in getattr(data, property_name)
        ], []


class WAYFARER_UL_clip_weights(bpy.types.UIList):
    """The clips in use, and how much each weighs."""

    def draw_item(self, context, layout, data, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.7)
        if item.action is None:
            split.label(text="Deleted Action", icon="ERROR")
            return
        split.label(text=item.action.name, translate=False)
        split.prop(item, "weight", text="", emboss=False)

    def filter_items(self, context, data, property_name):
        wanted = self.filter_name.lower()
        return [
            self.bitflag_filter_item
            if clip.use and clip.action is not None and wanted in clip.action.name.lower()
            else 0
            for clip in getattr(data, property_name)
        ], []


_SHARES = {
    "ABLATION": (0.66, 1.0),
    "ACTIONS": (0.5, 0.54),
    "CAPTURE": (0.72, 1.0),
    "DELETION": (0.68, 1.0),
    "OCCUPANCY": (0.75, 1.0),
    "WEAK_SPOTS": (0.33, 0.5),
}
"""By topic, shares of a row's width for the name, and of the rest for the value: a sidebar is narrow. Where the value
takes all of it, icon and sentence say what the note says."""


class WAYFARER_UL_findings(bpy.types.UIList):
    """Lines with a name, a number and what to make of it."""

    def draw_item(self, context, layout, data: Any, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        name_share, value_share = _SHARES.get(data.name, (0.66, 1.0))
        split = layout.split(factor=name_share, align=True)
        # The unit of areas stands above the list.
        split.label(text=item.name.removesuffix(" m²"), icon=item.icon, translate=False)
        if not item.note or value_share == 1.0:
            value = split.row()
            value.alignment = "RIGHT"
            value.label(text=item.value, translate=False)
            return
        rest = split.split(factor=value_share, align=True)
        value = rest.row()
        value.alignment = "RIGHT"
        value.label(text=item.value, translate=False)
        note = rest.row()
        note.active = False
        note.label(text=item.note, translate=False)

    def filter_items(self, context, data, property_name):
        """Filter by name or note, in the order of importance that they have."""
        rows, wanted = getattr(data, property_name), self.filter_name.lower()
        if not wanted:
            return [], []
        shown = self.bitflag_filter_item
        return [shown if wanted in f"{row.name} {row.note}".lower() else 0 for row in rows], []


CLASSES = (
    WAYFARER_UL_clips,
    WAYFARER_UL_joint_weights,
    WAYFARER_UL_regions,
    WAYFARER_UL_worst_frames,
    WAYFARER_UL_clip_weights,
    WAYFARER_UL_findings,
)
