"""The operators, one file for each panel: gather input, call one function, report."""

import bpy

from . import clips, embedding, environment, find_out, floor_map, import_files, motion_graph, samples
from .crowd import WAYFARER_OT_crowd, WAYFARER_OT_remove_crowd
from .export_engine import WAYFARER_OT_export_engine
from .export_results import WAYFARER_OT_export_results
from .jump_to_frame import WAYFARER_OT_jump_to_frame
from .pick_walks_from import WAYFARER_OT_pick_walks_from
from .prune import WAYFARER_OT_prune
from .random_walk import WAYFARER_OT_random_walk
from .reach import WAYFARER_OT_find_reach
from .restore_embedding import WAYFARER_OT_restore_embedding
from .show_chart import WAYFARER_OT_show_chart
from .show_contacts import WAYFARER_OT_show_contacts
from .untick_clips import WAYFARER_OT_untick_clips
from .walks_from import WAYFARER_OT_clear_walks_from, WAYFARER_OT_walks_from
from .write_report import WAYFARER_OT_write_report

CLASSES = (
    *samples.CLASSES,
    *import_files.CLASSES,
    *clips.CLASSES,
    WAYFARER_OT_show_contacts,
    *motion_graph.CLASSES,
    *environment.CLASSES,
    *embedding.CLASSES,
    *floor_map.CLASSES,
    WAYFARER_OT_random_walk,
    WAYFARER_OT_jump_to_frame,
    WAYFARER_OT_crowd,
    WAYFARER_OT_remove_crowd,
    *find_out.CLASSES,
    WAYFARER_OT_untick_clips,
    WAYFARER_OT_show_chart,
    WAYFARER_OT_prune,
    WAYFARER_OT_restore_embedding,
    WAYFARER_OT_find_reach,
    WAYFARER_OT_walks_from,
    WAYFARER_OT_clear_walks_from,
    WAYFARER_OT_pick_walks_from,
    WAYFARER_OT_export_results,
    WAYFARER_OT_export_engine,
    WAYFARER_OT_write_report,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)  # pyright: ignore[reportGeneralTypeIssues]
