"""Everything that Wayfarer puts into a scene, and the marks by which it is known again.

Readers leave out what is listed here; those who write it are in the rooms above.
"""

import bpy

OUTPUT = "Wayfarer"
"""Things made from results: the painted floor, the walk."""

CHARACTER = "Wayfarer Character"
ROOM = "Wayfarer Room"
OBSTACLES = "Wayfarer Obstacles"
REGIONS = "Wayfarer Regions"

COPY_PROPERTY = "wayfarer_copy"
"""Custom property of objects that are copies of the character: the name of the collection that they were made for."""

WALK_PROPERTY = "wayfarer_walk"
"""Custom property of actions and curves that Wayfarer made: a baked walk is no clip to build from."""

WALK_CURVE = "Wayfarer Walk"
"""Name of the curve along the last walk."""

FAN_PROPERTY = "wayfarer_walk_from"
"""Custom property of the curves of walks from one place: the number of the walk."""

GRID_PROPERTY = "wayfarer_grid"
"""Custom property of the painted floor: (nx, ny) cells. That of a sample's ground is a text: its grid as JSON."""


def is_called(block, name: str) -> bool:
    """Test for this name, numbered by Blender if another datablock has it already: that of another scene, say."""
    stem, _, number = block.name.rpartition(".")
    return block.name == name or (stem == name and len(number) >= 3 and number.isdigit())


def find_collection(scene, name: str) -> bpy.types.Collection | None:
    """The collection of this name in the scene; Blender numbers those of other scenes. One that is linked from another
    file is not ours to change, nor is an override of one: Blender lets nothing be put into it."""
    for collection in scene.collection.children_recursive:
        if collection.library is None and collection.override_library is None and is_called(collection, name):
            return collection
    return None


def ensure_collection(scene, name: str) -> bpy.types.Collection:
    """The collection of this name in the scene, made if there is none."""
    found = find_collection(scene, name)
    if found is not None:
        return found
    collection = bpy.data.collections.new(name)
    scene.collection.children.link(collection)
    return collection


def painted_ground(collection) -> bpy.types.Object | None:
    """Return the painted floor in a collection, whatever its name; None if there is none."""
    return next((found for found in collection.objects if found.type == "MESH" and painted_shape(found)), None)


def painted_shape(obj) -> tuple[int, ...]:
    """Return (nx, ny) cells of a painted floor; empty for any other object."""
    kept = obj.get(GRID_PROPERTY, ())
    return () if isinstance(kept, str) else tuple(kept)


def find_walk_curve(collection) -> bpy.types.Object | None:
    """Return the curve of the last walk; None if it is gone, or has another name: then it is the artist's.

    Blender numbers that of a second scene.
    """
    found = [obj for obj in collection.objects if obj.type == "CURVE" and is_called(obj, WALK_CURVE)]
    # Someone may have duplicated it.
    return min(found, key=lambda obj: obj.name != WALK_CURVE, default=None)


def walk_fan(collection) -> list[bpy.types.Object]:
    """Return the curves of walks from one place, whatever they are called now."""
    return [obj for obj in collection.objects if FAN_PROPERTY in obj and obj.type == "CURVE"]


def drawn_objects(scene) -> set[bpy.types.Object]:
    """Return the painted floor and the curves of walks, which change with what they show."""
    collection = find_collection(scene, OUTPUT)
    if collection is None:
        return set()
    return {painted_ground(collection), find_walk_curve(collection), *walk_fan(collection)} - {None}


def is_copy(obj) -> bool:
    """Return True for an object of a copy of the character; what was moved elsewhere is the artist's."""
    name = obj.get(COPY_PROPERTY)
    return isinstance(name, str) and any(is_called(collection, name) for collection in obj.users_collection)
