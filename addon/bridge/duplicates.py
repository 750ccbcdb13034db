"""Copies of a character that share its data: one for each walker of a crowd."""

from collections.abc import Mapping

import bpy


def duplicate_character(armature_object, collection) -> bpy.types.Object:
    """A copy of an armature object with all that belongs to it, linked to ``collection``; the copy of the armature.

    What belongs to it are its children, theirs, and whatever its armature deforms. The copies share armature, meshes
    and materials with the originals. Parents, modifiers, constraints (of objects and bones, with their targets) and
    drivers of the copies point at the copies. Drivers that sit in shared data, of shape keys for instance, cannot: they
    go on following the original. The copy of the armature has the pose and the properties of the original, but no
    action and no NLA tracks.
    """
    family = [armature_object, *armature_object.children_recursive]
    family += [obj for obj in bpy.data.objects if obj not in family and is_deformed_by(obj, armature_object)]
    copies = {}
    for original in family:
        copies[original] = original.copy()
        collection.objects.link(copies[original])
    tie_copies(copies)
    duplicate = copies[armature_object]
    silence(duplicate.animation_data)
    return duplicate


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
    """Whether an armature object deforms this one, which need not be its child."""
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
