"""The tab "Wayfarer" in the sidebar of the 3D viewport, and an entry in File > Export. Draws only; computes nothing."""

import bpy

from . import dropped_files, lists, overlay, swatches
from .panels import PANELS

_CLASSES = (*lists.CLASSES, *dropped_files.CLASSES, *PANELS)
_register, _unregister = bpy.utils.register_classes_factory(_CLASSES)  # pyright: ignore[reportGeneralTypeIssues]


def _draw_export(self, context) -> None:
    self.layout.operator("wayfarer.export_engine", text="Wayfarer for Engines (folder)")


def register():
    swatches.register()
    _register()
    overlay.register()
    bpy.types.TOPBAR_MT_file_export.append(_draw_export)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_draw_export)
    overlay.unregister()
    _unregister()
    swatches.unregister()
