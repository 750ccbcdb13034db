"""In how many ways the character can pass: variability, of all headings or of one (paper, Figs. 1 and 7)."""

from collections.abc import Generator

from ..embedding.embedding import Embedding
from ..evaluation.variability import heading_variability, variability_steps
from ..progress import Progress
from .amounts import paint_amounts
from .floor_map import FloorMap, MapOptions, PaintedMap, heading_words


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    heading = options.heading_index(embedding)
    if heading is None:
        values = (yield from variability_steps(embedding)).sum(axis=2)
    else:
        yield Progress(0.0, "Counting ways")
        values = heading_variability(embedding, heading)
    title = f"Variability{heading_words(embedding, heading)}"
    return paint_amounts(embedding, options, values, title, "way", "Cannot Go Here")


MAPS = (
    FloorMap(
        name="VARIABILITY",
        number=0,
        label="Variability",
        description="In how many ways the character can pass through a cell",
        paint_steps=_steps,
        heeds=frozenset({"palette", "heading"}),
    ),
)
