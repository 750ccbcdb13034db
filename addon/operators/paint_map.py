"""Paint what was found on the floor."""

import bpy

from ..jobs import LongOperator
from ..render.floor import FLOOR_NAME
from ..render.viewport import show_colors
from ..results.painting import paint_floor
from ..results.state import embedding_of
from .asks_embedding import LooksAtEmbedding

__all__ = ["FLOOR_NAME", "WAYFARER_OT_paint_map"]


class WAYFARER_OT_paint_map(LooksAtEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.paint_map"
    bl_label = "Paint Map"
    bl_description = (
        "Colour the floor: the lighter, the more ways to pass, red where the character cannot go; or by the reason "
        "why it cannot"
    )

    def steps(self, context):
        embedding, settings = embedding_of(context.scene), context.scene.wayfarer.map
        key, offset = settings.key, settings.offset
        painted = yield from settings.kind.paint_steps(embedding, settings.to_core())
        return embedding, key, offset, painted

    def apply(self, context, result):
        embedding, key, offset, painted = result
        paint_floor(context.scene, embedding, painted, key, offset, in_operator=True)
        show_colors(context.screen, context.scene)
        self.report({"INFO"}, painted.report)
        self.warn_if_stale(context.scene)
