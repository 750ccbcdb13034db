"""How long it takes to get to what is asked for in the panel Queries, or from there (paper, section 4.1.2, Fig. 8)."""

from collections.abc import Generator

from .. import wording
from ..embedding.embedding import Embedding
from ..evaluation.query import Query, query_steps
from ..evaluation.reach import ReachField
from ..progress import Progress
from .floor_map import FloorMap, MapOptions, PaintedMap
from .times import paint_times

NAME = "QUERY"


def _steps(embedding: Embedding, options: MapOptions) -> Generator[Progress, None, PaintedMap]:
    field = yield from query_steps(embedding, options.query)
    return paint_query(field, options)


def paint_query(field: ReachField, options: MapOptions) -> PaintedMap:
    """The map of times that have been found already."""
    query: Query = options.query
    areas = field.areas(query.times)
    within = tuple(
        (f"Within {wording.exact(time)} s", wording.area(area)) for time, area in zip(query.times, areas, strict=True)
    )
    return paint_times(
        field.embedding,
        options,
        field.floor(),
        title=query.title,
        missing="Cannot Get Here" if query.forwards else "Cannot Come From Here",
        limits=query.times if options.bands else (),
        numbers=within,
        report=f"{query.title}: {wording.area(areas[0])} within {wording.exact(query.times[0])} s, "
        f"{wording.area(areas[-1])} within {wording.exact(query.times[-1])} s",
    )


MAPS = (
    FloorMap(
        name=NAME,
        number=8,
        label="Query",
        description="How long it takes to get to what the panel Queries asks for, or from there, in the best heading",
        paint_steps=_steps,
        heeds=frozenset({"palette", "bands", "query"}),
    ),
)
