"""Examination of clips and their character, and what is done about the findings."""

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty

from ...core.errors import ClipError
from ...core.motion.body_size import person_height
from ...core.motion.doctor import ClipHealth, Remedy, RemedyKind, clip_health, clip_motions
from ...core.progress import Progress, portion
from ...core.wording import counted
from ..bridge.rig import bind_rig
from ..jobs import LongOperator
from ..results.clips import health_of, keep_health, keep_motion
from ..scene.inputs import doctor_settings, read_character_steps
from .mixins import NeedsCharacter, NeedsClips, NeedsRig, reports_errors
from .remedies import apply_to_action, apply_to_character, fix_all, proposed_remedy, treat_character

_DESCRIPTIONS = {
    RemedyKind.TRIM: "Give the action a manual frame range that leaves these frames out; its keys stay as they are",
    RemedyKind.SPLIT: "Add a copy of the action for each part, with a manual frame range, and untick the action",
    RemedyKind.DROP: "Untick the action; it stays in the file",
    RemedyKind.ROOT_MOTION: "Bake a copy of the action that travels over the ground as its standing feet say, and "
    "untick the action",
    RemedyKind.STAND: "Turn the character's object, so that the motion stands upright; its keys stay as they are",
    RemedyKind.SCALE: "Scale the character's object; its keys stay as they are",
    RemedyKind.LIFT: "Move the character's object up or down, so that the feet stand on the floor",
    RemedyKind.FACE: "Give the character's object the property wayfarer_forward: all its clips face another way",
    RemedyKind.BY_HAND: "Only a hand can mend this",
    RemedyKind.ROOT: "Give the character's object the property wayfarer_root, the bone that carries the body",
}


class WAYFARER_OT_choose_clip(bpy.types.Operator):
    bl_idname = "wayfarer.choose_clip"
    bl_label = "Show Findings"
    bl_description = "Choose this clip and show what was found in it"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    clip: IntProperty(name="Clip", description="Place in the list", min=0, options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        clips = context.scene.wayfarer.clips
        action = clips[properties.clip].action if properties.clip < len(clips) else None
        health = health_of(context.scene, action) if action else None
        if health is None:
            return cls.bl_description
        return "\n".join(health.sentences).removesuffix(".") or "Nothing is wrong with this clip"

    def execute(self, context):
        settings = context.scene.wayfarer
        if self.clip >= len(settings.clips):
            return {"CANCELLED"}
        settings.active_clip = self.clip
        return {"FINISHED"}


class WAYFARER_OT_examine_clips(NeedsClips, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.examine_clips"
    bl_label = "Examine Clips"
    bl_description = (
        "Look for T-poses, frozen or lost channels, pops, missing root motion, clips that are too short, and "
        "characters that lie, face elsewhere than they go or are no person's size, in all clips that are ticked; "
        "nothing is changed"
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


class WAYFARER_OT_apply_remedy(NeedsCharacter, bpy.types.Operator):
    bl_idname = "wayfarer.apply_remedy"
    bl_label = "Apply Remedy"
    bl_description = "Do what is proposed; the keys of the action stay as they are"
    bl_options = {"REGISTER", "UNDO"}

    action: StringProperty(name="Action", description="Name of the action", options={"SKIP_SAVE"})
    finding: IntProperty(
        name="Finding", description="Which of its findings, counted from zero", min=0, options={"SKIP_SAVE"}
    )

    @classmethod
    def description(cls, context, properties):
        remedy = proposed_remedy(context.scene, properties.action, properties.finding)
        return _DESCRIPTIONS[remedy.kind] if remedy else cls.bl_description

    @reports_errors
    def execute(self, context):
        scene = context.scene
        remedy = proposed_remedy(scene, self.action, self.finding)
        action = bpy.data.actions.get(self.action)
        health = health_of(scene, action) if action is not None else None
        if remedy is not None and remedy.kind is RemedyKind.BY_HAND:
            raise ClipError(f"To {remedy.kind.value} is all that helps.")
        if remedy is None or health is None:
            raise ClipError(f"The action '{self.action}' has changed since it was examined; examine it again.")
        if remedy.kind.is_for_character:
            done = apply_to_character(scene, remedy)
        else:
            done = apply_to_action(scene, action, health, remedy)
        self.report({"INFO"}, done)


class WAYFARER_OT_fix_all(NeedsCharacter, bpy.types.Operator):
    bl_idname = "wayfarer.fix_all"
    bl_label = "Fix All"
    bl_description = (
        "Do what is proposed about every finding in the ticked clips, first about the character; the keys of the "
        "actions stay as they are"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def problem(cls, context):
        scene = context.scene
        known = [health_of(scene, action) for action in scene.wayfarer.used_actions()]
        if not any(known):
            return super().problem(context) or "Examine the clips first"
        remedies = (finding.remedy for health in known if health for finding in health.findings)
        return "" if any(remedy.kind is not RemedyKind.BY_HAND for remedy in remedies) else "Nothing has a remedy here"

    @reports_errors
    def execute(self, context):
        fixed = fix_all(context.scene)
        for sentence in fixed.left:
            self.report({"WARNING"}, sentence)
        self.report({"INFO"}, fixed.in_words())


class WAYFARER_OT_set_height(NeedsRig, bpy.types.Operator):
    bl_idname = "wayfarer.set_height"
    bl_label = "Set Height"
    bl_description = "Scale the character's object until it is this tall by its legs; its keys stay as they are"
    bl_options = {"REGISTER", "UNDO"}

    height: FloatProperty(
        name="Height",
        description="How tall a person with such legs is to be",
        subtype="DISTANCE",
        min=0.01,
        default=1.75,
        options={"SKIP_SAVE"},
    )

    def invoke(self, context, event):
        self.height = context.scene.wayfarer.body.height or self.height
        return context.window_manager.invoke_props_dialog(self)

    @reports_errors
    def execute(self, context):
        scene = context.scene
        height = person_height(bind_rig(scene.wayfarer.character).skeleton)
        treat_character(scene, Remedy(RemedyKind.SCALE, values=(self.height / height,)))


CLASSES = (
    WAYFARER_OT_choose_clip,
    WAYFARER_OT_examine_clips,
    WAYFARER_OT_apply_remedy,
    WAYFARER_OT_fix_all,
    WAYFARER_OT_set_height,
)
