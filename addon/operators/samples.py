"""The sample character and the sample scenes."""

import bpy
from bpy.props import EnumProperty

from ...core.motion.repertoire import sample_repertoire
from ...core.progress import Progress
from ...core.wording import counted, time
from ..bridge.owned import CHARACTER, ensure_collection
from ..jobs import LongOperator
from ..sample.character import add_sample_character
from ..sample.layouts import LAYOUTS, layout_of
from ..sample.scene_file import SCENES, append_scene_file
from .mixins import NeedsObjectMode, reports_errors


class WAYFARER_OT_add_sample_character(NeedsObjectMode, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.add_sample_character"
    bl_label = "Add Sample Character"
    bl_description = "Add a character with walks, turns, starts, stops and steps over a low obstacle"

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


class WAYFARER_OT_add_sample_room(NeedsObjectMode, bpy.types.Operator):
    bl_idname = "wayfarer.add_sample_room"
    bl_label = "Add Sample Scene"
    bl_description = (
        "Add a scene with obstacles and use it as the environment; a sample scene that was added before is replaced"
    )
    bl_options = {"REGISTER", "UNDO"}

    sample: EnumProperty(
        items=[(layout.key, layout.label, layout.description) for layout in LAYOUTS],
        name="Scene",
        description="Which scene to add",
        default=LAYOUTS[0].key,
    )

    @reports_errors
    def execute(self, context):
        layout = layout_of(self.sample)
        append_scene_file(context.scene, SCENES / layout.file_name)
        self.report({"INFO"}, layout.description)


CLASSES = (WAYFARER_OT_add_sample_character, WAYFARER_OT_add_sample_room)
