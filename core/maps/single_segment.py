"""Where one motion segment ends, and in how many ways the walk goes through there (paper, eq. 1)."""

from collections.abc import Generator

from ..embedding.embedding import Embedding
from ..errors import EmbeddingError
from ..evaluation.variability import segment_variability_of
from ..progress import Progress
from .amounts import paint_amounts
from .floor_map import FloorMap, MapOptions, PaintedMap, heading_words


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
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


MAPS = (
    FloorMap(
        name="SEGMENT",
        number=3,
        label="Segment",
        description="Where one segment can end, and in how many ways the walk goes through there",
        paint_steps=_steps,
        heeds=frozenset({"palette", "heading", "segment"}),
    ),
)
