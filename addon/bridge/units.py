"""Numbers in the units of the scene, for panels: sentences, maps and files are in metres."""

from typing import Any

import bpy

from ...core.wording import length, slide

_IMPERIAL_DIGITS = 3


def scene_length(scene, metres: float) -> str:
    """A length beside the fields of a panel: "1.2 m", or "3.94'" in a scene with imperial units.

    Whatever the scene's unit scale is: a unit of Blender is a metre.
    """
    return _imperial("LENGTH", metres) if _is_imperial(scene) else length(metres)


def scene_slide(scene, metres_per_second: float) -> str:
    """The speed of a foot that should stand: "2.3 cm/s", or "0.0755 ft/s"."""
    return _imperial("VELOCITY", metres_per_second) if _is_imperial(scene) else slide(metres_per_second)


def _is_imperial(scene) -> bool:
    return scene.unit_settings.system == "IMPERIAL"


def _imperial(category: Any, value: float) -> str:
    return bpy.utils.units.to_string("IMPERIAL", category, value, precision=_IMPERIAL_DIGITS)
