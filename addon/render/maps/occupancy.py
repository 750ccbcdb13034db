"""Where random walkers spend their time."""

from collections.abc import Generator

import numpy as np

from ....core.embedding.embedding import Embedding
from ....core.evaluation.occupancy import occupancy_steps
from ....core.progress import Progress
from ..map_colors import lightest_value, lightness, scaled_colors
from ..map_legend import ColorBar, MapLegend
from .floor_map import FloorMap, MapOptions, PaintedMap, place_swatches

_UNIT = 1e-4
"""The scale counts hundredths of a per cent: cells are small."""


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    found = yield from occupancy_steps(embedding)
    share, scale = found.floor / _UNIT, options.scale
    present, end = share > 0, lightest_value(share)
    per_area = share * _UNIT / found.cell_area
    x, y = found.hot_spot
    highest = f"{100 * float(per_area.max()):.1f} %/m²"
    ticks = tuple((at, f"{100 * end * at**2 * _UNIT / found.cell_area:.1f}") for at in (0.0, 0.5, 1.0))
    legend = MapLegend(
        title="Occupancy",
        unit="% of time/m²",
        bar=ColorBar(scale.stops, ticks),
        swatches=place_swatches(scale, embedding, "Never Passed"),
        numbers=(("Highest", highest), ("Hot Spot", f"{x:.1f}, {y:.1f} m")),
    )
    return PaintedMap(
        colors=scaled_colors(lightness(share, end), present, embedding.environment, scale),
        legend=legend,
        numbers={"map_highest": float(found.floor.max()), "map_cells": int(np.count_nonzero(present))},
        report=f"Random walkers spend most time around {x:.1f}, {y:.1f} m: {highest} of it",
    )


MAPS = (
    FloorMap(
        name="OCCUPANCY",
        number=6,
        label="Occupancy",
        description="Where walkers that take every link with the same probability spend their time",
        paint_steps=_steps,
        heeds=frozenset({"palette"}),
    ),
)
