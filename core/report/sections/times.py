"""How soon? Times to a goal (the paper's Fig. 8), and where random walkers spend their time."""

from collections.abc import Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...errors import EvaluationError
from ...evaluation.occupancy import occupancy_steps
from ...evaluation.reach import round_times, time_to_reach_steps
from ...maps.scales import CIVIDIS
from ...progress import Progress
from ..finding_tables import reach_table
from ..floor_chart import amount_chart, band_chart
from ..page import Figure, Paragraph, Section
from .contribution import Contribution, Questions


def times_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Areas from which the goal is reached within some seconds."""
    goal = questions.goal
    if goal is None:
        raise EvaluationError("No goal was given; name one to see from where it is reached how soon.")
    field = yield from time_to_reach_steps(embedding, goal.nodes)
    seconds = field.floor()
    times = round_times(seconds)
    chart = band_chart(
        questions.floor_scene(embedding), f"Time to reach {goal.name}", seconds, times, "no way from here"
    )
    areas, within = field.areas(times), reach_table(field, times)
    covered = np.count_nonzero(embedding.covered().any(axis=2)) * embedding.environment.grid.cell_size**2
    said = "; ".join(
        f"within {wording.exact(time)} s from {wording.area(area)} ({wording.share_of(area, covered)} of the covered "
        "floor)"
        for time, area in zip(times, areas, strict=True)
    )
    longest = wording.time(float(seconds[np.isfinite(seconds)].max(initial=0.0)))
    return Contribution(
        Section(
            f"How soon can it reach {goal.name}?",
            (
                Paragraph(f"Exact shortest times, in the best heading: {said}. From the farthest place: {longest}."),
                Figure(chart, f"The lighter, the sooner {goal.name} is reached."),
            ),
        ),
        numbers={"goal": goal.name, "areas_m2": dict(zip(map(str, times), areas, strict=True))},
        tables={"time_to_reach": within},
        maps={"time_to_reach": chart},
    )


def occupancy_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Where walkers spend their time."""
    found = yield from occupancy_steps(embedding, tolerance=1e-5 if questions.thorough else 1e-4)
    # Counted in the mean, so that the scale, which starts at 1, has something to tell apart.
    times_mean = found.floor * np.count_nonzero(found.floor)
    chart = amount_chart(
        questions.floor_scene(embedding),
        "Where random walkers spend their time",
        times_mean,
        "times the mean",
        "never passed",
        scale=CIVIDIS,
        least="little",
    )
    caption = (
        "Time spent in each cell in the long run, if each link is taken with the same probability, compared to the "
        "mean over all cells that are passed."
    )
    return Contribution(
        Section("Where does it spend its time?", (Paragraph(" ".join(found.describe())), Figure(chart, caption))),
        numbers={
            "half_time_share": found.half_time_share,
            "effective_m2": found.effective_area,
            "hot_spot_m": list(found.hot_spot),
        },
        maps={"occupancy": chart},
    )
