"""A scene of its own for each picture, so that the user's scene stays as it is."""

import contextlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ...addon.bridge.versions import keep_material_colors
from ...core.maps.colors import linear

_TEMPORARY = "wayfarer_temporary"
"""Custom property of what is removed with the scene."""


@dataclass(frozen=True)
class PictureScene:
    """A temporary scene; lives within :func:`picture_scene` only."""

    scene: bpy.types.Scene

    def show(self, objects: Iterable) -> None:
        """Show objects of other scenes as well."""
        for obj in objects:
            if obj is not None and self.scene.objects.get(obj.name) is None:
                self.scene.collection.objects.link(obj)

    def add(self, name: str, data) -> bpy.types.Object:
        """A new object, removed with the scene."""
        obj = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(obj)
        obj[_TEMPORARY] = True
        return obj

    def flat_material(self, srgb) -> bpy.types.Material:
        """A material that the workbench shows in this colour, removed with the scene."""
        name = "Wayfarer " + "-".join(f"{value:.3f}" for value in srgb)
        known = next((m for m in bpy.data.materials if m.get(_TEMPORARY) == name), None)
        if known is not None:
            return known
        material = self.material(name)
        material.diffuse_color = opaque(srgb)
        return material

    def material(self, name: str) -> bpy.types.Material:
        """A new material, removed with the scene."""
        material = bpy.data.materials.new(name)
        material[_TEMPORARY] = name
        return material

    def camera(self) -> bpy.types.Object:
        """The scene's camera, at the origin at first."""
        self.scene.camera = self.add("Camera", bpy.data.cameras.new("Camera"))
        return self.scene.camera

    def render(self, path: Path, width: int, height: int) -> None:
        keep_material_colors(self.scene.objects)
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
        render.image_settings.file_format = "PNG"
        render.image_settings.color_mode = "RGB"
        render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=self.scene.name)


@contextlib.contextmanager
def picture_scene(name: str) -> Iterator[PictureScene]:
    """A new scene that shows colours as they are; it and all that was added to it are removed at the end."""
    fonts = {font.session_uid for font in bpy.data.fonts}
    scene = bpy.data.scenes.new(name)
    settings: Any = scene.view_settings
    settings.view_transform = "Standard"
    try:
        yield PictureScene(scene)
    finally:
        for obj in [obj for obj in scene.objects if _TEMPORARY in obj]:
            data = obj.data
            bpy.data.objects.remove(obj)
            if data is not None and data.users == 0:
                bpy.data.batch_remove([data])
        bpy.data.batch_remove([m for m in bpy.data.materials if _TEMPORARY in m])
        # The first text in a file brings Blender's own font.
        bpy.data.batch_remove([font for font in bpy.data.fonts if font.session_uid not in fonts and not font.users])
        if scene.world is not None and scene.world.users == 1:
            bpy.data.worlds.remove(scene.world)
        bpy.data.scenes.remove(scene)


def opaque(srgb) -> tuple[float, float, float, float]:
    """Linear RGBA of an sRGB colour."""
    return (*linear(srgb).tolist(), 1.0)
