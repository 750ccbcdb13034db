"""What panels have in common."""

import bpy

from ...properties.presets import draw_presets
from ..text import draw_wrapped


class Sidebar:
    """Where all panels are."""

    layout: bpy.types.UILayout
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Wayfarer"


class Step(Sidebar):
    """A step of the work; its header says whether it has been done."""

    def result_is_there(self, scene) -> bool:
        """Whether this step has been done."""
        return False

    def result_is_stale(self, scene) -> bool:
        """Whether what it was done with has changed since."""
        return False

    presets = ""
    """The group of settings that presets can be made of."""

    def draw_header_preset(self, context):
        scene = context.scene
        if self.presets:
            draw_presets(self.presets, self.layout)
        if self.result_is_stale(scene):
            self.layout.label(text="Changed", icon="ERROR")
        elif self.result_is_there(scene):
            self.layout.label(text="", icon="CHECKMARK")


def split_properties(layout):
    """Settings in two columns, without the dots for keyframes."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def draw_numbers(layout, rows) -> None:
    """Names and values in two columns."""
    grid = layout.column(align=True)
    for name, value in rows:
        split = grid.split(factor=0.55, align=True)
        left = split.row()
        left.alignment = "RIGHT"
        left.active = False
        left.label(text=name)
        split.label(text=value, translate=False)


def draw_table(layout, rows, factor: float = 0.72, heading: tuple[str, str] | None = None) -> None:
    """Text on the left, a value at the right end of each row; rows are (text, value, icon number).

    ``heading`` names the two columns.
    """
    column = layout.column(align=True)
    for number, (text, value, icon) in enumerate([(*heading, 0), *rows] if heading else rows):
        split = column.split(factor=factor, align=True)
        split.active = number > 0 or heading is None
        split.label(text=text, translate=False, icon_value=icon)
        right = split.row()
        right.alignment = "RIGHT"
        right.label(text=value, translate=False)


def draw_sentences(context, layout, sentences, icon: str = "ERROR") -> None:
    """What there is to say, one after the other, each with an icon."""
    for sentence in sentences:
        row = layout.row(align=True)
        row.label(text="", icon=icon)
        draw_wrapped(context, row, sentence, margin=86)
