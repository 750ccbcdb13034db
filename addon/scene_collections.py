"""The collections that Wayfarer puts its objects in."""

import bpy

OUTPUT = "Wayfarer"
"""What is made from results: the painted floor, the walk."""

CHARACTER = "Wayfarer Character"
ROOM = "Wayfarer Room"
OBSTACLES = "Wayfarer Obstacles"
REGIONS = "Wayfarer Regions"


def find_collection(scene, name: str) -> bpy.types.Collection | None:
    """The collection of this name in the scene; Blender numbers those of other scenes. One that is linked from another
    file is not ours to change."""
    for collection in scene.collection.children_recursive:
        if collection.library is not None:
            continue
        if collection.name == name or (collection.name.startswith(f"{name}.") and collection.name[-3:].isdigit()):
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
