"""Weak spots: connected areas that the character cannot reach, or passes in few ways only."""

from collections.abc import Generator

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.floor import ruled_cells
from ..evaluation.weak_spots import Weakness, WeakSpotSettings, weak_spots_steps
from ..progress import Progress
from ..wording import counted
from .colors import RULED, opaque_map
from .floor_map import FloorMap, MapOptions, PaintedMap
from .legend import MapLegend, Swatch

# sRGB, apart for everybody: vermilion and yellow of Okabe and Ito's palette on light and dark grey.
_COLORS = {Weakness.UNREACHED: (0.84, 0.37, 0.00), Weakness.FEW_WAYS: (0.94, 0.89, 0.26)}
_SOUND, _BLOCKED = (0.72, 0.72, 0.71), (0.10, 0.11, 0.13)
_LISTED = 5


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    found = yield from weak_spots_steps(embedding, WeakSpotSettings(threshold=options.few_ways))
    environment = embedding.environment
    ruled = ruled_cells(environment, embedding.unrolling.sweep.classes)[..., None]
    colors = np.where(environment.free_cells()[..., None], np.where(ruled, RULED, _SOUND), _BLOCKED)
    shares = dict.fromkeys(_COLORS, 0)
    for number, spot in enumerate(found.spots, start=1):
        cells = found.labels == number
        colors[cells] = _COLORS[spot.weakness]
        shares[spot.weakness] += int(cells.sum())
    cell_area = environment.grid.cell_size**2
    rule = (Swatch(RULED, "Region With a Rule"),) if environment.regions else ()
    swatches = [
        Swatch(_COLORS[weakness], weakness.value, wording.area(n_cells * cell_area))
        for weakness, n_cells in shares.items()
    ]
    listed = tuple(
        (wording.area(spot.floor_area), f"at {wording.place(*spot.position)}") for spot in found.spots[:_LISTED]
    )
    legend = MapLegend(
        title="Weak Spots",
        swatches=(*swatches, Swatch(_SOUND, "Sound"), *rule, Swatch(_BLOCKED, "Too Near an Obstacle")),
        numbers=(("Weak Spots", wording.number(len(found.spots))), *listed),
    )
    return PaintedMap(
        colors=opaque_map(colors),
        legend=legend,
        numbers={"weak_spots": len(found.spots), "weak_area": found.area},
        report=f"{counted(len(found.spots), 'weak spot')}; the largest: {found.spots[0].describe()}"
        if found.spots
        else "There are no weak spots",
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
