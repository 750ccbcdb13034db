"""Do about a finding what the clip doctor proposes; the keys of the action stay as they are."""

import bpy
from bpy.props import IntProperty, StringProperty

from ...core.errors import ClipError, MotionGraphError
from ...core.motion.doctor import Remedy, RemedyKind
from ...core.motion.in_place import with_root_motion
from ..bridge.read_actions import read_clip
from ..bridge.write_action import write_clip
from ..examination import ClipHealth, clip_health
from ..results.state import health_of, keep_health
from ..scene.inputs import doctor_settings
from ..scene.motion_fingerprint import action_fingerprint
from .needs_character import NeedsCharacter


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

    def execute(self, context):
        scene = context.scene
        try:
            remedy = _remedy(scene, self.action, self.finding)
            action = bpy.data.actions.get(self.action)
            health = health_of(scene, action) if action is not None else None
            if remedy is None or health is None:
                raise ClipError(f"The action '{self.action}' has changed since it was examined; examine it again.")
            done = _TREATMENTS[remedy.kind](scene, action, health, remedy)
            _examine(scene, action)
        except MotionGraphError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, done)
        return {"FINISHED"}


def _remedy(scene, action_name: str, finding: int) -> Remedy | None:
    """What is proposed about a finding, if it still stands."""
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


def _set_range(action, first: float, last: float) -> None:
    action.use_frame_range = True
    action.frame_start, action.frame_end = first, last


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
}
