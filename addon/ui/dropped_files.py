"""Files that are dropped onto the viewport."""

import bpy

from ..bridge.import_motion import SUFFIXES


class WAYFARER_FH_motion(bpy.types.FileHandler):
    """Offers to import what is dropped onto a 3D viewport."""

    bl_idname = "WAYFARER_FH_motion"
    bl_label = "Import Motion (Wayfarer)"
    bl_import_operator = "wayfarer.import_motion"
    bl_file_extensions = ";".join(SUFFIXES)

    @classmethod
    def poll_drop(cls, context):
        return context.area is not None and context.area.type == "VIEW_3D"


CLASSES = (WAYFARER_FH_motion,)
