"""Maps of how much of something there is in each cell: variability, coverage, one segment, occupancy."""

from collections.abc import Generator

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..errors import EmbeddingError
from ..evaluation.floor import floor_cells
from ..evaluation.occupancy import occupancy_steps
from ..evaluation.variability import heading_variability, segment_variability_of, variability_steps
from ..progress import Progress
from ..wording import counted
from .colors import lightest_value, lightness, scaled_colors
from .floor_map import FloorMap, MapOptions, PaintedMap, heading_words, place_swatches
from .legend import ColorBar, MapLegend

_TICKS = (0.0, 0.5, 1.0)


def paint_amounts(
    embedding: Embedding, options: MapOptions, values: np.ndarray, title: str, noun: str, unreached: str
) -> PaintedMap:
    """Paint (nx, ny) integer ``values``, 0 where there is none; ``noun`` is what is counted, in the singular.

    The scale ends at the 99th percentile and grows with the square root: few ways can be told from none, and a single
    busy cell does not darken all others.
    """
    scale, lightest = options.scale, lightest_value(values)
    present = values > 0
    highest, n_cells = int(values.max(initial=0)), int(present.sum())
    n_floor = int(floor_cells(embedding).sum())
    ticks = tuple((at, wording.short(max(round(lightest * at**2), 1))) for at in _TICKS)
    if highest > lightest:
        ticks = (*ticks[:-1], (1.0, f"{ticks[-1][1]}+"))
    legend = MapLegend(
        title=title,
        unit=f"{noun}s",
        bar=ColorBar(scale.stops, ticks),
        swatches=place_swatches(scale, embedding, unreached),
        numbers=(("Cells Covered", wording.number(n_cells)), ("Most in a Cell", counted(highest, noun))),
    )
    return PaintedMap(
        colors=scaled_colors(lightness(values, lightest), present, embedding, scale),
        legend=legend,
        numbers={"map_highest": highest, "map_cells": n_cells},
        report=f"{title}: {wording.number(n_cells)} of {counted(n_floor, 'cell')} of free floor, up to "
        f"{counted(highest, noun)} in a cell",
    )


def _variability_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Count the ways through each cell, in all headings or in one (paper, Figs. 1 and 7)."""
    heading = options.heading_index(embedding)
    if heading is None:
        values = (yield from variability_steps(embedding)).sum(axis=2)
    else:
        yield Progress(0.0, "Counting ways")
        values = heading_variability(embedding, heading)
    title = f"Variability{heading_words(embedding, heading)}"
    return paint_amounts(embedding, options, values, title, "way", "Cannot Go Here")


VARIABILITY = FloorMap(
    name="VARIABILITY",
    number=0,
    label="Variability",
    description="In how many ways the character can pass through a cell",
    paint_steps=_variability_steps,
    heeds=frozenset({"palette", "heading"}),
)


def _coverage_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Count the headings in which a cell can be passed, or the segments in one heading."""
    yield Progress(0.0, "Counting headings")
    heading = options.heading_index(embedding)
    if heading is None:
        values, noun = embedding.covered().sum(axis=2), "heading"
    else:
        unpack, n_headings = embedding.unrolling.layout.unpack, embedding.shape[2]
        alive = [unpack(plane) for plane in embedding.planes[heading::n_headings]]
        values, noun = np.sum(alive, axis=0, dtype=int), "segment"
    title = f"Coverage{heading_words(embedding, heading)}"
    return paint_amounts(embedding, options, values, title, noun, "Cannot Go Here")


COVERAGE = FloorMap(
    name="COVERAGE",
    number=1,
    label="Coverage",
    description="In how many headings the character can pass through a cell",
    paint_steps=_coverage_steps,
    heeds=frozenset({"palette", "heading"}),
)


def _segment_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Count the ways through the ends of one segment (paper, eq. 1)."""
    yield Progress(0.0, "Counting ways")
    segments = embedding.graph.segments
    chosen = next((i for i, segment in enumerate(segments) if segment.name == options.segment), None)
    if chosen is None and options.segment:
        raise EmbeddingError(
            f"The motion graph has no segment '{options.segment}'; choose one of its {len(segments)} segments."
        )
    ways = segment_variability_of(embedding, chosen or 0)
    heading = options.heading_index(embedding)
    values = ways.sum(axis=2) if heading is None else ways[:, :, heading]
    title = f"{segments[chosen or 0].name}{heading_words(embedding, heading)}"
    return paint_amounts(embedding, options, values, title, "way", "Does Not End Here")


SEGMENT = FloorMap(
    name="SEGMENT",
    number=3,
    label="Segment",
    description="Where one segment can end, and in how many ways the walk goes through there",
    paint_steps=_segment_steps,
    heeds=frozenset({"palette", "heading", "segment"}),
)


def _occupancy_steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    """Find the share of time that random walkers spend in each cell."""
    found = yield from occupancy_steps(embedding)
    share, scale = found.floor, options.scale
    present = share > 0
    # Counted in millionths: the scale ends at 1 at least, and cells are small.
    end = lightest_value(1e6 * share) / 1e6
    highest = f"{wording.share(float(share.max()) / found.cell_area)} for each m²"
    ticks = [(at, wording.short(100 * end * at**2 / found.cell_area)) for at in (0.0, 0.5, 1.0)]
    if share.max() > end:
        ticks[-1] = (1.0, f"{ticks[-1][1]}+")
    legend = MapLegend(
        title="Occupancy",
        unit="% of time per m²",
        bar=ColorBar(scale.stops, tuple(ticks)),
        swatches=place_swatches(scale, embedding, "Never Passed"),
        numbers=(("Busiest Place", wording.place(*found.hot_spot)), ("Time There", highest)),
    )
    return PaintedMap(
        colors=scaled_colors(lightness(share, end), present, embedding, scale),
        legend=legend,
        numbers={"map_highest": float(found.floor.max()), "map_cells": int(np.count_nonzero(present))},
        report=f"Random walkers spend most time around {wording.place(*found.hot_spot)}: {highest}",
    )


OCCUPANCY = FloorMap(
    name="OCCUPANCY",
    number=6,
    label="Occupancy",
    description="Where walkers that take every link with the same probability spend their time",
    paint_steps=_occupancy_steps,
    heeds=frozenset({"palette"}),
)
