"""The collections that Wayfarer puts its objects in."""

import bpy

OUTPUT = "Wayfarer"
"""What is made from results: the painted floor, the walk."""

CHARACTER = "Wayfarer Character"
ROOM = "Wayfarer Room"
OBSTACLES = "Wayfarer Obstacles"
REGIONS = "Wayfarer Regions"


def ensure_collection(scene, name: str) -> bpy.types.Collection:
    """The collection of this name in the scene, made if there is none; Blender numbers those of other scenes."""
    for collection in scene.collection.children_recursive:
        if collection.name == name or (collection.name.startswith(f"{name}.") and collection.name[-3:].isdigit()):
            return collection
    collection = bpy.data.collections.new(name)
    scene.collection.children.link(collection)
    return collection
