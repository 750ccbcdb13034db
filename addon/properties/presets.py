"""Presets of settings, in the headers of their panels: Blender's own kind, files in the user's scripts folder."""

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .embedding import WayfarerEmbeddingSettings
from .environment import WayfarerEnvironmentSettings
from .motion_graph import WayfarerGraphSettings

_NEVER_KEPT = ("rna_type", "name")


def _preset(identifier: str, label: str, group: type, left_out=()) -> tuple[type, type]:
    """Make popover and operator of one group of ``scene.wayfarer``: every plain setting but those ``left_out``."""
    panel = type(
        f"WAYFARER_PT_{identifier}_presets",
        (PresetPanel, bpy.types.Panel),
        {
            "bl_label": f"{label} Presets",
            "preset_subdir": f"wayfarer/{identifier}",
            "preset_operator": "script.execute_preset",
            "preset_add_operator": f"wayfarer.add_{identifier}_preset",
        },
    )
    # Annotations hold the properties that a group defines itself; what refers to objects is of one file only.
    names = [
        name
        for name, prop in group.__annotations__.items()
        if prop.function.__name__ not in ("PointerProperty", "CollectionProperty")
        and not name.startswith("active_")
        and name not in (*_NEVER_KEPT, *left_out)
    ]
    operator = type(
        f"WAYFARER_OT_add_{identifier}_preset",
        (AddPresetBase, bpy.types.Operator),
        {
            "bl_idname": f"wayfarer.add_{identifier}_preset",
            "bl_label": f"Add {label} Preset",
            "bl_description": "Keep these settings under a name, or remove the preset of that name",
            "preset_menu": panel.__name__,
            "preset_defines": [f"settings = bpy.context.scene.wayfarer.{identifier}"],
            "preset_values": [f"settings.{name}" for name in names],
            "preset_subdir": f"wayfarer/{identifier}",
        },
    )
    return panel, operator


def draw_presets(identifier: str, layout) -> None:
    """Draw the button that opens the presets of a group, for the header of its panel."""
    getattr(bpy.types, f"WAYFARER_PT_{identifier}_presets").draw_panel_header(layout)


# Where the ground is, is of one scene only.
_PLACES = ("ground_source", "ground_low", "ground_high", "ground_height")
CLASSES = (
    *_preset("graph", "Motion Graph", WayfarerGraphSettings, ("use_custom_weights",)),
    *_preset("environment", "Environment", WayfarerEnvironmentSettings, _PLACES),
    *_preset("embedding", "Embedding", WayfarerEmbeddingSettings),
)
