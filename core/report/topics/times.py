"""Times to a goal, or from it (the paper's section 4.1.2 and Fig. 8)."""

from collections.abc import Callable, Generator, Sequence

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...embedding.node_set import NodeSet
from ...errors import EvaluationError
from ...evaluation.goals import facing, goal_after, goal_at, goal_in_region, goal_with_tag
from ...evaluation.query import Query
from ...evaluation.reach import ReachField, round_times, time_from_steps, time_to_reach_steps
from ...evaluation.segment_groups import segments_of_clip
from ...progress import Progress, finish
from ..chart import bars
from ..drawing import Drawing
from ..finding import Contribution, Finding, Questions, Topic
from ..floor_chart import band_chart
from ..page import Figure, Paragraph, Section
from ..quantity import AMOUNT, ANGLE, POSITION, TEXT, Options, Quantity
from ..table import Table, table


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    goal = questions.goal
    if goal is None:
        raise EvaluationError("No goal was given; name one to see from where it is reached how soon.")
    field = yield from time_to_reach_steps(embedding, goal.nodes)
    times = round_times(field.floor())
    return _finding(field, f"Time to {goal.name}", times, lambda: _contribution(questions, field, goal.name, times))


def reach_finding(field: ReachField, query: Query) -> Finding:
    """Answer a query: the areas (m2) within each of its times, and the longest time."""
    return _finding(field, query.title, query.times)


def _finding(
    field: ReachField, title: str, times: Sequence[float], contribute: Callable[[], Contribution] | None = None
) -> Finding:
    found = _areas(field, times)
    rows = zip(*(found.values(column) for column in range(3)), strict=True)
    numbers = [
        (f"Within {wording.exact(time)} s", f"{wording.area(area)} ({wording.share(share)})")
        for time, area, share in rows
    ]
    numbers.append(("Longest", wording.time(_longest(field))))
    return Finding(REACH, field.embedding, found, tuple(numbers), sentences=(title,), contribute=contribute)


def _areas(field: ReachField, times: Sequence[float]) -> Table:
    """Tabulate the area within each of some times (s), and its share of the covered floor."""
    covered = _covered_area(field.embedding)
    areas = field.areas(times)
    rows = [(time, area, area / covered if covered else 0.0) for time, area in zip(times, areas, strict=True)]
    return table(("time (s)", "area (m2)", "share of the covered floor"), rows)


def _covered_area(embedding: Embedding) -> float:
    return float(np.count_nonzero(embedding.covered().any(axis=2)) * embedding.environment.grid.cell_size**2)


def _longest(field: ReachField) -> float:
    seconds = field.floor()
    return float(seconds[np.isfinite(seconds)].max(initial=0.0))


def _contribution(questions: Questions, field: ReachField, goal: str, times: tuple[float, ...]) -> Contribution:
    scene, covered, areas = questions.floor_scene(field.embedding), _covered_area(field.embedding), field.areas(times)
    chart = band_chart(scene, f"Time to reach {goal}", field.floor(), times, "no way from here")
    said = "; ".join(
        f"within {wording.exact(time)} s from {wording.area(area)} ({wording.share_of(area, covered)} of the covered "
        "floor)"
        for time, area in zip(times, areas, strict=True)
    )
    longest = wording.time(_longest(field))
    return Contribution(
        Section(
            f"How soon can it reach {goal}?",
            (
                Paragraph(f"Exact shortest times, in the best heading: {said}. From the farthest place: {longest}."),
                Figure(chart, f"The lighter, the sooner {goal} is reached."),
            ),
        ),
        numbers={"goal": goal, "areas_m2": dict(zip(map(str, times), areas, strict=True))},
        tables={"time_to_reach": _areas(field, times)},
        maps={"time_to_reach": chart},
    )


def _chart(found: Table) -> Drawing:
    return bars("Floor within reach", "m²", [f"{wording.exact(time)} s" for time in found.values(0)], found.values(1))


# -------------------------------------------------------------------------------------------------- quantities


def _goal(embedding: Embedding, options: Options) -> NodeSet:
    if "region" in options:
        goal = goal_in_region(embedding, options["region"])
    elif "tag" in options:
        goal = goal_with_tag(embedding, options["tag"])
    elif "clip" in options:
        clip = options["clip"]
        goal = goal_after(embedding, segments_of_clip(embedding.graph, clip), f"the clip '{clip}'")
    else:
        x, y = map(float, options["position"])
        goal = goal_at(embedding, (x, y), float(options.get("radius", 0.0)))
    if "heading" in options:
        goal = facing(embedding, goal, float(options["heading"]), float(options.get("tolerance", 0.0)))
    return goal


def _times_to(embedding: Embedding, options: Options) -> ReachField:
    return finish(time_to_reach_steps(embedding, _goal(embedding, options)))


def _times_from(embedding: Embedding, options: Options) -> ReachField:
    return finish(time_from_steps(embedding, _goal(embedding, options)))


def _mean_time(field: ReachField) -> float:
    counts = field.histogram()
    return float(counts @ np.arange(len(counts))) / counts.sum() / field.frame_rate


def _worst_time(field: ReachField) -> float:
    return (len(field.histogram()) - 1) / field.frame_rate


def _area_within(field: ReachField, time: float = 5.0) -> float:
    return field.area_within(float(time))


_GOAL = {
    "region": TEXT,
    "tag": TEXT,
    "clip": TEXT,
    "position": POSITION,
    "radius": AMOUNT,
    "heading": ANGLE,
    "tolerance": AMOUNT,
}


def _quantity(meaning: str, number: Callable[..., float], unit: str = "s", find=_times_to, **own) -> Quantity:
    return Quantity(
        meaning,
        number,
        unit,
        find,
        options={**_GOAL, **own},
        own=tuple(own),
        one_of=("region", "tag", "clip", "position"),
        details={"radius": "position", "tolerance": "heading"},
    )


REACH = Topic(
    "REACH",
    "Time to Reach",
    _find_steps,
    chart=_chart,
    section="times",
    quantities={
        "time_to_reach": _quantity("time to a goal, mean over all nodes", _mean_time),
        "worst_time_to_reach": _quantity("time to a goal, longest", _worst_time),
        "time_from": _quantity("time from a place, mean over all nodes", _mean_time, find=_times_from),
        "worst_time_from": _quantity("time from a place, longest", _worst_time, find=_times_from),
        "area_within": _quantity(
            "floor from which a goal is reached within a time (5 s if none is given)", _area_within, "m2", time=AMOUNT
        ),
    },
)
