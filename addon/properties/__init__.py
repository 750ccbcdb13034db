"""The settings of a scene, ``scene.wayfarer``: what the panels show and the operators read.

Defaults are those of the core's settings where it has them. Settings, findings and the report on the last walk are
properties: saved and undone with the scene. Graphs, embeddings and walks are not (see the room
:mod:`..results`); :mod:`..results.file` puts them into files.
"""

import bpy

from . import (
    character,
    clips,
    embedding,
    environment,
    evaluation,
    findings,
    floor_map,
    motion_graph,
    presets,
    queries,
    scene,
    tuning,
    walk,
)
from .environment import GroundSource
from .floor_map import MapQuantity

__all__ = ["CLASSES", "GroundSource", "MapQuantity", "register", "unregister"]

# A group comes after those that it is made of.
CLASSES = (
    *clips.CLASSES,
    *motion_graph.CLASSES,
    *environment.CLASSES,
    *embedding.CLASSES,
    *floor_map.CLASSES,
    *walk.CLASSES,
    *findings.CLASSES,
    *evaluation.CLASSES,
    *tuning.CLASSES,
    *queries.CLASSES,
    *character.CLASSES,
    *scene.CLASSES,
)


_register, _unregister = bpy.utils.register_classes_factory((*CLASSES, *presets.CLASSES))  # pyright: ignore[reportGeneralTypeIssues]


def register():
    _register()
    bpy.types.Scene.wayfarer = bpy.props.PointerProperty(type=scene.WayfarerSceneSettings)


def unregister():
    del bpy.types.Scene.wayfarer
    _unregister()
