"""The tab "Wayfarer" in the sidebar of the 3D viewport. Draws only; computes nothing."""

import bpy

from . import swatches
from .lists import WAYFARER_UL_clips, WAYFARER_UL_joint_weights, WAYFARER_UL_regions
from .panels import PANELS

_CLASSES = (WAYFARER_UL_clips, WAYFARER_UL_joint_weights, WAYFARER_UL_regions, *PANELS)


def register():
    swatches.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    swatches.unregister()
