"""How long it takes to get to a place from everywhere (paper, section 4.1.2 and Fig. 8)."""

from collections.abc import Generator

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.goals import goal_at
from ..evaluation.reach import round_times, time_to_reach_steps
from ..progress import Progress
from .floor_map import FloorMap, MapOptions, PaintedMap
from .times import paint_times

GOAL_RADIUS = 0.25
"""Metres around the goal within which the character has arrived."""


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    field = yield from time_to_reach_steps(embedding, goal_at(embedding, options.goal, GOAL_RADIUS))
    seconds = field.floor()
    times = round_times(seconds)
    areas = field.areas(times)
    return paint_times(
        embedding,
        options,
        seconds,
        title="Time to Reach",
        missing="Cannot Come From Here",
        limits=times if options.bands else (),
        numbers=tuple(
            (f"Within {wording.exact(time)} s", wording.area(area)) for time, area in zip(times, areas, strict=True)
        ),
        report=f"The goal is reached within {wording.exact(times[0])} s from {wording.area(areas[0])}, within "
        f"{wording.exact(times[-1])} s from {wording.area(areas[-1])}",
    )


MAPS = (
    FloorMap(
        name="REACH",
        number=4,
        label="Time to Reach",
        description="How long it takes to get to a place from everywhere, in the best heading",
        paint_steps=_steps,
        heeds=frozenset({"palette", "goal", "bands"}),
    ),
)
