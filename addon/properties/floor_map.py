"""Settings of the map on the floor."""

from typing import cast

import bpy

from ...core.maps import MAPS, FloorMap, MapOptions, MapQuantity, map_of
from ...core.maps.colors import Palette
from ..session import SESSION
from .definitions import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty, enum_items
from .graph_names import segment_names

__all__ = ["CLASSES", "MapQuantity", "WayfarerMapSettings"]


def map_changed(settings, _) -> None:
    """Notify the session of a change: the update callback of settings that the map depends on."""
    for listener in SESSION.listeners:
        listener.map_changed(settings.id_data)


class WayfarerMapSettings(bpy.types.PropertyGroup):
    """Settings of the map on the floor."""

    quantity: EnumProperty(
        # With numbers, so that files keep their choice when there are more maps.
        items=[(kind.name, kind.label, kind.description, "NONE", kind.number) for kind in MAPS],
        name="Map",
        description="What to paint on the floor",
        default=MapQuantity.VARIABILITY.name,
        update=map_changed,
    )
    palette: EnumProperty(
        items=enum_items(
            {
                Palette.GREYS: ("Greys", "From dark to light grey; what is out of reach is red"),
                Palette.VIRIDIS: ("Viridis", "From violet over green to yellow; for all kinds of colour vision"),
                Palette.CIVIDIS: ("Cividis", "From blue to yellow; looks alike to all kinds of colour vision"),
            }
        ),
        name="Colors",
        description="The scale of colours",
        default=Palette.GREYS.name,
        update=map_changed,
    )
    use_heading: BoolProperty(
        name="Single Heading",
        description="Show one heading instead of all of them together",
        default=False,
        update=map_changed,
    )
    heading: FloatProperty(
        name="Heading",
        description="The direction that the character faces, counter-clockwise from the X axis; the nearest one of "
        "the grid is shown",
        subtype="ANGLE",
        default=0.0,
        soft_min=0.0,
        soft_max=6.283185307,
        step=1500,
        update=map_changed,
    )
    segment: StringProperty(
        name="Segment",
        description="The motion segment that is shown; without one, the first",
        search=segment_names,
        update=map_changed,
    )
    goal: EnumProperty(
        items=[
            ("CURSOR", "3D Cursor", "The cell under the 3D cursor"),
            ("OBJECT", "Active Object", "The cell under the origin of the active object"),
        ],
        name="To",
        description="Where the character is to go",
        default="CURSOR",
        update=map_changed,
    )
    bands: BoolProperty(
        name="Bands",
        description="Show times in a few steps, such as 2, 3, 5 and 7 s, instead of continuously",
        default=True,
        update=map_changed,
    )
    few_ways: IntProperty(
        name="Few Ways",
        description="Variability under which a place that is reached counts as weak; with 0, only places that are not "
        "reached do",
        default=0,
        min=0,
        update=map_changed,
    )
    offset: FloatProperty(
        name="Offset",
        description="Height of the painted floor above the ground, so that the two do not flicker through each other; "
        "large grounds, which are looked at from farther away, have a larger one",
        subtype="DISTANCE",
        default=0.004,
        min=0.0,
        soft_max=0.1,
        precision=3,
        update=map_changed,
    )

    @property
    def kind(self) -> FloorMap:
        return map_of(self.quantity)

    @property
    def _scene(self) -> bpy.types.Scene:
        return cast(bpy.types.Scene, self.id_data)

    def to_core(self) -> MapOptions:
        """The options as they are at this moment."""
        return MapOptions(
            palette=Palette[self.palette],
            heading=self.heading if self.use_heading else None,
            segment=self.segment,
            goal=self._goal(),
            bands=self.bands,
            few_ways=self.few_ways,
            query=self._scene.wayfarer.queries.to_query(),
        )

    @property
    def key(self) -> str:
        """Says which map is asked for: the same for the same map, whatever it does not heed."""
        return self.key_of(self.kind)

    def key_of(self, kind: FloorMap) -> str:
        """The same, if this kind of map is asked for."""
        options = self.to_core()
        heeded = [f"{name}={getattr(options, name)!r}" for name in sorted(kind.heeds)]
        return " ".join([kind.name, *heeded, f"offset={self.offset:.6f}"])

    def _goal(self) -> tuple[float, float]:
        scene = self._scene
        place = scene.cursor.location
        if self.goal == "OBJECT":
            active = [layer.objects.active for layer in scene.view_layers if layer.objects.active is not None]
            if active:
                place = active[0].matrix_world.translation
        return float(place[0]), float(place[1])


class WayfarerOverlaySettings(bpy.types.PropertyGroup):
    """Settings of what is drawn over the viewport."""

    show_legend: BoolProperty(
        name="Legend", description="Show in the viewport what the colours of the floor mean", default=True
    )
    # It was a choice once: files keep 0 for never, 1 for always and 2 for while the panel is open, which is read as on.
    show_environment: BoolProperty(
        name="Show in Viewport",
        description="Draw the ground rectangle, what obstacles block, the regions and the size of the character at the "
        "3D cursor",
        default=False,
    )
    place: StringProperty(
        name="Place", description="What was found out about the place that was clicked last, in lines"
    )


CLASSES = (WayfarerMapSettings, WayfarerOverlaySettings)
