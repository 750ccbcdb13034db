"""Walks and crowds."""

import bpy
from bpy.props import IntProperty

from ...core.playback.styles import STYLES, walk_steps
from ...core.playback.walk_motion import motion_steps
from ...core.progress import Progress, portion
from ...core.wording import counted, length, time
from ...core.wording import slide as slide_words
from ..bridge.copies import find_copies
from ..jobs import LongOperator
from ..results.advice import start_advice
from ..results.shown import find_walk
from ..results.store import embedding_of, results
from ..walks.baking import bake_motion
from ..walks.crowd import CROWD_COLLECTION, crowd_walk_steps, keep_crowd, remove_crowd
from ..walks.request import read_motion_request, read_request, walk_problem
from .mixins import Needs, NeedsEmbedding


class WAYFARER_OT_random_walk(NeedsEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.random_walk"
    bl_label = "Walk"
    bl_description = "Walk through the scene in the chosen style and bake the motion"

    @classmethod
    def problem(cls, context):
        return super().problem(context) or walk_problem(context)

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


class WAYFARER_OT_jump_to_frame(bpy.types.Operator):
    bl_idname = "wayfarer.jump_to_frame"
    bl_label = "Jump to Frame"
    bl_description = "Choose this entry of the list and show its frame"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    worst: IntProperty(name="Worst Frame", description="Place in the list", min=0, options={"SKIP_SAVE"})

    def execute(self, context):
        report = context.scene.wayfarer.walk.report
        if self.worst >= len(report.worst):
            return {"CANCELLED"}
        # Choosing it shows it.
        report.active_worst = self.worst
        return {"FINISHED"}


class WAYFARER_OT_crowd(NeedsEmbedding, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.crowd"
    bl_label = "Crowd"
    bl_description = (
        "Let copies of the character walk at the same time without meeting one another, in place of an earlier crowd; "
        "the character itself stays as it is"
    )

    def steps(self, context):
        return crowd_walk_steps(context.scene)

    def apply(self, context, result):
        keep_crowd(context.scene, result)
        crowd = result.crowd
        if crowd.unserved:
            left_out = f"{len(crowd.unserved)} of {counted(result.n_wanted, 'walker')} got no walk"
            self.report({"WARNING"}, f"{left_out}. {crowd.unserved[0].reason}")
        character = context.scene.wayfarer.character
        if find_walk(context.scene) is not None and character.visible_get():
            walks_on = f"'{character.name}' plays a walk of its own, and keeps no distance from the crowd; hide it"
            self.report({"WARNING"}, walks_on)
        apart = f", at least {length(crowd.closest)} apart" if len(crowd.walks) > 1 else ""
        self.report({"INFO"}, f"{counted(len(crowd.walks), 'walker')}{apart}")
        self.warn_if_stale(context.scene)


class WAYFARER_OT_remove_crowd(Needs, bpy.types.Operator):
    bl_idname = "wayfarer.remove_crowd"
    bl_label = "Remove Crowd"
    bl_description = (
        "Remove the walkers of the crowd and their actions; those that were moved to other collections stay"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def problem(cls, context):
        # Whoever deleted the walkers by hand still sees what was said of them.
        is_there = find_copies(context.scene, CROWD_COLLECTION) or context.scene.wayfarer.walk.crowd.n_wanted
        return "" if is_there else "There is no crowd"

    def execute(self, context):
        self.report({"INFO"}, f"{counted(remove_crowd(context.scene), 'walker')} removed")
        return {"FINISHED"}


CLASSES = (WAYFARER_OT_random_walk, WAYFARER_OT_jump_to_frame, WAYFARER_OT_crowd, WAYFARER_OT_remove_crowd)
