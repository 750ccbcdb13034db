"""Paint what was found on the floor."""

import bpy

from ..advice import stale_advice
from ..jobs import LongOperator
from ..render.floor import FLOOR_NAME, put_on_floor
from ..render.viewport import show_colors
from ..state import embedding_of, keep_painted, results

__all__ = ["FLOOR_NAME", "WAYFARER_OT_paint_map"]


class WAYFARER_OT_paint_map(LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.paint_map"
    bl_label = "Paint Map"
    bl_description = (
        "Colour the floor: the lighter, the more ways to pass, red where the character cannot go; or by the reason "
        "why it cannot"
    )

    @classmethod
    def poll(cls, context):
        if results(context.scene).embedding is None:
            cls.poll_message_set("Embed the motion graph first")
            return False
        return True

    def steps(self, context):
        embedding, settings = embedding_of(context.scene), context.scene.wayfarer.map
        key, offset = settings.key, settings.offset
        painted = yield from settings.kind.paint_steps(embedding, settings.to_core())
        return embedding, key, offset, painted

    def apply(self, context, result):
        embedding, key, offset, painted = result
        scene, found = context.scene, results(context.scene)
        floor = put_on_floor(scene, embedding.environment.grid, found.ground_height, offset, painted)
        show_colors(context.screen, scene)
        keep_painted(scene, floor, embedding, key)
        found.summary.update(painted.numbers)
        self.report({"INFO"}, painted.report)
        for sentence in stale_advice(scene):
            self.report({"WARNING"}, sentence)
