"""The steps of the workflow, one file each: gather input, call one function, report."""

import bpy

from .ablate import WAYFARER_OT_ablate
from .add_sample_character import WAYFARER_OT_add_sample_character
from .add_sample_room import WAYFARER_OT_add_sample_room
from .append_actions import WAYFARER_OT_append_actions
from .apply_remedy import WAYFARER_OT_apply_remedy
from .build_motion_graph import WAYFARER_OT_build_motion_graph
from .capture import WAYFARER_OT_direct_capture
from .choose_clip import WAYFARER_OT_choose_clip
from .count_lost_links import WAYFARER_OT_count_lost_links
from .crowd import WAYFARER_OT_crowd, WAYFARER_OT_remove_crowd
from .edit_regions import WAYFARER_OT_add_region, WAYFARER_OT_remove_region
from .embed import WAYFARER_OT_embed
from .examine_clips import WAYFARER_OT_examine_clips
from .export_engine import WAYFARER_OT_export_engine
from .export_results import WAYFARER_OT_export_results
from .find_deletable import WAYFARER_OT_find_deletable
from .fit_radius import WAYFARER_OT_fit_radius
from .guess_weights import WAYFARER_OT_guess_weights
from .import_bvh import WAYFARER_OT_import_bvh
from .jump_to_frame import WAYFARER_OT_jump_to_frame
from .metrics import WAYFARER_OT_measure
from .occupancy import WAYFARER_OT_find_occupancy
from .paint_map import WAYFARER_OT_paint_map
from .pick_place import WAYFARER_OT_pick_place
from .pick_walks_from import WAYFARER_OT_pick_walks_from
from .prune import WAYFARER_OT_prune
from .random_walk import WAYFARER_OT_random_walk
from .reach import WAYFARER_OT_find_reach
from .refresh_clips import WAYFARER_OT_refresh_clips
from .restore_embedding import WAYFARER_OT_restore_embedding
from .show_chart import WAYFARER_OT_show_chart
from .show_contacts import WAYFARER_OT_show_contacts
from .sweep_pruning import WAYFARER_OT_sweep_pruning
from .untick_clips import WAYFARER_OT_untick_clips
from .walks_from import WAYFARER_OT_clear_walks_from, WAYFARER_OT_walks_from
from .weak_spots import WAYFARER_OT_find_weak_spots
from .write_report import WAYFARER_OT_write_report

_CLASSES = (
    WAYFARER_OT_add_sample_character,
    WAYFARER_OT_add_sample_room,
    WAYFARER_OT_import_bvh,
    WAYFARER_OT_append_actions,
    WAYFARER_OT_refresh_clips,
    WAYFARER_OT_choose_clip,
    WAYFARER_OT_examine_clips,
    WAYFARER_OT_apply_remedy,
    WAYFARER_OT_show_contacts,
    WAYFARER_OT_fit_radius,
    WAYFARER_OT_guess_weights,
    WAYFARER_OT_build_motion_graph,
    WAYFARER_OT_add_region,
    WAYFARER_OT_remove_region,
    WAYFARER_OT_embed,
    WAYFARER_OT_count_lost_links,
    WAYFARER_OT_paint_map,
    WAYFARER_OT_pick_place,
    WAYFARER_OT_random_walk,
    WAYFARER_OT_jump_to_frame,
    WAYFARER_OT_crowd,
    WAYFARER_OT_remove_crowd,
    WAYFARER_OT_measure,
    WAYFARER_OT_find_weak_spots,
    WAYFARER_OT_ablate,
    WAYFARER_OT_find_deletable,
    WAYFARER_OT_untick_clips,
    WAYFARER_OT_direct_capture,
    WAYFARER_OT_find_occupancy,
    WAYFARER_OT_show_chart,
    WAYFARER_OT_prune,
    WAYFARER_OT_restore_embedding,
    WAYFARER_OT_sweep_pruning,
    WAYFARER_OT_find_reach,
    WAYFARER_OT_walks_from,
    WAYFARER_OT_clear_walks_from,
    WAYFARER_OT_pick_walks_from,
    WAYFARER_OT_export_results,
    WAYFARER_OT_export_engine,
    WAYFARER_OT_write_report,
)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
