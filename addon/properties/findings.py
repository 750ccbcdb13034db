"""Findings, kept with a scene: saved in its file, undone with everything else."""

import bpy
from bpy.props import CollectionProperty

from ..bridge.go_to_place import go_to_place
from .definitions import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty


def _on_row(finding, _) -> None:
    """A line was chosen: its place, if it has one, is looked at; nothing is selected."""
    row = finding.chosen
    if row is not None and row.has_place:
        go_to_place(finding.id_data, (*row.place, finding.height), row.size)


class WayfarerFindingRow(bpy.types.PropertyGroup):
    """A line of a list of findings; its name is the first column."""

    value: StringProperty(name="Value", description="The number, with its unit")
    note: StringProperty(name="Note", description="What to make of it")
    sentence: StringProperty(name="Sentence", description="What there is to say about it")
    icon: StringProperty(name="Icon", description="The icon in the list", default="NONE")
    has_place: BoolProperty(name="Has a Place", description="Whether it is somewhere", default=False)
    place: FloatVectorProperty(name="Place", description="Where it is", size=2, subtype="XYZ", unit="LENGTH")
    size: FloatProperty(name="Size", description="How far it stretches", subtype="DISTANCE", min=0.0)


class WayfarerFinding(bpy.types.PropertyGroup):
    """A finding about an embedding; its name is that of its topic."""

    made_from: StringProperty(name="Made From", description="The embedding that it is about")
    table: StringProperty(name="Table", description="All numbers, as JSON")
    numbers: StringProperty(name="Numbers", description="The numbers in the panel, as JSON", default="[]")
    sentences: StringProperty(name="Sentences", description="What there is to say, in lines")
    height: FloatProperty(name="Height", description="The ground's, on which places are", subtype="DISTANCE")
    rows: CollectionProperty(type=WayfarerFindingRow)
    active_row: IntProperty(
        name="Active Line",
        description="The line that was chosen; if it has a place, the 3D cursor goes there",
        default=-1,
        update=_on_row,
    )

    @property
    def chosen(self) -> WayfarerFindingRow | None:
        """The line chosen in the list."""
        return self.rows[self.active_row] if 0 <= self.active_row < len(self.rows) else None


CLASSES = (WayfarerFindingRow, WayfarerFinding)
