"""Maps of times: the quicker, the lighter."""

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from .colors import scaled_colors
from .floor_map import MapOptions, PaintedMap, place_swatches
from .legend import ColorBar, MapLegend, Swatch

_TICKS = (0.0, 0.5, 1.0)
_PERCENTILE = 99.0
"""Of the times, at which the continuous scale ends, so that a few far corners do not make all else look alike."""


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
    """The map of (nx, ny) ``seconds``, not finite where there is no time.

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
