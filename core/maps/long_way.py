"""The long way around: where places nearby take much longer to get to than their distance would say."""

from collections.abc import Generator

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.detours import detours_steps
from ..progress import Progress
from ..wording import counted
from .floor_map import FloorMap, MapOptions, PaintedMap
from .times import paint_times

_LIMITS = (1.0, 2.0, 4.0, 8.0)
"""Seconds of detour."""


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    found = yield from detours_steps(embedding)
    known = found.worst[np.isfinite(found.worst)]
    median = float(np.median(known))
    return paint_times(
        embedding,
        options,
        found.worst,
        title="Long Way Around",
        missing="No Goal Nearby",
        limits=_LIMITS if options.bands else (),
        numbers=(("Median", wording.time(median)), ("Goals Tried", wording.number(len(found.goals)))),
        report=f"The longest way around takes {wording.time(float(known.max()))} more than straight there; from half "
        f"of the floor it is less than {wording.time(median)}, to the worst of "
        f"{counted(len(found.goals), 'goal')} tried",
    )


MAPS = (
    FloorMap(
        name="LONG_WAY",
        number=5,
        label="Long Way Around",
        description="By how much longer the quickest walk to the worst place one to two metres away takes than its "
        "distance says",
        paint_steps=_steps,
        heeds=frozenset({"palette", "bands"}),
    ),
)
