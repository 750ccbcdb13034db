"""Where the character can pass: in how many headings, or by how many segments in one heading."""

from collections.abc import Generator

import numpy as np

from ..embedding.embedding import Embedding
from ..evaluation.variability import coverage
from ..progress import Progress
from .amounts import paint_amounts
from .floor_map import FloorMap, MapOptions, PaintedMap, heading_words


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    yield Progress(0.0, "Counting headings")
    heading = options.heading_index(embedding)
    if heading is None:
        values, noun = coverage(embedding).sum(axis=2), "heading"
    else:
        unpack, n_headings = embedding.unrolling.layout.unpack, embedding.shape[2]
        alive = [unpack(plane) for plane in embedding.planes[heading::n_headings]]
        values, noun = np.sum(alive, axis=0, dtype=int), "segment"
    title = f"Coverage{heading_words(embedding, heading)}"
    return paint_amounts(embedding, options, values, title, noun, "Cannot Go Here")


MAPS = (
    FloorMap(
        name="COVERAGE",
        number=1,
        label="Coverage",
        description="In how many headings the character can pass through a cell",
        paint_steps=_steps,
        heeds=frozenset({"palette", "heading"}),
    ),
)
