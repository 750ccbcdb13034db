"""Cut the clips into segments and link those that flow into each other."""

import bpy

from ..bridge.text import counted
from ..jobs import LongOperator
from ..results.workflow import build_graph_steps, keep_built
from .needs_clips import NeedsClips


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
