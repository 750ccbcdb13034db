"""The state of the file before an import: what came since is known, and can be taken back."""

from collections.abc import Collection
from dataclasses import dataclass

import bpy

_SCENE = ("frame_start", "frame_end", "frame_current", "frame_preview_start", "frame_preview_end", "use_preview_range")
_NEVER_UNUSED = (
    bpy.types.Object,
    bpy.types.Action,
    bpy.types.Collection,
    bpy.types.Scene,
    bpy.types.WindowManager,
    bpy.types.WorkSpace,
    bpy.types.Screen,
)
_RATE = ("fps", "fps_base")


@dataclass(frozen=True)
class Before:
    """State before an import, by session ids: no reference to Blender's data is kept meanwhile.

    ``blocks`` are those of each collection of data in the file, ``active`` is the active object (0 for none),
    ``selected`` are the selected objects; ``scene`` and ``rate`` are frames and frame rate of the scene.
    """

    blocks: dict[str, frozenset[int]]
    active: int
    selected: frozenset[int]
    scene: dict[str, int | bool]
    rate: dict[str, float]


def what_is_there() -> Before:
    """Look at the file, for :func:`restore` to go back to."""
    objects, scene = bpy.context.view_layer.objects, bpy.context.scene
    return Before(
        blocks={name: frozenset(block.session_uid for block in blocks) for name, blocks in _collections().items()},
        active=objects.active.session_uid if objects.active else 0,
        selected=frozenset(obj.session_uid for obj in objects.selected),
        scene={name: getattr(scene, name) for name in _SCENE},
        rate={name: getattr(scene.render, name) for name in _RATE},
    )


def newcomers(before: Before, collection: str) -> list:
    """List what came into a collection of ``bpy.data`` since, in its order."""
    return [block for block in getattr(bpy.data, collection) if block.session_uid not in before.blocks[collection]]


def restore(before: Before) -> None:
    """Delete everything that has come since, and select what was selected."""
    remove_newcomers(before)
    restore_scene(before)


def restore_scene(before: Before) -> None:
    """Put frames, frame rate and selection back."""
    scene = bpy.context.scene
    for owner, values in ((scene.render, before.rate), (scene, before.scene)):
        for name, value in values.items():
            if getattr(owner, name) != value:
                setattr(owner, name, value)
    bpy.context.view_layer.update()
    objects = bpy.context.view_layer.objects
    for obj in objects:
        obj.select_set(obj.session_uid in before.selected)
    objects.active = next((obj for obj in objects if obj.session_uid == before.active), None)


def remove_newcomers(before: Before, kept: Collection[int] = ()) -> None:
    """Delete what has come since but the objects and actions of these session ids, and all that they use."""
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for name in ("objects", "actions"):
        bpy.data.batch_remove([block for block in newcomers(before, name) if block.session_uid not in kept])
    for collection in newcomers(before, "collections"):
        if not kept or not collection.all_objects:
            bpy.data.collections.remove(collection)
    # What used something may itself have been of use to nobody but what has gone.
    while unused := [
        block
        for name in before.blocks
        for block in newcomers(before, name)
        if not isinstance(block, _NEVER_UNUSED) and (not kept or block.users - block.use_fake_user == 0)
    ]:
        bpy.data.batch_remove(unused)


def _collections() -> dict[str, bpy.types.bpy_prop_collection]:
    """Every collection of data in the file, by its name in ``bpy.data``."""
    return {
        prop.identifier: getattr(bpy.data, prop.identifier)
        for prop in bpy.data.bl_rna.properties
        if prop.type == "COLLECTION"
    }
