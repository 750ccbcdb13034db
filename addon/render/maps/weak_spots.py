"""Weak spots: connected areas that the character cannot reach, or passes in few ways only."""

from collections.abc import Generator

import numpy as np

from ....core.embedding.embedding import Embedding
from ....core.evaluation.weak_spots import Weakness, WeakSpotSettings, weak_spots_steps
from ....core.progress import Progress
from ..map_colors import opaque_map
from ..map_legend import MapLegend, Swatch
from .floor_map import FloorMap, MapOptions, PaintedMap

# sRGB, apart for everybody: vermilion and yellow of Okabe and Ito's palette on light and dark grey.
_COLORS = {Weakness.UNREACHED: (0.84, 0.37, 0.00), Weakness.FEW_WAYS: (0.94, 0.89, 0.26)}
_SOUND, _BLOCKED = (0.72, 0.72, 0.71), (0.10, 0.11, 0.13)
_LISTED = 5


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    found = yield from weak_spots_steps(embedding, WeakSpotSettings(threshold=options.few_ways))
    colors = np.where(embedding.environment.free_cells()[..., None], _SOUND, _BLOCKED)
    shares = dict.fromkeys(_COLORS, 0)
    for number, spot in enumerate(found.spots, start=1):
        cells = found.labels == number
        colors[cells] = _COLORS[spot.weakness]
        shares[spot.weakness] += int(cells.sum())
    cell_area = embedding.environment.grid.cell_size**2
    swatches = [
        Swatch(_COLORS[weakness], weakness.value, f"{n_cells * cell_area:.1f} m²")
        for weakness, n_cells in shares.items()
    ]
    listed = tuple(
        (f"{spot.floor_area:.1f} m²", f"at {spot.position[0]:.1f}, {spot.position[1]:.1f} m")
        for spot in found.spots[:_LISTED]
    )
    legend = MapLegend(
        title="Weak Spots",
        swatches=(*swatches, Swatch(_SOUND, "Sound"), Swatch(_BLOCKED, "Too Near an Obstacle")),
        numbers=(("Weak Spots", str(len(found.spots))), *listed),
    )
    return PaintedMap(
        colors=opaque_map(colors),
        legend=legend,
        numbers={"weak_spots": len(found.spots), "weak_area": found.area},
        report=found.spots[0].describe() if found.spots else "There are no weak spots",
    )


MAPS = (
    FloorMap(
        name="WEAK_SPOTS",
        number=7,
        label="Weak Spots",
        description="Connected areas that the character cannot reach, or passes in fewer ways than a threshold",
        paint_steps=_steps,
        heeds=frozenset({"few_ways"}),
    ),
)
