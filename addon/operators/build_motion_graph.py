"""Cut the clips into segments and link those that flow into each other."""

import bpy

from ...core.errors import ClipError
from ...core.motion.graph import build_motion_graph_steps
from ...core.progress import Progress
from ..inputs import actions_fingerprint, graph_settings, prepared_clips_steps, read_character
from ..jobs import LongOperator
from ..state import keep_graph, results
from .needs_clips import NeedsClips


class WAYFARER_OT_build_motion_graph(NeedsClips, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.build_motion_graph"
    bl_label = "Build Motion Graph"
    bl_description = "Cut the clips into segments and find out which may follow which"

    def steps(self, context):
        scene = context.scene
        clips, problems = read_character(scene)
        if not clips:
            name, reason = problems[0]
            raise ClipError(f"No action of '{scene.wayfarer.character.name}' can be used. '{name}': {reason}")
        actions, settings = actions_fingerprint(scene), graph_settings(scene)
        steady_heading, mirror = scene.wayfarer.graph.steady_heading, scene.wayfarer.graph.mirror_clips
        yield Progress(0.0, "Reading clips")
        clips = yield from prepared_clips_steps(clips, steady_heading, mirror)
        graph = yield from build_motion_graph_steps(clips, settings)
        return graph, actions, len(clips), problems

    def apply(self, context, result):
        graph, actions, n_clips, problems = result
        keep_graph(context.scene, graph, actions)
        played = len({segment.clip for segment in graph.segments})
        seconds = sum(segment.duration for segment in graph.segments)
        dropped = sum(dropped.seconds for dropped in graph.dropped)
        results(context.scene).summary.update(
            clips=n_clips, clips_played=played, motion_seconds=seconds, dropped_seconds=dropped
        )
        for name, reason in problems:
            self.report({"WARNING"}, f"Left out '{name}': {reason}")
        self.report(
            {"INFO"}, f"{len(graph.segments)} segments, {len(graph.links)} links from {played} of {n_clips} clips"
        )
