"""Joint weights, and the motion graph."""

import bpy

from ...core.motion.distance import joint_weights
from ...core.wording import counted
from ..bridge.rig import bind_rig
from ..jobs import LongOperator
from ..results.workflow import build_graph_steps, keep_built
from .mixins import NeedsCharacter, NeedsClips, reports_errors


class WAYFARER_OT_guess_weights(NeedsCharacter, bpy.types.Operator):
    bl_idname = "wayfarer.guess_weights"
    bl_label = "Guess Weights"
    bl_description = (
        "Fill the list with all bones of the character and the weights guessed from their names: one for hips, "
        "spine, legs and arms, zero for the rest"
    )
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context):
        settings = context.scene.wayfarer
        skeleton = bind_rig(settings.character).skeleton
        weights = joint_weights(skeleton)
        settings.graph.set_weights(dict(zip(skeleton.names, weights.tolist(), strict=True)))
        self.report({"INFO"}, f"{(weights > 0).sum()} of {counted(len(weights), 'bone')} count when poses are compared")


class WAYFARER_OT_build_motion_graph(NeedsClips, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.build_motion_graph"
    bl_label = "Build Motion Graph"
    bl_description = "Cut the clips into segments and find out which may follow which"

    def steps(self, context):
        return build_graph_steps(context.scene)

    def apply(self, context, result):
        keep_built(context.scene, result)
        for name, reason in result.problems:
            self.report({"WARNING"}, f"Left out '{name}': {reason}")
        graph, played = result.graph, len({segment.clip for segment in result.graph.segments})
        self.report(
            {"INFO"},
            f"{counted(len(graph.segments), 'segment')}, {counted(len(graph.links), 'link')} from {played} of "
            f"{counted(result.n_clips, 'clip')}",
        )


CLASSES = (WAYFARER_OT_guess_weights, WAYFARER_OT_build_motion_graph)
