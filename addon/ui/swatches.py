"""Small squares of colour, as icons for legends."""

import bpy.utils.previews
import numpy as np

from ..render.reason_colors import reason_legend

_SIZE = 32
_EDGE = 5
"""Clear pixels around the square."""

_previews = None


def swatch(name: str) -> int:
    """Number of the icon in the colour of this reason; 0, for none, where icons cannot be drawn."""
    return _previews[name].icon_id if _previews is not None and name in _previews else 0


def register():
    global _previews
    _previews = bpy.utils.previews.new()
    for name, (_, color) in reason_legend().items():
        pixels = np.zeros((_SIZE, _SIZE, 4), dtype=np.float32)
        pixels[_EDGE:-_EDGE, _EDGE:-_EDGE] = (0.5, 0.5, 0.5, 1.0)
        pixels[_EDGE + 1 : -_EDGE - 1, _EDGE + 1 : -_EDGE - 1] = (*color, 1.0)
        icon = _previews.new(name)
        icon.icon_size = (_SIZE, _SIZE)
        icon.icon_pixels_float.foreach_set(pixels.ravel())


def unregister():
    global _previews
    bpy.utils.previews.remove(_previews)
    _previews = None
