"""Remedies of the clip doctor, done to actions and their character."""

import contextlib
from collections import Counter
from dataclasses import dataclass, field

import bpy
from mathutils import Matrix, Quaternion, Vector

from ...core.errors import ClipError
from ...core.motion.doctor import ClipHealth, Finding, FindingKind, Remedy, RemedyKind, clip_health
from ...core.motion.in_place import with_root_motion
from ...core.wording import counted
from ..bridge.action_curves import action_curves
from ..bridge.read_actions import read_clip
from ..bridge.rig import FORWARD_PROPERTY, ROOT_PROPERTY, placement_obstacle
from ..bridge.write_action import write_clip
from ..results.clips import health_of, keep_health
from ..scene.inputs import doctor_settings
from ..scene.motion_fingerprint import action_fingerprint


def proposed_remedy(scene, action_name: str, finding: int) -> Remedy | None:
    """Return what is proposed about a finding, if it still stands."""
    listed = (clip.action for clip in scene.wayfarer.clips if clip.action is not None)
    action = next((action for action in listed if action.name == action_name), None)
    health = health_of(scene, action) if action else None
    return health.findings[finding].remedy if health and finding < len(health.findings) else None


def apply_to_action(scene, action, health: ClipHealth, remedy: Remedy) -> str:
    """Do what is proposed about an action of this health, and examine it anew; say what was done."""
    done = _TREATMENTS[remedy.kind](scene, action, health, remedy)
    _examine(scene, action)
    return done


def apply_to_character(scene, remedy: Remedy) -> str:
    """Do what is proposed about the character, and examine all clips anew that were; say what was done."""
    examined = [clip.action for clip in scene.wayfarer.clips if clip.action and health_of(scene, clip.action)]
    before = _Placed.of(scene.wayfarer.character)
    try:
        done = treat_character(scene, remedy)
        for action in examined:
            _examine(scene, action)
    except ClipError:
        before.put_back(scene, examined)
        raise
    return done


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


def treat_character(scene, remedy: Remedy) -> str:
    """Do what is proposed about the character; say what was done."""
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


@dataclass
class Fixed:
    """All that was done at once: about the character, and to how many clips by each kind of remedy; what is left."""

    of_character: list[str] = field(default_factory=list)
    of_clips: Counter = field(default_factory=Counter)
    left: list[str] = field(default_factory=list)

    def in_words(self) -> str:
        """Say what was done: "'Hero' stands upright; 2 clips trimmed, 1 clip dropped"."""
        clips = [
            f"{counted(self.of_clips[kind], 'clip')} {done}" for kind, done in _DONE.items() if self.of_clips[kind]
        ]
        return "; ".join([*self.of_character, *([", ".join(clips)] if clips else [])]) or "Nothing was changed"


_DONE = {
    RemedyKind.DROP: "dropped",
    RemedyKind.TRIM: "trimmed",
    RemedyKind.SPLIT: "split",
    RemedyKind.ROOT_MOTION: "given root motion",
}
"""In the order in which a clip's remedies are applied: what is too short needs no others, and what is lost is cut out
before root motion is made of the rest."""


def fix_all(scene) -> Fixed:
    """Apply the remedies of all findings in the ticked clips that were examined, and of those that then appear."""
    fixed = Fixed()
    actions = [action for action in scene.wayfarer.used_actions() if health_of(scene, action) is not None]
    _fix_character(scene, actions, fixed)
    waiting, travelling = list(actions), set()
    while waiting:
        action = waiting.pop(0)
        health = health_of(scene, action)
        remedy = _next_remedy(health, made_to_travel=action in travelling) if health else None
        if health is None or remedy is None:
            continue
        listed = {clip.action for clip in scene.wayfarer.clips}
        try:
            apply_to_action(scene, action, health, remedy)
        except ClipError as error:
            fixed.left.append(str(error))
            continue
        fixed.of_clips[remedy.kind] += 1
        made = [clip.action for clip in scene.wayfarer.clips if clip.action not in listed]
        if remedy.kind is RemedyKind.ROOT_MOTION:
            travelling.update(made)
        waiting[:0] = [action] if remedy.kind is RemedyKind.TRIM else made
    by_hand = [found for found in _of_character(scene, actions) if found.remedy.kind is RemedyKind.BY_HAND]
    fixed.left += [f"{by_hand[0].sentence} This is left for a hand."] if by_hand else []
    return fixed


def _next_remedy(health: ClipHealth, made_to_travel: bool) -> Remedy | None:
    """Return the remedy to apply next to a clip; one that was made to travel is not made so again."""
    remedies = {finding.remedy.kind: finding.remedy for finding in reversed(health.findings)}
    if made_to_travel:
        remedies.pop(RemedyKind.ROOT_MOTION, None)
    return next((remedies[kind] for kind in _DONE if kind in remedies), None)


def _fix_character(scene, actions, fixed: Fixed) -> None:
    """Apply each kind of remedy of the character that helps more clips than it spoils."""
    tried = {RemedyKind.BY_HAND}
    while True:
        found = _of_character(scene, actions)
        proposed = next((finding for finding in found if finding.remedy.kind not in tried), None)
        if proposed is None:
            return
        tried.add(proposed.remedy.kind)
        before = _Placed.of(scene.wayfarer.character)
        try:
            done = apply_to_character(scene, proposed.remedy)
        except ClipError as error:
            fixed.left.append(str(error))
            continue
        if len(_of_character(scene, actions)) < len(found):
            fixed.of_character.append(done)
            continue
        before.put_back(scene, actions)
        fixed.left.append(f"{proposed.sentence} That would spoil other clips, and is left.")


def _of_character(scene, actions) -> list[Finding]:
    known = [health_of(scene, action) for action in actions]
    found = [finding for health in known if health for finding in health.findings]
    return [finding for finding in found if finding.remedy.kind.is_for_character]


@dataclass(frozen=True)
class _Placed:
    """All that remedies of a character change."""

    matrix: Matrix
    properties: dict

    @classmethod
    def of(cls, character) -> "_Placed":
        kept = {name: character[name] for name in (ROOT_PROPERTY, FORWARD_PROPERTY) if name in character}
        plain = {name: value if isinstance(value, str) else tuple(value) for name, value in kept.items()}
        return cls(character.matrix_world.copy(), plain)

    def put_back(self, scene, examined) -> None:
        """Take a remedy back, and examine the actions anew."""
        character = scene.wayfarer.character
        character.matrix_world = self.matrix
        for name in (ROOT_PROPERTY, FORWARD_PROPERTY):
            if name in self.properties:
                character[name] = self.properties[name]
            elif name in character:
                del character[name]
        bpy.context.view_layer.update()
        scene.wayfarer.body.look()
        for action in examined:
            _examine(scene, action)
