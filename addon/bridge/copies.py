"""Copies of the character that walk: each kind in a collection of its own, made anew by every run."""

import bpy

from .duplicates import duplicate_character
from .owned import COPY_PROPERTY, WALK_PROPERTY, ensure_collection, find_collection
from .write_action import assign_action


def add_copy(scene, collection_name: str, action, name: str) -> bpy.types.Object:
    """A copy of the scene's character that plays ``action``; the copy of the armature."""
    collection = ensure_collection(scene, collection_name)
    known = {obj.session_uid for obj in collection.objects}
    copy = duplicate_character(scene.wayfarer.character, collection)
    for obj in collection.objects:
        if obj.session_uid not in known:
            obj[COPY_PROPERTY] = collection_name
    copy.name = name
    action[WALK_PROPERTY] = copy.name
    assign_action(copy, action)
    return copy


def find_copies(scene, collection_name: str) -> list[bpy.types.Object]:
    """All objects of the copies that are still where they were put; what was moved elsewhere is the artist's."""
    collection = find_collection(scene, collection_name)
    found = collection.objects if collection is not None else ()
    return [obj for obj in found if obj.get(COPY_PROPERTY) == collection_name]


def remove_copies(scene, collection_name: str) -> int:
    """Remove the copies and their actions; how many armatures there were.

    Actions that others play as well, or that have a fake user, stay.
    """
    copies = find_copies(scene, collection_name)
    armatures = [obj for obj in copies if obj.type == "ARMATURE"]
    played = [obj.animation_data.action for obj in armatures if obj.animation_data and obj.animation_data.action]
    own = [action for action in set(played) if WALK_PROPERTY in action and not action.use_fake_user]
    unwanted = [*copies, *(action for action in own if action.users <= played.count(action))]
    if unwanted:
        bpy.data.batch_remove(unwanted)
    return len(armatures)


def remove_if_empty(scene, collection_name: str) -> None:
    """Remove the collection of copies, if nothing is in it."""
    collection = find_collection(scene, collection_name)
    if collection is not None and not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)
