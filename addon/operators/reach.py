"""How long it takes to get somewhere, or from there."""

import bpy

from ...core.evaluation.query import query_steps
from ...core.maps import QUERY
from ...core.maps.times import paint_query
from ...core.report.topics.times import reach_finding
from ..jobs import LongOperator
from ..render.viewport import show_colors
from ..results.findings import keep_finding
from ..results.shown import paint_floor
from ..results.store import embedding_of
from .asks_embedding import AsksEmbedding


class WAYFARER_OT_find_reach(AsksEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.find_reach"
    bl_label = "Find Times"
    bl_description = (
        "Find out how long it takes at least to get to the goal, or from it, paint the times on the floor and tell the "
        "area within reach"
    )

    def steps(self, context):
        settings = context.scene.wayfarer
        embedding, options = embedding_of(context.scene), settings.map.to_core()
        field = yield from query_steps(embedding, options.query)
        return reach_finding(field, options.query), paint_query(field, options)

    def apply(self, context, result):
        finding, painted = result
        scene, settings = context.scene, context.scene.wayfarer.map
        # First, because it may be refused: then nothing has changed.
        key = settings.key_of(QUERY)
        paint_floor(scene, finding.embedding, painted, key, settings.offset, in_operator=True)
        keep_finding(scene, finding)
        settings.quantity = QUERY.name
        show_colors(context.screen, scene)
        self.report({"INFO"}, painted.report)
        self.warn_if_stale(scene)
