"""Weak spots as a list of places."""

from collections.abc import Generator

from ....core import wording
from ....core.embedding.embedding import Embedding
from ....core.evaluation.weak_spots import Weakness, WeakSpot, WeakSpotSettings, weak_spots_steps
from ....core.evaluation.why_not import REASON_LABELS, Reason
from ....core.progress import Progress
from ....core.report.finding_tables import weak_spots_table
from .finding import WEAK_SPOTS, Finding, Row

_ICONS = {Weakness.UNREACHED: "CANCEL", Weakness.FEW_WAYS: "ERROR"}


def weak_spots_finding_steps(embedding: Embedding, settings: WeakSpotSettings) -> Generator[Progress, None, Finding]:
    """The weak spots of an embedding, largest first."""
    found = yield from weak_spots_steps(embedding, settings)
    unreached = sum(spot.area for spot in found.spots if spot.weakness is Weakness.UNREACHED)
    return Finding(
        WEAK_SPOTS,
        embedding,
        weak_spots_table(found),
        numbers=(
            ("Weak Spots", f"{wording.number(len(found.spots))} ({wording.area(found.area)})"),
            ("Not Reached", wording.area(unreached)),
            ("Few Ways", wording.area(found.area - unreached)),
        ),
        rows=tuple(_row(spot) for spot in found.spots),
        sentences=tuple(spot.describe() for spot in found.spots),
    )


def _row(spot: WeakSpot) -> Row:
    x, y = spot.position
    across = max(spot.high[0] - spot.low[0], spot.high[1] - spot.low[1])
    few = spot.weakness is Weakness.FEW_WAYS and spot.reason is Reason.EMBEDDED
    reason = spot.weakness.value if few else REASON_LABELS[spot.reason]
    sentence = spot.describe() + "."
    return Row(
        wording.area(spot.area),
        wording.coordinates(x, y),
        reason,
        sentence,
        _ICONS[spot.weakness],
        spot.position,
        across,
    )
