"""How soon? Times to a goal (the paper's Fig. 8), and where random walkers spend their time."""

from collections.abc import Generator

from ...embedding.embedding import Embedding
from ...errors import EvaluationError
from ...evaluation.occupancy import occupancy_steps
from ...evaluation.reach import PAPER_TIMES, time_to_reach_steps
from ...progress import Progress
from ..color_scale import CIVIDIS
from ..floor_chart import amount_chart, band_chart
from ..page import Figure, Paragraph, Section
from ..table import table
from .contribution import Contribution, Questions


def times_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Areas from which the goal is reached within some seconds."""
    goal = questions.goal
    if goal is None:
        raise EvaluationError("No goal was given; name one to see from where it is reached how soon.")
    field = yield from time_to_reach_steps(embedding, goal.nodes)
    chart = band_chart(
        questions.floor_scene(embedding), f"Time to reach {goal.name}", field.floor(), PAPER_TIMES, "no way from here"
    )
    areas = field.areas()
    rows = [[time, area] for time, area in zip(PAPER_TIMES, areas, strict=True)]
    within = table(["within (s)", "area (m2)"], rows)
    text = "; ".join(f"within {time:g} s from {area:.1f} m2" for time, area in zip(PAPER_TIMES, areas, strict=True))
    return Contribution(
        Section(
            f"How soon can it reach {goal.name}?",
            (
                Paragraph(f"Exact shortest times, in the best heading: {text}."),
                Figure(chart, f"From where {goal.name} can be reached within 2, 3, 5 and 7 seconds."),
            ),
        ),
        numbers={"goal": goal.name, "areas_m2": dict(zip(map(str, PAPER_TIMES), areas, strict=True))},
        tables={"time_to_reach": within},
        maps={"time_to_reach": chart},
    )


def occupancy_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Where walkers spend their time."""
    found = yield from occupancy_steps(embedding, tolerance=1e-5 if questions.thorough else 1e-3)
    # In millionths, so that the scale, which starts at 1, has something to tell apart.
    chart = amount_chart(
        questions.floor_scene(embedding),
        "Where random walkers spend their time",
        1e6 * found.floor,
        "ppm of the time",
        "never passed",
        scale=CIVIDIS,
    )
    caption = "Share of the time in each cell, in the long run, if each link is taken with the same probability."
    return Contribution(
        Section("Where does it spend its time?", (Paragraph(" ".join(found.describe())), Figure(chart, caption))),
        numbers={
            "half_time_share": found.half_time_share,
            "effective_m2": found.effective_area,
            "hot_spot_m": list(found.hot_spot),
        },
        maps={"occupancy": chart},
    )
