"""Paint what was found on the floor."""

import bpy

from ..jobs import LongOperator
from ..render.floor import FLOOR_NAME, put_on_floor
from ..render.viewport import show_colors
from ..state import embedding_of, keep_painted, results
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
        scene, found = context.scene, results(context.scene)
        floor = put_on_floor(scene, embedding.environment.grid, found.ground_height, offset, painted, in_operator=True)
        show_colors(context.screen, scene)
        keep_painted(scene, floor, embedding, key, in_operator=True)
        found.summary.update(painted.numbers)
        self.report({"INFO"}, painted.report)
        self.warn_if_stale(scene)
