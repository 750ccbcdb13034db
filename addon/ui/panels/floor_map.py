"""What is painted on the floor."""

import bpy

from ...properties import MapQuantity
from ...render.reason_colors import reason_legend
from ...state import map_is_stale, results
from ..swatches import swatch
from .step import Step, draw_numbers, draw_table


class WAYFARER_PT_map(Step, bpy.types.Panel):
    bl_label = "Map"

    def result_is_there(self, scene):
        return results(scene).painted is not None

    def result_is_stale(self, scene):
        return map_is_stale(scene)

    def draw(self, context):
        layout, settings = self.layout, context.scene.wayfarer.map
        layout.row().prop(settings, "quantity", expand=True)
        layout.operator("wayfarer.paint_map", icon="BRUSH_DATA")
        found = results(context.scene)
        if found.painted is None:
            return
        _, quantity = found.painted
        numbers = found.summary
        if quantity == MapQuantity.WHY_NOT.name:
            legend = reason_legend()
            shares = sorted(numbers["reasons"].items(), key=lambda item: -item[1])
            rows = [(legend[name][0], _percent(share), swatch(name)) for name, share in shares]
            draw_table(layout, rows, factor=0.8)
            return
        unit = "ways" if quantity == MapQuantity.VARIABILITY.name else "headings"
        draw_numbers(
            layout,
            (
                ("Cells Covered", f"{numbers['map_cells']:,}"),
                ("Most in a Cell", f"{numbers['map_highest']:,} {unit}"),
            ),
        )


def _percent(share: float) -> str:
    return f"{share:.0%}" if share >= 0.005 else "< 1%"


PANELS = (WAYFARER_PT_map,)
