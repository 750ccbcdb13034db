"""What is weak? Places that are not reached or hardly, the long way around, and turns to one side only."""

from collections.abc import Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.detours import detours_steps
from ...evaluation.turn_balance import turn_balance
from ...evaluation.variability import variability_steps
from ...evaluation.weak_spots import Weakness, WeakSpotSettings, weak_spots_steps
from ...progress import Progress, portion
from ..chart import Swatch
from ..finding_tables import weak_spots_table
from ..floor_chart import balance_chart, band_chart, floor_chart
from ..page import Block, Bullets, Figure, FigureRow, Paragraph, Section
from .contribution import Contribution, Questions

#: A place is weak if it has less than this share of the median variability of the places reached.
FEW_WAYS_SHARE = 0.02

#: Seconds of detour that are told apart.
DETOURS = (2.0, 4.0, 6.0, 8.0, 12.0)

_LISTED = 6
# sRGB, apart for everybody: vermilion and yellow of Okabe and Ito's palette on light and dark grey.
_COLORS = {Weakness.UNREACHED: (0.84, 0.37, 0.00), Weakness.FEW_WAYS: (0.94, 0.89, 0.26)}
_SOUND = (0.72, 0.72, 0.71)


def weak_spots_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Weak spots with reasons."""
    ways = (yield from portion(variability_steps(embedding), 0.0, 0.2)).sum(axis=2)
    usual = float(np.median(ways[ways > 0])) if ways.any() else 0.0
    settings = WeakSpotSettings(threshold=round(FEW_WAYS_SHARE * usual))
    found = yield from portion(weak_spots_steps(embedding, settings), 0.2, 1.0)
    colors = np.full((*ways.shape, 3), _SOUND)
    for number, spot in enumerate(found.spots, start=1):
        colors[found.labels == number] = _COLORS[spot.weakness]
    legend = [
        Swatch(_COLORS[Weakness.UNREACHED], "not reached"),
        Swatch(_COLORS[Weakness.FEW_WAYS], "few ways"),
        Swatch(_SOUND, "sound"),
    ]
    listed = (found.labels > 0) | (ways > 0)
    scene = questions.floor_scene(embedding)
    chart = floor_chart(scene, "Weak spots", colors, listed, legend, "not reached, too small to list")
    spots = weak_spots_table(found)
    listed_spots = wording.counted(len(found.spots), "weak spot")
    lead = (
        f"{listed_spots}, {wording.area(found.area)} in all: connected floor that no walk stands on, or that has few "
        f"ways through it, which means a variability under {wording.number(settings.threshold)}, "
        f"{wording.share(FEW_WAYS_SHARE)} of the median of the places reached."
    )
    texts = [f"{spot.describe()}." for spot in found.spots[:_LISTED]] or ["There are no weak spots."]
    if len(found.spots) > _LISTED:
        texts.append(f"... and {wording.counted(len(found.spots) - _LISTED, 'smaller one')}.")
    figure = Figure(chart, "Connected areas of free floor; their reasons are those of most of their headings.")
    return Contribution(
        Section("What is weak?", (Paragraph(lead), Bullets(tuple(texts)), figure)),
        numbers={"weak_spots": len(found.spots), "weak_m2": found.area, "few_ways": settings.threshold},
        tables={"weak_spots": spots},
        maps={"weak_spots": chart},
    )


def detours_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """The long way around."""
    found = yield from detours_steps(embedding, spacing=1.0 if questions.thorough else 1.5)
    chart = band_chart(
        questions.floor_scene(embedding), "The long way around", found.worst, DETOURS, "no place nearby was tried"
    )
    caption = (
        "Seconds by which the quickest walk takes longer than the shortest way at the mean speed of the clips, to the "
        "worst place nearby."
    )
    known = found.n_near > 0
    blocks: tuple[Block, ...] = (Paragraph(found.describe()), Figure(chart, caption))
    return Contribution(
        Section("Where does it go the long way around?", blocks),
        numbers={
            "detour_mean_s": float(found.mean[known].mean()),
            "detour_worst_s": float(found.worst[known].max()),
            "detour_goals": len(found.goals),
        },
        maps={"detours": chart},
    )


def turns_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Left against right."""
    yield Progress(0.0, "Counting turns")
    found = turn_balance(embedding)
    chart = balance_chart(questions.floor_scene(embedding), "Turn balance", found.balance, "right", "left")
    caption = "Angles that the links starting at a place turn by: orange where they turn right, blue where left."
    return Contribution(
        Section("Does it turn both ways?", (Paragraph(found.describe()), FigureRow((Figure(chart, caption),)))),
        numbers={
            "turn_balance": found.total,
            "links_left": found.n_left,
            "links_right": found.n_right,
            "links_straight": found.n_straight,
        },
        maps={"turn_balance": chart},
    )
