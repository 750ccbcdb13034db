"""Where random walkers spend their time."""

from collections.abc import Generator

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.occupancy import occupancy_steps
from ..progress import Progress
from .colors import lightest_value, lightness, scaled_colors
from .floor_map import FloorMap, MapOptions, PaintedMap, place_swatches
from .legend import ColorBar, MapLegend


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    found = yield from occupancy_steps(embedding)
    share, scale = found.floor, options.scale
    present = share > 0
    # Counted in millionths: the scale ends at 1 at least, and cells are small.
    end = lightest_value(1e6 * share) / 1e6
    highest = f"{wording.share(float(share.max()) / found.cell_area)} for each m²"
    ticks = [(at, wording.short(100 * end * at**2 / found.cell_area)) for at in (0.0, 0.5, 1.0)]
    if share.max() > end:
        ticks[-1] = (1.0, f"{ticks[-1][1]}+")
    legend = MapLegend(
        title="Occupancy",
        unit="% of time per m²",
        bar=ColorBar(scale.stops, tuple(ticks)),
        swatches=place_swatches(scale, embedding, "Never Passed"),
        numbers=(("Busiest Place", wording.place(*found.hot_spot)), ("Time There", highest)),
    )
    return PaintedMap(
        colors=scaled_colors(lightness(share, end), present, embedding, scale),
        legend=legend,
        numbers={"map_highest": float(found.floor.max()), "map_cells": int(np.count_nonzero(present))},
        report=f"Random walkers spend most time around {wording.place(*found.hot_spot)}: {highest}",
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
