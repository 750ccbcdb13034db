"""Lists of clips, bones and regions."""

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
    """What the chosen columns of the list say about an action."""
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
