"""The steps of the workflow, one file each: gather input, call one function, report."""

import bpy

from .add_sample_character import WAYFARER_OT_add_sample_character
from .add_sample_room import WAYFARER_OT_add_sample_room
from .apply_remedy import WAYFARER_OT_apply_remedy
from .build_motion_graph import WAYFARER_OT_build_motion_graph
from .choose_clip import WAYFARER_OT_choose_clip
from .count_lost_links import WAYFARER_OT_count_lost_links
from .edit_regions import WAYFARER_OT_add_region, WAYFARER_OT_remove_region
from .embed import WAYFARER_OT_embed
from .examine_clips import WAYFARER_OT_examine_clips
from .guess_weights import WAYFARER_OT_guess_weights
from .import_bvh import WAYFARER_OT_import_bvh
from .paint_map import WAYFARER_OT_paint_map
from .random_walk import WAYFARER_OT_random_walk
from .refresh_clips import WAYFARER_OT_refresh_clips
from .show_contacts import WAYFARER_OT_show_contacts

_CLASSES = (
    WAYFARER_OT_add_sample_character,
    WAYFARER_OT_add_sample_room,
    WAYFARER_OT_import_bvh,
    WAYFARER_OT_refresh_clips,
    WAYFARER_OT_choose_clip,
    WAYFARER_OT_examine_clips,
    WAYFARER_OT_apply_remedy,
    WAYFARER_OT_show_contacts,
    WAYFARER_OT_guess_weights,
    WAYFARER_OT_build_motion_graph,
    WAYFARER_OT_add_region,
    WAYFARER_OT_remove_region,
    WAYFARER_OT_embed,
    WAYFARER_OT_count_lost_links,
    WAYFARER_OT_paint_map,
    WAYFARER_OT_random_walk,
)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
