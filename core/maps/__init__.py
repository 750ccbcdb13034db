"""Maps of the floor: what each shows, its colours and its legend.

A new map is a :class:`.floor_map.FloorMap` in a file of its kind, listed here: the choice in the panel, the
operator and live evaluation know all maps from here.
"""

from enum import Enum

from .amounts import COVERAGE, OCCUPANCY, SEGMENT, VARIABILITY
from .floor_map import FloorMap, MapOptions, PaintedMap
from .reasons import WEAK_SPOTS, WHY_NOT
from .times import LONG_WAY, QUERY, REACH

__all__ = ["MAPS", "QUERY", "FloorMap", "MapOptions", "MapQuantity", "PaintedMap", "map_of"]

#: In the order of the choice in the panel.
MAPS = (VARIABILITY, COVERAGE, SEGMENT, WHY_NOT, WEAK_SPOTS, REACH, QUERY, LONG_WAY, OCCUPANCY)

MapQuantity = Enum("MapQuantity", {kind.name: kind.label for kind in MAPS})
MapQuantity.__doc__ = "Everything that can be painted on the floor."


def map_of(quantity: str) -> FloorMap:
    """Return the map of this name.

    >>> map_of("COVERAGE").label
    'Coverage'
    """
    return next(kind for kind in MAPS if kind.name == quantity)
