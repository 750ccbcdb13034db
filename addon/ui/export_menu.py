"""The entry in File > Export."""

import bpy


def _draw(self, context) -> None:
    self.layout.operator("wayfarer.export_engine", text="Wayfarer for Engines (folder)")


def register():
    bpy.types.TOPBAR_MT_file_export.append(_draw)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_draw)
