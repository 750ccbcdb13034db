"""Unroll the motion graph into the scene."""

import bpy

from ...core.embedding.embedding import embed_steps
from ...core.evaluation.variability import coverage_share
from ...core.progress import Progress
from ..inputs import make_environment, read_shapes
from ..jobs import LongOperator
from ..state import keep_embedding, results


class WAYFARER_OT_embed(LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.embed"
    bl_label = "Embed"
    bl_description = "Find out where in the scene the character can go, and by which segments"

    @classmethod
    def poll(cls, context):
        environment = context.scene.wayfarer.environment
        if results(context.scene).graph is None:
            cls.poll_message_set("Build the motion graph first")
        elif not environment.has_ground:
            cls.poll_message_set("Choose a ground or obstacles in the Environment panel first")
        else:
            return True
        return False

    def steps(self, context):
        scene = context.scene
        shapes = read_shapes(scene, context.evaluated_depsgraph_get())
        environment = make_environment(scene, shapes)
        found, settings = results(scene), scene.wayfarer.embedding.to_core()
        yield Progress(0.0, "Reading the scene")
        # What did not move since the last time need not be computed again.
        embedding = yield from embed_steps(found.graph, environment, settings, found.embedding)
        # Counted here, because counting takes about as long as embedding.
        yield Progress(1.0, "Counting links")
        share, _ = coverage_share(embedding), embedding.n_links
        return embedding, shapes, share

    def apply(self, context, result):
        embedding, shapes, share = result
        keep_embedding(context.scene, embedding, shapes)
        results(context.scene).summary.update(nodes=embedding.n_nodes, links=embedding.n_links, coverage=share)
        if embedding.n_nodes == 0:
            self.report({"WARNING"}, "The character cannot go anywhere: no endless walk fits into this scene")
        else:
            self.report(
                {"INFO"},
                f"{embedding.n_nodes:,} nodes, {embedding.n_links:,} links, {share:.0%} of the free floor covered",
            )
