"""The list of clips, what is wrong with them, and when their feet are on the ground."""

import contextlib
from dataclasses import astuple

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty
from mathutils import Matrix, Quaternion, Vector

from ...core.errors import ClipError
from ...core.motion.body_size import person_height
from ...core.motion.contacts import foot_contacts
from ...core.motion.doctor import ClipHealth, FindingKind, Remedy, RemedyKind, clip_health, clip_motions
from ...core.motion.in_place import with_root_motion
from ...core.progress import Progress, portion
from ...core.report.contact_chart import ClipContacts, contact_chart
from ...core.report.page import Figure, Section
from ...core.report.table import Table, table
from ...core.wording import counted
from ..bridge.action_curves import action_curves
from ..bridge.read_actions import read_clip
from ..bridge.rig import FORWARD_PROPERTY, ROOT_PROPERTY, bind_rig, placement_obstacle
from ..bridge.write_action import write_clip
from ..exports.report import open_page
from ..jobs import LongOperator
from ..results.clips import health_of, keep_contacts, keep_health, keep_motion
from ..scene.inputs import doctor_settings, read_character_steps
from ..scene.motion_fingerprint import action_fingerprint
from .mixins import NeedsCharacter, NeedsClips, NeedsRig, reports_errors


class WAYFARER_OT_refresh_clips(NeedsRig, bpy.types.Operator):
    bl_idname = "wayfarer.refresh_clips"
    bl_label = "Refresh Clips"
    bl_description = "Find all actions that animate the character"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        settings = context.scene.wayfarer
        new = settings.refresh_clips()
        if len(settings.clips) == 0:
            self.report({"WARNING"}, f"No action animates '{settings.character.name}'")
        else:
            self.report({"INFO"}, f"{counted(len(settings.clips), 'clip')}, {new} new")
        return {"FINISHED"}


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
        remedy = _remedy(context.scene, properties.action, properties.finding)
        return _DESCRIPTIONS[remedy.kind] if remedy else cls.bl_description

    @reports_errors
    def execute(self, context):
        scene = context.scene
        remedy = _remedy(scene, self.action, self.finding)
        action = bpy.data.actions.get(self.action)
        health = health_of(scene, action) if action is not None else None
        if remedy is not None and remedy.kind is RemedyKind.BY_HAND:
            raise ClipError(f"To {remedy.kind.value} is all that helps.")
        if remedy is None or health is None:
            raise ClipError(f"The action '{self.action}' has changed since it was examined; examine it again.")
        if remedy.kind.is_for_character:
            examined = [clip.action for clip in scene.wayfarer.clips if clip.action and health_of(scene, clip.action)]
            done = _treat_character(scene, remedy)
            for other in examined:
                _examine(scene, other)
        else:
            done = _TREATMENTS[remedy.kind](scene, action, health, remedy)
            _examine(scene, action)
        self.report({"INFO"}, done)


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
        _treat_character(scene, Remedy(RemedyKind.SCALE, values=(self.height / height,)))


def _remedy(scene, action_name: str, finding: int) -> Remedy | None:
    """Return what is proposed about a finding, if it still stands."""
    listed = (clip.action for clip in scene.wayfarer.clips if clip.action is not None)
    action = next((action for action in listed if action.name == action_name), None)
    health = health_of(scene, action) if action else None
    return health.findings[finding].remedy if health and finding < len(health.findings) else None


def _trim(scene, action, health: ClipHealth, remedy: Remedy) -> str:
    first, last = health.frame_range(remedy.kept[0])
    _set_range(action, first, last)
    return f"'{action.name}' now lasts from frame {first:g} to frame {last:g}"


def _drop(scene, action, health: ClipHealth, remedy: Remedy) -> str:
    scene.wayfarer.replace_clip(action, ())
    return f"'{action.name}' is no longer in use"


def _split(scene, action, health: ClipHealth, remedy: Remedy) -> str:
    # Copies with other frame ranges: baking would lose the curves between whole frames, and whatever else is keyed.
    parts = []
    for number, kept in enumerate(remedy.kept, start=1):
        part = action.copy()
        part.name = f"{action.name} (part {number})"
        part.use_fake_user = True
        _set_range(part, *health.frame_range(kept))
        parts.append(part)
    scene.wayfarer.replace_clip(action, parts)
    for part in parts:
        _examine(scene, part)
    return f"{len(parts)} parts of '{action.name}' take its place"


def _add_root_motion(scene, action, health: ClipHealth, remedy: Remedy) -> str:
    character = scene.wayfarer.character
    clip = with_root_motion(read_clip(character, action), feet=doctor_settings(scene).feet)
    moving = write_clip(character, clip, f"{action.name} (root motion)", round(clip.first_frame))
    moving.use_fake_user = True
    scene.wayfarer.replace_clip(action, [moving])
    _examine(scene, moving)
    return f"'{moving.name}' travels over the ground and takes the place of '{action.name}'"


def _treat_character(scene, remedy: Remedy) -> str:
    done = _change_character(scene, remedy)
    scene.wayfarer.body.look()
    return done


def _change_character(scene, remedy: Remedy) -> str:
    character = scene.wayfarer.character
    if remedy.kind is RemedyKind.ROOT:
        character[ROOT_PROPERTY] = remedy.bone
        return f"'{remedy.bone}' is the root of '{character.name}' now"
    if remedy.kind is RemedyKind.FACE:
        character[FORWARD_PROPERTY] = tuple(character.matrix_world.to_3x3().inverted() @ Vector(remedy.values))
        return f"'{character.name}' faces the way that its body does"
    reason = placement_obstacle(character) or _keys_object(scene)
    if reason:
        raise ClipError(f"'{character.name}' cannot be moved: {reason}. Remove that, or correct the source.")
    if remedy.kind is RemedyKind.LIFT:
        change, done = Matrix.Translation((0.0, 0.0, remedy.values[0])), "stands on the floor"
    elif remedy.kind is RemedyKind.SCALE:
        change, done = Matrix.Scale(remedy.values[0], 4), f"is scaled by {remedy.values[0]:.3g}"
    else:
        change, done = Quaternion(remedy.values).to_matrix().to_4x4(), "stands upright"
    character.matrix_world = change @ character.matrix_world
    bpy.context.view_layer.update()
    return f"'{character.name}' {done}"


def _keys_object(scene) -> str:
    character = scene.wayfarer.character
    for action in scene.wayfarer.used_actions():
        with contextlib.suppress(ClipError):
            if action_curves(character, action).placement:
                return f"'{action.name}' has keys of the object itself"
    return ""


def _set_range(action, first: float, last: float) -> None:
    action.use_frame_range = True
    action.frame_start, action.frame_end = first, last


def doubts_in_words(scene, actions) -> list[str]:
    """Examine imported actions and put what they show about the character in sentences, one for each kind.

    What was found stays in the panel, each with its remedy. ClipError if an action cannot be read.
    """
    found: dict[FindingKind, list[str]] = {}
    for action in actions:
        _examine(scene, action)
        health = health_of(scene, action)
        for finding in health.findings if health else ():
            if finding.remedy.kind.is_for_character:
                found.setdefault(finding.kind, []).append(finding.sentence)
    others = {kind: counted(len(sentences) - 1, "other clip") for kind, sentences in found.items()}
    return [
        sentences[0] + (f" The same goes for {others[kind]}." if len(sentences) > 1 else "")
        for kind, sentences in found.items()
    ]


def _examine(scene, action) -> None:
    """Examine anew what the remedy has changed, so that the next one counts from there."""
    health = clip_health(read_clip(scene.wayfarer.character, action), doctor_settings(scene))
    keep_health(scene, action.name, action_fingerprint(scene, action), health)


_TREATMENTS = {
    RemedyKind.TRIM: _trim,
    RemedyKind.SPLIT: _split,
    RemedyKind.DROP: _drop,
    RemedyKind.ROOT_MOTION: _add_root_motion,
}
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


class WAYFARER_OT_show_contacts(NeedsClips, LongOperator, bpy.types.Operator):
    bl_idname = "wayfarer.show_contacts"
    bl_label = "Show Contacts"
    bl_description = (
        "Draw when the left foot (blue) and the right foot (orange) of each ticked clip are planted, on a page in the "
        "browser"
    )

    def steps(self, context):
        scene = context.scene
        settings = scene.wayfarer.contacts.to_core(scene.wayfarer.character)
        read = yield from portion(read_character_steps(scene), 0.0, 0.5)
        found = []
        for done, clip in enumerate(read.clips):
            yield Progress(0.5 + 0.5 * done / len(read.clips), f"Watching the feet of {clip.name}")
            found.append(ClipContacts(clip.name, clip.frame_rate, foot_contacts(clip, settings)))
        return found, read.seen

    def apply(self, context, result):
        found, seen = result
        for clip in found:
            keep_contacts(context.scene, clip.name, seen[clip.name], clip.shares)
        section = Section("When the left foot (blue) and the right foot (orange) are planted", _blocks(found))
        page = open_page("Contacts", context.scene.name, [section])
        self.report({"INFO"}, f"Contacts of {counted(len(found), 'clip')} are on the page '{page}'")


def _blocks(found: list[ClipContacts]) -> tuple[Figure, Table]:
    columns = ("clip", "share left planted", "share right planted", "share both", "share none")
    return Figure(contact_chart(found)), table(columns, [(clip.name, *astuple(clip.shares)) for clip in found])


CLASSES = (
    WAYFARER_OT_refresh_clips,
    WAYFARER_OT_choose_clip,
    WAYFARER_OT_examine_clips,
    WAYFARER_OT_apply_remedy,
    WAYFARER_OT_set_height,
    WAYFARER_OT_show_contacts,
)
