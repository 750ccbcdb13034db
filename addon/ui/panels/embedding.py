"""Where the motion graph fits into the scene."""

import bpy

from ...state import embedding_is_stale, lost_links, results
from .step import Step, draw_numbers, split_properties


class WAYFARER_PT_embedding(Step, bpy.types.Panel):
    bl_label = "Embedding"

    def result_is_there(self, scene):
        return results(scene).embedding is not None

    def result_is_stale(self, scene):
        return embedding_is_stale(scene)

    def draw(self, context):
        layout, settings = split_properties(self.layout), context.scene.wayfarer.embedding
        column = layout.column()
        column.prop(settings, "footprint_rule")
        column.prop(settings, "position_rate")
        column.prop(settings, "heading_rate")
        layout.operator("wayfarer.embed", icon="LIGHTPROBE_VOLUME")
        found = results(context.scene)
        if found.embedding is None:
            return
        nx, ny, n_headings, _ = found.embedding.shape
        numbers = found.summary
        draw_numbers(
            layout,
            (
                ("Grid", f"{nx} x {ny} x {n_headings}"),
                ("Nodes", f"{numbers['nodes']:,}"),
                ("Links", f"{numbers['links']:,}"),
                ("Floor Covered", f"{numbers['coverage']:.0%}"),
            ),
        )
        lost = lost_links(context.scene)
        if lost is None:
            layout.operator("wayfarer.count_lost_links", icon="UNLINKED")
            return
        draw_numbers(
            layout,
            (
                ("On Empty Ground", f"{lost.possible:,}"),
                ("Lost to Obstacles", _part(lost.obstacles, lost.possible)),
                ("Lost to Regions", _part(lost.regions, lost.possible)),
                ("Lead Nowhere", _part(lost.free - lost.embedded, lost.possible)),
                ("In the Embedding", _part(lost.embedded, lost.possible)),
            ),
        )


def _part(count: int, of: int) -> str:
    return f"{count / of:.0%} ({_short(count)})" if of else "0"


def _short(count: int) -> str:
    """A large number in as few characters as a narrow panel has room for."""
    for size, letter in ((10**9, "G"), (10**6, "M"), (10**3, "k")):
        if count >= size:
            return f"{count / size:.3g} {letter}"
    return str(count)


PANELS = (WAYFARER_PT_embedding,)
