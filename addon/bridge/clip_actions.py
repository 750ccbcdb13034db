"""The actions that are motions of a character."""

import bpy

from ...core.errors import ClipError
from .action_curves import action_curves
from .owned import WALK_PROPERTY
from .read_actions import FRAME_RATE_PROPERTY


def character_problem(scene) -> str:
    """Return why the scene's character cannot be used, as a sentence without its full stop; empty if it can."""
    character = scene.wayfarer.character
    if character is None:
        return "Choose a character first"
    if scene in character.users_scene:
        return ""
    if character.library is not None:
        return (
            f"'{character.name}' comes from another file and is not in this scene by itself; make a library override "
            "of its collection (Object > Library Override > Make) and choose the armature of that"
        )
    return f"'{character.name}' is no longer in this scene; choose another character or bring it back"


def bake_problem(character) -> str:
    """Say why nothing baked onto the character would be saved, as a sentence without its full stop; empty if it would.

    Blender lets the animation of linked data be changed, and has forgotten it when the file is opened again.
    """
    if character is None:
        return ""
    override = character.override_library
    if character.library is None and (override is None or not override.is_system_override):
        return ""
    return (
        f"'{character.name}' is linked from another file, and a walk baked onto it would not be saved; make a library "
        "override of it (Object > Library Override > Make), or bake into a Copy of Character"
    )


def character_actions(armature_object, of_others: bool = False) -> list[bpy.types.Action]:
    """The actions that move bones of the armature, in the order of their names; baked walks left out.

    Actions that were made for another armature of the file are left out too, if this one has actions of its own and
    not all are wanted: ``of_others``. An action was made for whom its slot is named after, unless it is played by
    others; one whose slot is named after nobody in the file belongs to everyone whose bones it moves.
    """
    found = []
    for action in bpy.data.actions:
        if WALK_PROPERTY in action:
            continue
        try:
            found.append((action, action_curves(armature_object, action).slot))
        except ClipError:
            continue
    # A copy of a character plays a copy of one action, but has none that is named after it: it may use them all.
    has_own = any(
        _namesake(slot) == armature_object or (_namesake(slot) is None and armature_object in slot.users())
        for _, slot in found
    )
    if of_others or not has_own:
        return [action for action, _ in found]
    return [action for action, slot in found if armature_object in _owners(slot) or not _owners(slot)]


def action_seconds(scene, action) -> float:
    """Return how long an action lasts (s), by its frame range and its own frame rate or the scene's."""
    first, last = action.frame_range
    rate = action.get(FRAME_RATE_PROPERTY, scene.render.fps / scene.render.fps_base)
    return (last - first) / rate if isinstance(rate, int | float) and rate > 0 else 0.0


def _owners(slot) -> list[bpy.types.Object]:
    """The armatures of the file that a slot was made for."""
    users = [user for user in slot.users() if _is_armature(user)]
    namesake = _namesake(slot)
    return users or ([namesake] if namesake is not None else [])


def _namesake(slot) -> bpy.types.Object | None:
    """The armature that a slot is named after."""
    named = bpy.data.objects.get(slot.name_display)
    return named if _is_armature(named) else None


def _is_armature(datablock) -> bool:
    return isinstance(datablock, bpy.types.Object) and datablock.type == "ARMATURE"
