"""Let the character walk, and bake the walk."""

import bpy

from ...core.playback.styles import STYLES, walk_steps
from ...core.playback.walk_motion import motion_steps
from ...core.progress import Progress, portion
from ..bridge.text import counted, length, time
from ..bridge.text import slide as slide_words
from ..jobs import LongOperator
from ..results.advice import start_advice
from ..results.store import embedding_of, results
from ..walks.baking import bake_motion
from ..walks.request import read_motion_request, read_request, walk_problem
from .needs_embedding import NeedsEmbedding


class WAYFARER_OT_random_walk(NeedsEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.random_walk"
    bl_label = "Walk"
    bl_description = "Walk through the scene in the chosen style and bake the motion"

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        problem = walk_problem(context)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def steps(self, context):
        request = read_request(context)
        motion_request = read_motion_request(context.scene, closed=STYLES[request.style].closed)
        embedding = embedding_of(context.scene)
        walk = yield from portion(walk_steps(embedding, request), 0.0, 0.5)
        motion = yield from portion(motion_steps(walk, motion_request), 0.5, 0.9)
        yield Progress(0.9, "Baking")
        return motion, request.start

    def apply(self, context, result):
        motion, start = result
        bake_motion(context.scene, motion)
        numbers, walk = results(context.scene).summary.walk, motion.walk
        advice = start_advice(start, walk)
        if advice:
            self.report({"WARNING"}, advice)
        slide = f", feet slide {slide_words(motion.after.mean_slide)}" if motion.after.feet else ""
        self.report(
            {"INFO"},
            f"A walk of {time(walk.duration)} over {length(numbers.length)}, {counted(len(walk), 'segment')}{slide}",
        )
        self.warn_if_stale(context.scene)
