"""The maps of the floor, one file for each family: a new map is a new file, named here.

Each file has a tuple ``MAPS`` of :class:`.floor_map.FloorMap`; the choice in the panel, the operator and live
evaluation know all maps from here.
"""

from enum import Enum

from . import coverage, long_way, occupancy, query, reach, single_segment, variability, weak_spots, why_not
from .floor_map import FloorMap, MapOptions, PaintedMap

__all__ = ["MAPS", "FloorMap", "MapOptions", "MapQuantity", "PaintedMap", "map_of"]

# In the order of the choice in the panel.
_FAMILIES = (variability, coverage, single_segment, why_not, weak_spots, reach, query, long_way, occupancy)

MAPS: tuple[FloorMap, ...] = tuple(kind for family in _FAMILIES for kind in family.MAPS)

MapQuantity = Enum("MapQuantity", {kind.name: kind.label for kind in MAPS})
MapQuantity.__doc__ = "What can be painted on the floor."


def map_of(quantity: str) -> FloorMap:
    """The map of this name."""
    return next(kind for kind in MAPS if kind.name == quantity)
