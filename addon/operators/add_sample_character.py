"""Add a character with everything that it can do."""

import bpy

from ...core.motion.repertoire import sample_repertoire
from ...core.progress import Progress
from ..bridge.owned import CHARACTER, ensure_collection
from ..bridge.text import counted, time
from ..jobs import LongOperator
from ..sample.character import add_sample_character


class WAYFARER_OT_add_sample_character(LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.add_sample_character"
    bl_label = "Add Sample Character"
    bl_description = "Add a character with walks, turns, starts, stops and steps over a low obstacle"

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Switch to Object Mode first")
            return False
        return True

    def steps(self, context):
        render = context.scene.render
        yield Progress(0.0, "Rehearsing the repertoire")
        clips = sample_repertoire(render.fps / render.fps_base)
        yield Progress(0.7, "Writing actions")
        return clips

    def apply(self, context, clips):
        settings = context.scene.wayfarer
        collection = ensure_collection(context.scene, CHARACTER)
        settings.character, actions = add_sample_character(clips, collection)
        settings.refresh_clips()
        tagged = sum(bool(clip.tags) for clip in clips)
        seconds = sum(clip.duration for clip in clips)
        self.report({"INFO"}, f"{counted(len(actions), 'clip')}, {time(seconds)} of motion, {tagged} of them tagged")
