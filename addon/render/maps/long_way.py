"""The long way around: where places nearby take much longer to get to than their distance would say."""

from collections.abc import Generator

import numpy as np

from ....core.embedding.embedding import Embedding
from ....core.evaluation.detours import detours_steps
from ....core.progress import Progress
from .floor_map import FloorMap, MapOptions, PaintedMap
from .times import paint_times

_LIMITS = (1.0, 2.0, 4.0, 8.0)
"""Seconds of detour."""


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    found = yield from detours_steps(embedding)
    known = found.worst[np.isfinite(found.worst)]
    return paint_times(
        embedding,
        options,
        found.worst,
        title="Long Way Around",
        missing="No Goal Nearby",
        limits=_LIMITS if options.bands else (),
        numbers=(("Median", f"{np.median(known):.1f} s"),),
        report=f"The worst detour to a goal nearby takes {known.max():.1f} s, half of them less than "
        f"{np.median(known):.1f} s",
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
