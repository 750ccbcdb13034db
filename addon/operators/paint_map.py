"""Paint what was found on the floor."""

import bpy

from ...core.evaluation.variability import coverage, floor_variability
from ...core.evaluation.why_not import why_not_steps
from ...core.progress import Progress
from ..bridge.write_colors import ground_grid, paint
from ..jobs import LongOperator
from ..properties import MapQuantity
from ..render.map_colors import map_colors
from ..render.reason_colors import floor_reasons, reason_colors, reason_shares
from ..render.viewport import show_colors
from ..scene_collections import OUTPUT, ensure_collection
from ..state import results

FLOOR_NAME = "Wayfarer Floor"
_ABOVE = 0.004
"""Metres above the ground: the two must not flicker through each other."""


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
        embedding = results(context.scene).embedding
        quantity = MapQuantity[context.scene.wayfarer.map.quantity]
        if quantity is MapQuantity.WHY_NOT:
            reasons = floor_reasons((yield from why_not_steps(embedding)))
            return embedding, quantity, reason_colors(reasons), {"reasons": reason_shares(reasons)}
        yield Progress(0.1, f"Counting {quantity.value}")
        if quantity is MapQuantity.VARIABILITY:
            values = floor_variability(embedding)
        else:
            values = coverage(embedding).sum(axis=2)
        numbers = {"map_highest": int(values.max()), "map_cells": int((values > 0).sum())}
        return embedding, quantity, map_colors(values, embedding.environment), numbers

    def apply(self, context, result):
        embedding, quantity, colors, numbers = result
        grid = embedding.environment.grid
        nx, ny, _ = grid.shape
        found = results(context.scene)
        floor = ground_grid(
            FLOOR_NAME,
            *grid.origin,
            grid.cell_size,
            nx,
            ny,
            found.ground_height + _ABOVE,
            ensure_collection(context.scene, OUTPUT),
        )
        paint(floor, colors)
        show_colors(context.screen)
        found.painted = (embedding, quantity.name)
        found.summary.update(numbers)
        if quantity is MapQuantity.WHY_NOT:
            share = 1 - numbers["reasons"].get("EMBEDDED", 0.0)
            self.report({"INFO"}, f"The character cannot go to {share:.0%} of {nx * ny:,} cells")
            return
        unit = "ways" if quantity is MapQuantity.VARIABILITY else "headings"
        self.report(
            {"INFO"},
            f"{numbers['map_cells']:,} of {nx * ny:,} cells covered, up to {numbers['map_highest']:,} {unit} in a cell",
        )
