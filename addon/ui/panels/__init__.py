"""The panels, in the order of the work."""

from . import clips, embedding, environment, evaluation, floor_map, motion_graph, queries, tuning, walk

PANELS = (
    *clips.PANELS,
    *motion_graph.PANELS,
    *environment.PANELS,
    *embedding.PANELS,
    *floor_map.PANELS,
    *evaluation.PANELS,
    *tuning.PANELS,
    *queries.PANELS,
    *walk.PANELS,
)
