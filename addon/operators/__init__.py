"""The operators, one file for each panel: gather input, call one function, report."""

import bpy

from . import (
    clips,
    embedding,
    environment,
    evaluation,
    export_files,
    floor_map,
    health,
    import_files,
    motion_graph,
    queries,
    samples,
    tuning,
    walk,
)

CLASSES = (
    *samples.CLASSES,
    *import_files.CLASSES,
    *clips.CLASSES,
    *health.CLASSES,
    *motion_graph.CLASSES,
    *environment.CLASSES,
    *embedding.CLASSES,
    *floor_map.CLASSES,
    *evaluation.CLASSES,
    *tuning.CLASSES,
    *queries.CLASSES,
    *walk.CLASSES,
    *export_files.CLASSES,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)  # pyright: ignore[reportGeneralTypeIssues]
