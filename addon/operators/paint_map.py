"""Paint what was found on the floor."""

import bpy

from ...core.evaluation.variability import coverage, floor_variability
from ...core.progress import Progress
from ..bridge.write_colors import ground_grid, paint
from ..jobs import LongOperator
from ..properties import MapQuantity
from ..render.map_colors import map_colors
from ..scene_collections import OUTPUT, ensure_collection
from ..state import results

FLOOR_NAME = "Wayfarer Floor"
_ABOVE = 0.004
"""Metres above the ground: the two must not flicker through each other."""


class WAYFARER_OT_paint_map(LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.paint_map"
    bl_label = "Paint Map"
    bl_description = "Colour the floor: the lighter, the more ways to pass; red where the character cannot go"

    @classmethod
    def poll(cls, context):
        if results(context.scene).embedding is None:
            cls.poll_message_set("Embed the motion graph first")
            return False
        return True

    def steps(self, context):
        embedding = results(context.scene).embedding
        quantity = MapQuantity[context.scene.wayfarer.map.quantity]
        yield Progress(0.1, f"Counting {quantity.value}")
        if quantity is MapQuantity.VARIABILITY:
            values = floor_variability(embedding)
        else:
            values = coverage(embedding).sum(axis=2)
        return embedding, quantity, values

    def apply(self, context, result):
        embedding, quantity, values = result
        grid = embedding.environment.grid
        nx, ny, _ = grid.shape
        floor = ground_grid(
            FLOOR_NAME,
            *grid.origin,
            grid.cell_size,
            nx,
            ny,
            results(context.scene).ground_height + _ABOVE,
            ensure_collection(context.scene, OUTPUT),
        )
        paint(floor, map_colors(values, embedding.environment))
        found = results(context.scene)
        found.painted = (embedding, quantity.name)
        found.summary.update(map_highest=int(values.max()), map_cells=int((values > 0).sum()))
        unit = "ways" if quantity is MapQuantity.VARIABILITY else "headings"
        self.report(
            {"INFO"}, f"{(values > 0).sum():,} of {nx * ny:,} cells covered, up to {values.max():,} {unit} in a cell"
        )
