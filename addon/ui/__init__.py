"""The tab "Wayfarer" in the sidebar of the 3D viewport. Draws only; computes nothing."""

import bpy

from . import export_menu, overlay, swatches
from .finding_lists import WAYFARER_UL_findings
from .lists import WAYFARER_UL_clips, WAYFARER_UL_joint_weights, WAYFARER_UL_regions
from .panels import PANELS
from .walk_lists import WALK_LISTS

_CLASSES = (
    WAYFARER_UL_clips,
    WAYFARER_UL_joint_weights,
    WAYFARER_UL_regions,
    *WALK_LISTS,
    WAYFARER_UL_findings,
    *PANELS,
)


def register():
    swatches.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    overlay.register()
    export_menu.register()


def unregister():
    export_menu.unregister()
    overlay.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    swatches.unregister()
