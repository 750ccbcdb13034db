"""Weak spots: places that are not reached, or hardly, with the reason."""

from collections.abc import Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.variability import variability_steps
from ...evaluation.weak_spots import Domain, Weakness, WeakSpot, WeakSpots, WeakSpotSettings, weak_spots_steps
from ...evaluation.why_not import REASON_LABELS, Reason
from ...maps.legend import Swatch
from ...maps.reasons import SOUND, WEAKNESS_COLORS
from ...progress import Progress, finish, portion
from ..chart import bars
from ..drawing import Drawing
from ..finding import Contribution, Finding, Questions, Row, Topic
from ..floor_chart import floor_chart
from ..page import Bullets, Figure, Paragraph, Section
from ..quantity import AMOUNT, NATURAL, Options, Quantity, one_of
from ..table import Table, table

#: A place is weak if it has less than this share of the median variability of the places reached.
FEW_WAYS_SHARE = 0.02

_LISTED = 6


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    settings = questions.weak_spots
    if settings is None:
        ways = (yield from portion(variability_steps(embedding), 0.0, 0.2)).sum(axis=2)
        usual = float(np.median(ways[ways > 0])) if ways.any() else 0.0
        settings = WeakSpotSettings(threshold=round(FEW_WAYS_SHARE * usual))
    found = yield from portion(weak_spots_steps(embedding, settings), 0.2, 1.0)
    unreached = sum(spot.area for spot in found.spots if spot.weakness is Weakness.UNREACHED)
    said = tuple(spot.describe() for spot in found.spots)
    spots = _table(found)
    return Finding(
        WEAK_SPOTS,
        embedding,
        spots,
        numbers=(
            ("Weak Spots", f"{wording.number(len(found.spots))} ({wording.area(found.area)})"),
            ("Not Reached", wording.area(unreached)),
            ("Few Ways", wording.area(found.area - unreached)),
        ),
        rows=tuple(map(_row, found.spots)),
        sentences=said,
        summary=f"{wording.counted(len(said), 'weak spot')}; the largest: {said[0]}"
        if said
        else "There are no weak spots",
        contribute=lambda: _contribution(embedding, questions, found, settings.threshold, spots),
    )


def _table(found: WeakSpots) -> Table:
    """Build a row for each weak spot, largest first."""
    columns = ("weakness", "area (m2)", "floor (m2)", "x (m)", "y (m)", "heading (rad)", "share of headings")
    columns += ("mean variability", "lowest variability", "reason", "share with this reason")
    rows = []
    for spot in found.spots:
        where = (spot.area, spot.floor_area, *spot.position, spot.heading, spot.heading_share)
        ways = (spot.mean_variability, spot.lowest_variability)
        rows.append((spot.weakness.value, *where, *ways, spot.reason.name.lower(), spot.reason_share))
    return table(columns, rows)


def _row(spot: WeakSpot) -> Row:
    across = max(spot.high[0] - spot.low[0], spot.high[1] - spot.low[1])
    few = spot.weakness is Weakness.FEW_WAYS and spot.reason is Reason.EMBEDDED
    reason = spot.weakness.value if few else REASON_LABELS[spot.reason]
    sentence = spot.describe() + "."
    name, where = wording.area(spot.area), wording.coordinates(*spot.position)
    return Row(name, where, reason, sentence, spot.weakness.name.lower(), spot.position, across)


def _contribution(
    embedding: Embedding, questions: Questions, found: WeakSpots, threshold: int, spots: Table
) -> Contribution:
    colors = np.full((*embedding.shape[:2], 3), SOUND)
    for number, spot in enumerate(found.spots, start=1):
        colors[found.labels == number] = WEAKNESS_COLORS[spot.weakness]
    legend = [
        Swatch(WEAKNESS_COLORS[Weakness.UNREACHED], "not reached"),
        Swatch(WEAKNESS_COLORS[Weakness.FEW_WAYS], "few ways"),
        Swatch(SOUND, "sound"),
    ]
    listed = (found.labels > 0) | embedding.covered().any(axis=2)
    scene = questions.floor_scene(embedding)
    chart = floor_chart(scene, "Weak spots", colors, listed, legend, "not reached, too small to list")
    listed_spots = wording.counted(len(found.spots), "weak spot")
    lead = (
        f"{listed_spots}, {wording.area(found.area)} in all: connected floor that no walk stands on, or that has few "
        f"ways through it, which means a variability under {wording.number(threshold)}, "
        f"{wording.share(FEW_WAYS_SHARE)} of the median of the places reached."
    )
    texts = [f"{spot.describe()}." for spot in found.spots[:_LISTED]] or ["There are no weak spots."]
    if len(found.spots) > _LISTED:
        texts.append(f"... and {wording.counted(len(found.spots) - _LISTED, 'smaller one')}.")
    figure = Figure(chart, "Connected areas of free floor; their reasons are those of most of their headings.")
    return Contribution(
        Section("What is weak?", (Paragraph(lead), Bullets(tuple(texts)), figure)),
        numbers={"weak_spots": len(found.spots), "weak_m2": found.area, "few_ways": threshold},
        tables={"weak_spots": spots},
        maps={"weak_spots": chart},
    )


def _chart(found: Table) -> Drawing:
    places = zip(found.texts(0), found.values(3), found.values(4), strict=True)
    names = [f"{kind.lower()} at {wording.place(x, y)}" for kind, x, y in places]
    return bars("Weak spots", "m²", names, found.values(1))


def _asked(embedding: Embedding, options: Options) -> WeakSpots:
    settings = WeakSpotSettings(
        domain=Domain[options.get("domain", Domain.FLOOR.name).upper()],
        threshold=options.get("threshold", 0),
        min_area=float(options.get("min_area", WeakSpotSettings.min_area)),
    )
    return finish(weak_spots_steps(embedding, settings))


def _largest(found: WeakSpots) -> float:
    return max((spot.area for spot in found.spots), default=0.0)


_OPTIONS = {"min_area": AMOUNT, "threshold": NATURAL, "domain": one_of([domain.name.lower() for domain in Domain])}

WEAK_SPOTS = Topic(
    "WEAK_SPOTS",
    "Weak Spots",
    _find_steps,
    operator="find_weak_spots",
    button="Find Weak Spots",
    help="List the connected areas of free floor that the character cannot reach, or passes in few ways only, with the "
    "reason. A click on one moves the 3D cursor there and lets the viewport look at it",
    settings=("domain", "few_ways", "min_area"),
    columns="Area (m²), Place (m), Reason",
    chart=_chart,
    section="weak_spots",
    quantities={
        "weak_spots": Quantity(
            "connected areas that cannot be reached, or in few ways",
            lambda found: len(found.spots),
            find=_asked,
            options=_OPTIONS,
        ),
        "weak_area": Quantity("floor of weak spots", lambda found: found.area, "m2", find=_asked, options=_OPTIONS),
        "largest_weak_area": Quantity("floor of the largest weak spot", _largest, "m2", find=_asked, options=_OPTIONS),
    },
)
