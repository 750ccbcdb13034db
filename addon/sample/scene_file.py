"""Sample scenes as .blend files: written by make_scenes.py, appended by the add-on."""

from pathlib import Path
from typing import Any, cast

import bpy

from ...core.errors import SceneError
from ..bridge.libraries import forget_file
from ..bridge.materials import remove_unused_materials
from ..bridge.owned import OBSTACLES, REGIONS, ROOM, ensure_collection
from .layouts import SceneLayout
from .scene_objects import MATERIALS, SAMPLE_PROPERTY, add_scene_objects, configure

SCENES = Path(__file__).resolve().parents[2] / "assets" / "scenes"
_COLLECTIONS = (ROOM, OBSTACLES, REGIONS)


def write_scene_file(folder: Path, layout: SceneLayout) -> Path:
    """Save a scene as a .blend file of its own; the file that is open is lost."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.name = layout.label
    collections = [ensure_collection(scene, name) for name in _COLLECTIONS]
    add_scene_objects(layout, *collections)
    configure(scene.wayfarer.environment, *collections)
    path = folder / layout.file_name
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)
    return path


def append_scene_file(scene, path: Path) -> None:
    """Bring a sample scene into this one and use it as the environment; a sample scene that was there is removed.

    Raises
    ------
    SceneError
        The file cannot be read, or holds no sample scene.
    """
    # Looked at before anything is removed, and removed before anything comes, so that names are free.
    try:
        library: Any = bpy.data.libraries.load(str(path), link=False)  # the stubs have it return nothing
        with library as (there, _):
            is_sample = all(name in there.collections for name in _COLLECTIONS)
    except OSError as error:
        raise SceneError(f"'{path.name}' cannot be read; install the extension anew.") from error
    if not is_sample:
        raise SceneError(f"'{path.name}' holds no sample scene; install the extension anew.")
    collections = [ensure_collection(scene, name) for name in _COLLECTIONS]
    for collection in collections:
        _remove_sample(collection)
    library = bpy.data.libraries.load(str(path), link=False)
    with library as (_, here):
        here.collections = list(_COLLECTIONS)
    # Now Blender has put them in the place of their names.
    appended = cast(list[bpy.types.Collection], here.collections)
    for loaded, collection in zip(appended, collections, strict=True):
        for obj in list(loaded.objects):
            collection.objects.link(obj)
            _share_materials(obj)
        bpy.data.collections.remove(loaded)
    forget_file(path)
    # The scene that was there before may have had some that this one has no use for.
    remove_unused_materials(MATERIALS)
    configure(scene.wayfarer.environment, *collections)


def _remove_sample(collection) -> None:
    """Remove the objects of a sample scene from a collection; what the artist put there stays."""
    for obj in [obj for obj in collection.objects if SAMPLE_PROPERTY in obj]:
        mesh = obj.data
        bpy.data.objects.remove(obj)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)


def _share_materials(obj) -> None:
    """Use the materials of the same name that were there already."""
    for slot in obj.material_slots:
        brought = slot.material
        name, _, number = brought.name.rpartition(".")
        known = bpy.data.materials.get((name, None)) if number.isdigit() else None
        if known is not None:
            slot.material = known
            if brought.users == 0:
                bpy.data.materials.remove(brought)
