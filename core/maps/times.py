"""Maps of times, the quicker the lighter: to a place, of a query, and of detours (paper, section 4.1.2, Fig. 8)."""

from collections.abc import Generator

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.detours import detours_steps
from ..evaluation.goals import goal_at
from ..evaluation.query import query_steps
from ..evaluation.reach import ReachField, round_times, time_to_reach_steps
from ..progress import Progress
from ..wording import counted
from .colors import scaled_colors
from .floor_map import FloorMap, MapOptions, PaintedMap, place_swatches
from .legend import ColorBar, MapLegend, Swatch

_TICKS = (0.0, 0.5, 1.0)
_PERCENTILE = 99.0
"""Percentile of the times at which the continuous scale ends: a few far corners do not make all else look alike."""

GOAL_RADIUS = 0.25
"""Metres around the goal within which the character has arrived."""

_DETOURS = (1.0, 2.0, 4.0, 8.0)
"""Steps in seconds in which detours are shown."""


def paint_times(
    embedding: Embedding,
    options: MapOptions,
    seconds: np.ndarray,
    title: str,
    missing: str,
    limits: tuple[float, ...] = (),
    numbers: tuple[tuple[str, str], ...] = (),
    report: str = "",
) -> PaintedMap:
    """Paint (nx, ny) ``seconds``, not finite where there is no time.

    With ``limits`` (s, ascending) in as many steps, and one more for what takes longer; on a scale otherwise, of which
    times below zero lie at the light end. ``missing`` says what no time means.
    """
    scale, present = options.scale, np.isfinite(seconds)
    known = np.where(present, seconds, 0.0)
    swatches, bar = place_swatches(scale, embedding, missing), None
    if limits:
        # A hair, because times are whole frames in single precision.
        share = 1 - np.searchsorted(np.array(limits) + 1e-3, known) / len(limits)
        colors = scale.colors(1 - np.arange(len(limits) + 1) / len(limits)).tolist()
        names = [*(f"Up to {wording.exact(limit)} s" for limit in limits), "Longer"]
        swatches = (*(Swatch(tuple(c), name) for c, name in zip(colors, names, strict=True)), *swatches)
    else:
        end = max(float(np.percentile(seconds[present], _PERCENTILE)), 1e-3) if present.any() else 1.0
        share = 1 - np.clip(known / end, 0.0, 1.0)
        ticks = [(at, wording.short(round(at * end, 1))) for at in _TICKS]
        if present.any() and seconds[present].max() > end:
            ticks[-1] = (1.0, f"{ticks[-1][1]}+")
        bar = ColorBar(scale.stops[::-1], tuple(ticks))
    longest = float(seconds[present].max(initial=0.0))
    return PaintedMap(
        colors=scaled_colors(share, present, embedding, scale),
        legend=MapLegend(
            title, "seconds" if bar else "", bar, swatches, (*numbers, ("Longest", wording.time(longest)))
        ),
        numbers={"map_longest": longest, "map_cells": int(present.sum())},
        report=report,
    )


def _within(times, areas) -> tuple[tuple[str, str], ...]:
    """Return rows "Within 2 s", "12 m²" for a legend."""
    return tuple(
        (f"Within {wording.exact(time)} s", wording.area(area)) for time, area in zip(times, areas, strict=True)
    )


def _reach_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Find the times from everywhere to the goal."""
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
        numbers=_within(times, areas),
        report=f"The goal is reached within {wording.exact(times[0])} s from {wording.area(areas[0])}, within "
        f"{wording.exact(times[-1])} s from {wording.area(areas[-1])}",
    )


REACH = FloorMap(
    name="REACH",
    number=4,
    label="Time to Reach",
    description="How long it takes to get to a place from everywhere, in the best heading",
    paint_steps=_reach_steps,
    heeds=frozenset({"palette", "goal", "bands"}),
)


def _query_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Find the times to what is asked for, or from there."""
    field = yield from query_steps(embedding, options.query)
    return paint_query(field, options)


def paint_query(field: ReachField, options: MapOptions) -> PaintedMap:
    """Paint times that have been found already."""
    query = options.query
    areas = field.areas(query.times)
    return paint_times(
        field.embedding,
        options,
        field.floor(),
        title=query.title,
        missing="Cannot Get Here" if query.forwards else "Cannot Come From Here",
        limits=query.times if options.bands else (),
        numbers=_within(query.times, areas),
        report=f"{query.title}: {wording.area(areas[0])} within {wording.exact(query.times[0])} s, "
        f"{wording.area(areas[-1])} within {wording.exact(query.times[-1])} s",
    )


QUERY = FloorMap(
    name="QUERY",
    number=8,
    label="Query",
    description="How long it takes to get to what the panel Queries asks for, or from there, in the best heading",
    paint_steps=_query_steps,
    heeds=frozenset({"palette", "bands", "query"}),
)


def _detour_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Find how much longer the way to the worst place nearby takes than its distance says."""
    found = yield from detours_steps(embedding)
    known = found.worst[np.isfinite(found.worst)]
    median = float(np.median(known))
    return paint_times(
        embedding,
        options,
        found.worst,
        title="Long Way Around",
        missing="No Goal Nearby",
        limits=_DETOURS if options.bands else (),
        numbers=(("Median", wording.time(median)), ("Goals Tried", wording.number(len(found.goals)))),
        report=f"The longest way around takes {wording.time(float(known.max()))} more than straight there; from half "
        f"of the floor it is less than {wording.time(median)}, to the worst of "
        f"{counted(len(found.goals), 'goal')} tried",
    )


LONG_WAY = FloorMap(
    name="LONG_WAY",
    number=5,
    label="Long Way Around",
    description="By how much longer the quickest walk to the worst place one to two metres away takes than its "
    "distance says",
    paint_steps=_detour_steps,
    heeds=frozenset({"palette", "bands"}),
)
