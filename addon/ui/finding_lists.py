"""Lists of what was found out."""

from typing import Any

import bpy

_SHARES = {
    "ABLATION": (0.66, 1.0),
    "ACTIONS": (0.5, 0.54),
    "CAPTURE": (0.72, 1.0),
    "DELETION": (0.68, 1.0),
    "OCCUPANCY": (0.75, 1.0),
    "WEAK_SPOTS": (0.33, 0.5),
}
"""By topic, shares of a row's width for the name, and of the rest for the value: a sidebar is narrow. Where the value
takes all of it, icon and sentence say what the note says."""


class WAYFARER_UL_findings(bpy.types.UIList):
    """Lines with a name, a number and what to make of it."""

    def draw_item(self, context, layout, data: Any, item: Any, icon, active_data, active_property, index=0, flt_flag=0):
        name_share, value_share = _SHARES.get(data.name, (0.66, 1.0))
        split = layout.split(factor=name_share, align=True)
        # The unit of areas stands above the list.
        split.label(text=item.name.removesuffix(" m²"), icon=item.icon, translate=False)
        if not item.note or value_share == 1.0:
            value = split.row()
            value.alignment = "RIGHT"
            value.label(text=item.value, translate=False)
            return
        rest = split.split(factor=value_share, align=True)
        value = rest.row()
        value.alignment = "RIGHT"
        value.label(text=item.value, translate=False)
        note = rest.row()
        note.active = False
        note.label(text=item.note, translate=False)

    def filter_items(self, context, data, property_name):
        """Filter by name or note, in the order of importance that they have."""
        rows, wanted = getattr(data, property_name), self.filter_name.lower()
        if not wanted:
            return [], []
        shown = self.bitflag_filter_item
        return [shown if wanted in f"{row.name} {row.note}".lower() else 0 for row in rows], []
