"""The collections that Wayfarer puts its objects in."""

import bpy

OUTPUT = "Wayfarer"
"""What is made from results: the painted floor, the walk."""

CHARACTER = "Wayfarer Character"
ROOM = "Wayfarer Room"
OBSTACLES = "Wayfarer Obstacles"
REGIONS = "Wayfarer Regions"


def is_called(block, name: str) -> bool:
    """Whether a datablock has this name, numbered by Blender if another has it already: that of another scene, say."""
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
