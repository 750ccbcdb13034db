"""Maps of how much of something there is in each cell, on a scale of colours."""

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.floor import floor_cells
from ..wording import counted
from .colors import lightest_value, lightness, scaled_colors
from .floor_map import MapOptions, PaintedMap, place_swatches
from .legend import ColorBar, MapLegend

_TICKS = (0.0, 0.5, 1.0)


def paint_amounts(
    embedding: Embedding, options: MapOptions, values: np.ndarray, title: str, noun: str, unreached: str
) -> PaintedMap:
    """The map of (nx, ny) integer ``values``, 0 where there is none; ``noun`` is what is counted, in the singular.

    The scale ends at the 99th percentile and grows with the square root: few ways can be told from none, and a single
    busy cell does not darken all others.
    """
    scale, lightest = options.scale, lightest_value(values)
    present = values > 0
    highest, n_cells = int(values.max(initial=0)), int(present.sum())
    n_floor = int(floor_cells(embedding).sum())
    ticks = tuple((at, wording.short(max(round(lightest * at**2), 1))) for at in _TICKS)
    if highest > lightest:
        ticks = (*ticks[:-1], (1.0, f"{ticks[-1][1]}+"))
    legend = MapLegend(
        title=title,
        unit=f"{noun}s",
        bar=ColorBar(scale.stops, ticks),
        swatches=place_swatches(scale, embedding, unreached),
        numbers=(("Cells Covered", wording.number(n_cells)), ("Most in a Cell", counted(highest, noun))),
    )
    return PaintedMap(
        colors=scaled_colors(lightness(values, lightest), present, embedding, scale),
        legend=legend,
        numbers={"map_highest": highest, "map_cells": n_cells},
        report=f"{title}: {wording.number(n_cells)} of {counted(n_floor, 'cell')} of free floor, up to "
        f"{counted(highest, noun)} in a cell",
    )
