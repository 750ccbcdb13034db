"""Copies of the character that walk: they share its data and are made anew, in a collection of their own."""

from collections.abc import Mapping

import bpy

from .owned import COPY_PROPERTY, WALK_PROPERTY, ensure_collection, find_collection
from .write_action import assign_action, keyed_channels, put_to_rest


def add_copy(scene, collection_name: str, action, name: str, walked: set[tuple[str, str]]) -> bpy.types.Object:
    """A copy of the scene's character that plays ``action``; the copy of the armature.

    What the action does not key, of the channels ``walked`` (:func:`.write_action.walk_channels`), starts from rest.
    """
    collection = ensure_collection(scene, collection_name)
    known = {obj.session_uid for obj in collection.objects}
    copy = duplicate_character(scene.wayfarer.character, collection)
    for obj in collection.objects:
        if obj.session_uid not in known:
            obj[COPY_PROPERTY] = collection_name
    copy.name = name
    action[WALK_PROPERTY] = copy.name
    assign_action(copy, action)
    put_to_rest(copy, walked - keyed_channels(copy, [action]))
    return copy


def find_copies(scene, collection_name: str) -> list[bpy.types.Object]:
    """All objects of the copies that are still where they were put.

    What was moved elsewhere is the artist's, and so is a copy that was chosen as the character.
    """
    collection = find_collection(scene, collection_name)
    found = collection.objects if collection is not None else ()
    kept = set(_family(scene.wayfarer.character)) if scene.wayfarer.character is not None else set()
    return [obj for obj in found if obj.get(COPY_PROPERTY) == collection_name and obj not in kept]


def remove_copies(scene, collection_name: str) -> int:
    """Remove the copies and their actions; how many armatures there were.

    Actions that others play as well, or that have a fake user, stay, and so do the artist's own.
    """
    copies = find_copies(scene, collection_name)
    armatures = [obj for obj in copies if obj.type == "ARMATURE"]
    played = [obj.animation_data.action for obj in armatures if obj.animation_data and obj.animation_data.action]
    own = [action for action in set(played) if WALK_PROPERTY in action and not action.use_fake_user]
    unwanted = [*copies, *(action for action in own if action.users <= played.count(action))]
    for action in {*played} - {*own}:
        # What the artist let a copy play has no other user, perhaps, and would be lost on saving.
        action.use_fake_user = action.use_fake_user or action.users <= played.count(action)
    if unwanted:
        bpy.data.batch_remove(unwanted)
    return len(armatures)


def remove_if_empty(scene, collection_name: str) -> None:
    """Remove the collection of copies, if nothing is in it."""
    collection = find_collection(scene, collection_name)
    if collection is not None and not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)


def duplicate_character(armature_object, collection) -> bpy.types.Object:
    """A copy of an armature object with all that belongs to it, linked to ``collection``; the copy of the armature.

    What belongs to it are its children, theirs, and whatever its armature deforms. The copies share armature, meshes
    and materials with the originals. Parents, modifiers, constraints (of objects and bones, with their targets) and
    drivers of the copies point at the copies. Drivers that sit in shared data, of shape keys for instance, cannot: they
    go on following the original. The copy of the armature has the pose and the properties of the original, but no
    action and no NLA tracks.
    """
    copies = {}
    for original in _family(armature_object):
        copies[original] = original.copy()
        collection.objects.link(copies[original])
    tie_copies(copies)
    duplicate = copies[armature_object]
    silence(duplicate.animation_data)
    return duplicate


def _family(armature_object) -> list[bpy.types.Object]:
    """List an armature object and all that belongs to it."""
    family = [armature_object, *armature_object.children_recursive]
    return family + [obj for obj in bpy.data.objects if obj not in family and is_deformed_by(obj, armature_object)]


def tie_copies(copies: Mapping) -> None:
    """Let copies of objects, {original: copy}, hang together as the originals do: parents, modifiers, constraints and
    drivers that point at an original point at its copy."""
    for original, copy in copies.items():
        if original.parent in copies:
            # Setting a parent would forget where the child was bound to it.
            inverse = copy.matrix_parent_inverse.copy()
            copy.parent = copies[original.parent]
            copy.matrix_parent_inverse = inverse
        _point_at_copies(copy, copies)


def silence(animation) -> None:
    """Let nothing be played: no action and no NLA tracks; drivers stay."""
    if animation is not None:
        animation.action = None
        for track in list(animation.nla_tracks):
            animation.nla_tracks.remove(track)


def is_deformed_by(obj, armature_object) -> bool:
    """Return True if an armature object deforms this one, which need not be its child."""
    return any(modifier.type == "ARMATURE" and modifier.object == armature_object for modifier in obj.modifiers)


def _point_at_copies(copy, copies: Mapping) -> None:
    constraints = list(copy.constraints)
    if copy.pose is not None:
        constraints += [constraint for bone in copy.pose.bones for constraint in bone.constraints]
    for owner in (*copy.modifiers, *constraints):
        _swap_objects(owner, copies)
        for target in getattr(owner, "targets", ()):  # an Armature constraint has several
            _swap_objects(target, copies)
    for driver in copy.animation_data.drivers if copy.animation_data else ():
        for variable in driver.driver.variables:
            for target in variable.targets:
                if target.id in copies:
                    target.id = copies[target.id]


def _swap_objects(owner, copies: Mapping) -> None:
    """Replace every object that a modifier, a constraint or a target of one refers to by its copy, if it has one."""
    for prop in owner.bl_rna.properties:
        if prop.type == "POINTER" and prop.fixed_type.identifier == "Object" and not prop.is_readonly:
            original = getattr(owner, prop.identifier)
            if original in copies:
                setattr(owner, prop.identifier, copies[original])
