"""Maps of what is amiss: why the character cannot go to a place, and where it is out of reach or scarcely passed."""

from collections.abc import Generator

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.floor import ruled_cells
from ..evaluation.weak_spots import Weakness, WeakSpotSettings, weak_spots_steps
from ..evaluation.why_not import REASON_LABELS, Reason, floor_reasons, reason_shares, rule_labels, why_not_steps
from ..progress import Progress
from ..wording import counted
from .colors import RULED, opaque_map
from .floor_map import FloorMap, MapOptions, PaintedMap
from .legend import MapLegend, Swatch

# sRGB, after Okabe and Ito's palette for all kinds of colour vision; lightness differs, too.
_REASON_COLORS = {
    Reason.EMBEDDED: (0.88, 0.88, 0.87),
    Reason.BLOCKED: (0.07, 0.08, 0.10),
    Reason.RULE: (0.40, 0.15, 0.00),
    Reason.FORBIDDEN: (0.94, 0.89, 0.26),
    Reason.NO_WAY_OUT: (0.84, 0.37, 0.00),
    Reason.NO_WAY_IN: (0.00, 0.36, 0.62),
    Reason.NO_MATCH: (0.80, 0.47, 0.65),
    Reason.OTHER_COMPONENT: (0.00, 0.62, 0.45),
    Reason.UNREACHABLE: (0.45, 0.45, 0.47),
    Reason.NO_GROUND: (0.68, 0.88, 0.98),
}

# sRGB, apart for everybody: vermilion and yellow of Okabe and Ito's palette on light and dark grey.
WEAKNESS_COLORS = {Weakness.UNREACHED: (0.84, 0.37, 0.00), Weakness.FEW_WAYS: (0.94, 0.89, 0.26)}
SOUND, _BLOCKED = (0.72, 0.72, 0.71), (0.10, 0.11, 0.13)
_LISTED = 5


def reason_colors(floor: np.ndarray) -> np.ndarray:
    """Return (nx, ny, 4) linear RGBA for the floor, from (nx, ny) reasons."""
    table = np.array([_REASON_COLORS[reason] for reason in Reason])
    return opaque_map(table[floor])


def reason_legend() -> dict[str, tuple[str, tuple[float, float, float]]]:
    """Return label and sRGB colour of each reason, by its name."""
    return {reason.name: (REASON_LABELS[reason], _REASON_COLORS[reason]) for reason in Reason}


def _why_not_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Find the reason for each cell that the character cannot go to."""
    reasons = yield from why_not_steps(embedding)
    floor = floor_reasons(reasons)
    shares = reason_shares(floor)
    legend, rules = reason_legend(), rule_labels(embedding.environment)
    swatches = tuple(
        Swatch(legend[name][1], rules if name == Reason.RULE.name else legend[name][0], wording.share(share))
        for name, share in sorted(shares.items(), key=lambda item: -item[1])
    )
    missing = 1 - shares.get(Reason.EMBEDDED.name, 0.0)
    return PaintedMap(
        colors=reason_colors(floor),
        legend=MapLegend(title="Why Not", swatches=swatches),
        numbers={"reasons": shares},
        report=f"The character cannot go to {wording.share(missing)} of {counted(floor.size, 'cell')}",
    )


WHY_NOT = FloorMap(
    name="WHY_NOT",
    number=2,
    label="Why Not",
    description="Why the character cannot go where it cannot go",
    paint_steps=_why_not_steps,
)


def _weak_spot_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Find connected areas that are out of reach, or passed in few ways."""
    found = yield from weak_spots_steps(embedding, WeakSpotSettings(threshold=options.few_ways))
    environment = embedding.environment
    ruled = ruled_cells(environment, embedding.unrolling.sweep.classes)[..., None]
    colors = np.where(environment.free_cells()[..., None], np.where(ruled, RULED, SOUND), _BLOCKED)
    shares = dict.fromkeys(WEAKNESS_COLORS, 0)
    for number, spot in enumerate(found.spots, start=1):
        cells = found.labels == number
        colors[cells] = WEAKNESS_COLORS[spot.weakness]
        shares[spot.weakness] += int(cells.sum())
    cell_area = environment.grid.cell_size**2
    rule = (Swatch(RULED, "Region With a Rule"),) if environment.regions else ()
    swatches = [
        Swatch(WEAKNESS_COLORS[weakness], weakness.value, wording.area(n_cells * cell_area))
        for weakness, n_cells in shares.items()
    ]
    listed = tuple(
        (wording.area(spot.floor_area), f"at {wording.place(*spot.position)}") for spot in found.spots[:_LISTED]
    )
    legend = MapLegend(
        title="Weak Spots",
        swatches=(*swatches, Swatch(SOUND, "Sound"), *rule, Swatch(_BLOCKED, "Too Near an Obstacle")),
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


WEAK_SPOTS = FloorMap(
    name="WEAK_SPOTS",
    number=7,
    label="Weak Spots",
    description="Connected areas that the character cannot reach, or passes in fewer ways than a threshold",
    paint_steps=_weak_spot_steps,
    heeds=frozenset({"few_ways"}),
)
