"""The panels, in the order of the work."""

from . import clips, embedding, environment, floor_map, motion_graph, walk

PANELS = (
    *clips.PANELS,
    *motion_graph.PANELS,
    *environment.PANELS,
    *embedding.PANELS,
    *floor_map.PANELS,
    *walk.PANELS,
)
