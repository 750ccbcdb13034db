"""Names to choose from: of the motion graph that was embedded, because that is what walks, maps and questions use."""

from collections.abc import Callable
from typing import Any

from ...core.motion.graph import MotionGraph


def segment_names(settings, context, typed: str) -> list[str]:
    graph = _graph(settings)
    return matching((segment.name for segment in graph.segments) if graph is not None else (), typed)


def clip_names(settings, context, typed: str) -> list[str]:
    graph = _graph(settings)
    if graph is None:
        return []
    played = sorted({segment.clip for segment in graph.segments})
    return matching((graph.clips[clip].name for clip in played), typed)


def tag_names(settings, context, typed: str) -> list[str]:
    graph = _graph(settings)
    return matching(sorted({tag for s in graph.segments for tag in s.tags}) if graph is not None else (), typed)


def bone_names(settings, context, typed: str) -> list[str]:
    character = settings.id_data.wayfarer.character
    return matching((bone.name for bone in character.data.bones), typed) if character else []


def matching(names, typed: str) -> list[str]:
    """Those of the names in which what was typed occurs."""
    return [name for name in names if typed.lower() in name.lower()]


def _no_graph(scene) -> MotionGraph | None:
    return None


class GraphSource:
    """Find the motion graph of a scene for those who choose names from it.

    The results lie above the settings, so that they say here how they are reached.
    """

    def __init__(self):
        self.graph_of: Callable[[Any], MotionGraph | None] = _no_graph

    def clear(self) -> None:
        self.graph_of = _no_graph


SOURCE = GraphSource()


def _graph(settings):
    return SOURCE.graph_of(settings.id_data)
