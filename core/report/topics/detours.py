"""Long ways around: delays of ways to places nearby."""

from collections.abc import Generator

from ...embedding.embedding import Embedding
from ...evaluation.detours import Detours, detours_steps, mean_speed
from ...progress import Progress, finish
from ..finding import Contribution, Finding, Questions, Topic
from ..floor_chart import band_chart
from ..page import Figure, Paragraph, Section
from ..quantity import LENGTH, Options, Quantity

#: Seconds of detour that have a colour of their own.
DETOUR_TIMES = (2.0, 4.0, 6.0, 8.0, 12.0)


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    found = yield from detours_steps(embedding, spacing=1.0 if questions.thorough else 1.5)
    return Finding(
        DETOURS,
        embedding,
        sentences=(found.describe(),),
        contribute=lambda: _contribution(embedding, questions, found),
    )


def _contribution(embedding: Embedding, questions: Questions, found: Detours) -> Contribution:
    scene = questions.floor_scene(embedding)
    chart = band_chart(scene, "The long way around", found.worst, DETOUR_TIMES, "no place nearby was tried")
    caption = (
        "Seconds by which the quickest walk takes longer than the shortest way at the mean speed of the clips, to the "
        "worst place nearby."
    )
    return Contribution(
        Section("Where does it go the long way around?", (Paragraph(found.describe()), Figure(chart, caption))),
        numbers={
            "detour_mean_s": _mean(found),
            "detour_worst_s": _worst(found),
            "detour_goals": len(found.goals),
        },
        maps={"detours": chart},
    )


def _mean(found: Detours) -> float:
    return float(found.mean[found.n_near > 0].mean())


def _worst(found: Detours) -> float:
    return float(found.worst[found.n_near > 0].max())


def _asked(embedding: Embedding, options: Options) -> Detours:
    return finish(detours_steps(embedding, float(options.get("spacing", 1.0))))


_SPACING = {"spacing": LENGTH}

DETOURS = Topic(
    "DETOURS",
    "Long Way Around",
    _find_steps,
    section="detours",
    effort=30,
    quantities={
        "speed": Quantity(
            "mean speed over all segments, one after the other",
            float,
            "m/s",
            find=lambda embedding, _: mean_speed(embedding.graph),
        ),
        "detour": Quantity("delay of ways to places nearby, mean", _mean, "s", find=_asked, options=_SPACING),
        "worst_detour": Quantity("delay of ways to places nearby, longest", _worst, "s", find=_asked, options=_SPACING),
    },
)
