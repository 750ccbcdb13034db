"""The embedding of the motion graph in the scene."""

import bpy

from ....core.wording import angle, memory, number, share, share_of, short, small
from ...results.advice import embedding_advice
from ...results.staleness import embedding_changes, embedding_is_stale
from ...results.store import lost_links, results
from ..drawing import Sidebar, Step, draw_numbers, draw_sentences, split_properties


class WAYFARER_PT_embedding(Step, bpy.types.Panel):
    bl_label = "Embedding"
    presets = "embedding"

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
        # Both are rates, and fields cannot say so: no unit of Blender's is "per metre".
        limits = (small(settings.position_rate), angle(settings.heading_rate))
        draw_numbers(column, (("At Most", f"{limits[0]} per m"), ("", f"{limits[1]} per m")))
        layout.operator("wayfarer.embed", icon="LIGHTPROBE_VOLUME")
        scene = context.scene
        found = results(scene)
        if found.embedding is None:
            draw_sentences(context, layout, _next_step(scene), "INFO")
            return
        draw_sentences(context, layout, embedding_changes(scene))
        nx, ny, n_headings, _ = found.embedding.shape
        numbers = found.summary
        draw_numbers(
            layout,
            (
                ("Grid", f"{nx} x {ny} x {n_headings}"),
                ("Nodes", number(numbers.nodes)),
                ("Links", number(numbers.links)),
                ("Floor Covered", share(numbers.coverage)),
            ),
        )
        if found.pruning is not None:
            draw_sentences(context, layout, [f"Pruned: {found.pruning.words.lower()}; see Tuning"], "INFO")
        draw_sentences(context, layout, embedding_advice(scene))


def _next_step(scene) -> list[str]:
    """Return what has to be done before anything can be embedded."""
    if results(scene).graph is None:
        return ["Build the motion graph first"]
    return [] if scene.wayfarer.environment.has_ground else ["Choose a ground or obstacles in Environment"]


class WAYFARER_PT_lost_links(Sidebar, bpy.types.Panel):
    bl_label = "Lost Links"
    bl_parent_id = "WAYFARER_PT_embedding"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return results(context.scene).embedding is not None

    def draw(self, context):
        layout = self.layout
        lost = lost_links(context.scene)
        if lost is None:
            layout.operator("wayfarer.count_lost_links", icon="UNLINKED")
            return
        draw_numbers(
            layout,
            (
                ("On Empty Ground", number(lost.possible)),
                ("Lost to Obstacles", _part(lost.obstacles, lost.possible)),
                ("Lost to Regions", _part(lost.regions, lost.possible)),
                ("Lead Nowhere", _part(lost.free - lost.embedded, lost.possible)),
                ("In the Embedding", _part(lost.embedded, lost.possible)),
            ),
        )


class WAYFARER_PT_file(Sidebar, bpy.types.Panel):
    bl_label = "File"
    bl_parent_id = "WAYFARER_PT_embedding"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.prop(context.scene.wayfarer, "keep_results")
        size = results(context.scene).stored_bytes
        if size and context.scene.wayfarer.keep_results:
            draw_numbers(layout, (("When Last Saved", memory(size)),))


def _part(count: int, of: int) -> str:
    return f"{share_of(count, of)} ({short(count)})" if of else "0"


PANELS = (WAYFARER_PT_embedding, WAYFARER_PT_lost_links, WAYFARER_PT_file)
