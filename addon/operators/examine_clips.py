"""Look for what is wrong with the clips, before it spoils the motion graph."""

import bpy

from ...core.progress import Progress, portion
from ..bridge.text import counted
from ..examination import ClipHealth, clip_health, clip_motions
from ..jobs import LongOperator
from ..results.state import keep_health, keep_motion
from ..scene.inputs import doctor_settings, read_character_steps
from .needs_clips import NeedsClips


class WAYFARER_OT_examine_clips(NeedsClips, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.examine_clips"
    bl_label = "Examine Clips"
    bl_description = (
        "Look for T-poses, frozen or lost channels, pops, missing root motion and clips that are too short, in all "
        "clips that are ticked; nothing is changed"
    )

    def steps(self, context):
        scene = context.scene
        settings = doctor_settings(scene)
        read = yield from portion(read_character_steps(scene), 0.0, 0.3)
        found = {name: ClipHealth(problem=reason) for name, reason in read.problems}
        motions = {}
        for done, clip in enumerate(read.clips):
            yield Progress(0.3 + 0.7 * done / len(read.clips), f"Examining {clip.name}")
            motions.update(clip_motions([clip]))
            found[clip.name] = clip_health(clip, settings)
        return found, read.seen, motions

    def apply(self, context, result):
        found, seen, motions = result
        for name, health in found.items():
            keep_health(context.scene, name, seen[name], health)
        for name, motion in motions.items():
            keep_motion(context.scene, name, seen[name], motion)
        ill = [name for name, health in found.items() if not health.is_healthy]
        if ill:
            n_findings = sum(len(health.sentences) for health in found.values())
            self.report({"WARNING"}, f"{counted(n_findings, 'finding')} in {len(ill)} of {counted(len(found), 'clip')}")
        else:
            self.report({"INFO"}, f"Nothing is wrong with {counted(len(found), 'clip')}")
