"""A kind of map: a name, the settings that it heeds, and a function that paints it."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.query import Query
from ..progress import Progress
from .colors import FloorScale, Palette, scale_of
from .legend import MapLegend, Swatch


@dataclass(frozen=True)
class MapOptions:
    """Settings of all maps; each heeds those that it names in ``FloorMap.heeds``.

    Attributes
    ----------
    palette : Palette
    heading : float or None
        Radians; the nearest heading of the grid counts. None for all headings.
    segment : str
        Name of a motion segment.
    goal : (x, y) in metres
        Where the character is to go.
    bands : bool
        Whether times are shown in a few steps instead of continuously.
    few_ways : int
        Variability under which a place that is reached counts as weak.
    query : Query
        What the panel Queries asks.
    """

    palette: Palette = Palette.GREYS
    heading: float | None = None
    segment: str = ""
    goal: tuple[float, float] = (0.0, 0.0)
    bands: bool = True
    few_ways: int = 0
    query: Query = field(default_factory=Query)

    def heading_index(self, embedding: Embedding) -> int | None:
        """Return the grid's heading that is nearest to ``heading``."""
        grid = embedding.environment.grid
        return None if self.heading is None else round(self.heading / grid.heading_step) % grid.n_headings

    @property
    def scale(self) -> FloorScale:
        return scale_of(self.palette)


@dataclass(frozen=True)
class PaintedMap:
    """A map, ready to be put on the floor.

    Attributes
    ----------
    colors : (nx, ny, 4) float array
        Linear RGBA of each cell.
    legend : MapLegend
    numbers : dict of plain values
        For the summary of the scene and for reports.
    report : str
        What there is to say when it has been painted, in a sentence without full stop.
    """

    colors: np.ndarray
    legend: MapLegend
    numbers: dict[str, Any] = field(default_factory=dict)
    report: str = ""


@dataclass(frozen=True)
class FloorMap:
    """A kind of map.

    Attributes
    ----------
    name : str
        Identifier of the choice in the panel.
    number : int
        What files keep of that choice: never to be changed, never to be used again.
    label, description : str
        For people; the description is a tooltip.
    paint_steps : function of an embedding and MapOptions
        Yields progress and returns the PaintedMap; raises MotionGraphError if it cannot be made.
    heeds : frozenset of str
        Names of the MapOptions that make a difference.
    """

    name: str
    number: int
    label: str
    description: str
    paint_steps: Callable[[Embedding, MapOptions], Generator[Progress, None, PaintedMap]]
    heeds: frozenset[str] = frozenset()


def place_swatches(scale: FloorScale, embedding: Embedding, unreached: str) -> tuple[Swatch, ...]:
    """Return the legend of the colours beside the scale; those of regions only where there are any."""
    ruled = (Swatch(scale.ruled, "Region With a Rule"),) if embedding.environment.regions else ()
    return (Swatch(scale.unreached, unreached), *ruled, Swatch(scale.blocked, "Too Near an Obstacle"))


def heading_words(embedding: Embedding, index: int | None) -> str:
    """Return ", Heading 45°" for a single heading, and nothing for all of them."""
    if index is None:
        return ""
    return f", Heading {wording.angle(index * embedding.environment.grid.heading_step)}"
