"""Small squares of colour, as icons for legends."""

import bpy.utils.previews
import numpy as np

_SIZE = 32
_EDGE = 5
"""Clear pixels around the square."""

_previews = None


def swatch(color: tuple[float, float, float]) -> int:
    """Number of the icon in this colour (sRGB), drawn when it is first asked for; 0, for none, where there are none."""
    if _previews is None:
        return 0
    name = " ".join(f"{part:.3f}" for part in color)
    if name not in _previews:
        pixels = np.zeros((_SIZE, _SIZE, 4), dtype=np.float32)
        pixels[_EDGE:-_EDGE, _EDGE:-_EDGE] = (0.5, 0.5, 0.5, 1.0)
        pixels[_EDGE + 1 : -_EDGE - 1, _EDGE + 1 : -_EDGE - 1] = (*color, 1.0)
        icon = _previews.new(name)
        icon.icon_size = (_SIZE, _SIZE)
        icon.icon_pixels_float.foreach_set(pixels.ravel())
    return _previews[name].icon_id


def register():
    global _previews
    _previews = bpy.utils.previews.new()


def unregister():
    global _previews
    bpy.utils.previews.remove(_previews)
    _previews = None
