"""One case of a study: what comes of a scene, a motion graph and settings."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..embedding.embedding import Embedding, embed
from ..embedding.settings import EmbeddingSettings
from ..errors import MotionGraphError
from ..motion.graph import MotionGraph
from ..progress import finish
from ..tuning.local_pruning import prune_local_steps
from .geometry import SceneGeometry, environment_of
from .measures import Measure, measured
from .picture import SmallMap, map_from_json, map_to_json, small_map
from .settings import Value, footprint_settings
from .subject import Subject, WholeGround


@dataclass(frozen=True)
class CaseResult:
    """Result of a case.

    Attributes
    ----------
    numbers : mapping of str to int, float or None
        By the names of the measures; None where a question has no answer.
    remarks : tuple of str
        Why there is none.
    picture : SmallMap
    seconds : float
        That it took, without what an earlier case had left at hand.
    """

    numbers: Mapping[str, int | float | None]
    remarks: tuple[str, ...]
    picture: SmallMap
    seconds: float

    def to_json(self) -> dict[str, Any]:
        return {
            "numbers": dict(self.numbers),
            "remarks": list(self.remarks),
            "picture": map_to_json(self.picture),
            "seconds": self.seconds,
        }


def result_from_json(found: Mapping[str, Any]) -> CaseResult:
    """Read the result of :meth:`CaseResult.to_json`; ValueError or another exception if it is damaged."""
    numbers = {str(name): value for name, value in found["numbers"].items()}
    if not all(value is None or isinstance(value, int | float) for value in numbers.values()):
        raise ValueError
    remarks = tuple(map(str, found["remarks"]))
    return CaseResult(numbers, remarks, map_from_json(found["picture"]), float(found["seconds"]))


def embedding_settings(geometry: SceneGeometry, values: Mapping[str, Value]) -> EmbeddingSettings:
    """Return the settings of an embedding with the values of a case."""
    return EmbeddingSettings(footprint_settings(geometry.footprint, values))


def embed_case(geometry: SceneGeometry, graph: MotionGraph, values: Mapping[str, Value]) -> Embedding:
    """Embed a case without pruning it; k makes no difference.

    Raises SceneError or EmbeddingError if there is none.
    """
    return embed(graph, environment_of(geometry, values), embedding_settings(geometry, values))


def pruned(embedding: Embedding, values: Mapping[str, Value]) -> Embedding:
    """Prune to the k best nodes at each place, if the case says so."""
    k = int(values.get("k", 0))
    return finish(prune_local_steps(embedding, k)) if k > 0 else embedding


def measure_subject(
    subject: Subject, measures: Sequence[Measure]
) -> tuple[dict[str, int | float | None], tuple[str, ...]]:
    """Return numbers by the names of the measures, and remarks on those that have none."""
    numbers: dict[str, int | float | None] = {}
    remarks = []
    for measure in measures:
        try:
            value = measured(measure, subject)
            numbers[measure.name] = value if math.isfinite(value) else None
            if not math.isfinite(value):
                remarks.append(f"{measure.name}: never")
        except MotionGraphError as error:
            numbers[measure.name] = None
            remarks.append(f"{measure.name}: {error}")
    return numbers, tuple(remarks)


def case_result(embedding: Embedding, values: Mapping[str, Value], measures: Sequence[Measure]) -> CaseResult:
    """Prune and measure the embedding of :func:`embed_case`."""
    start = time.perf_counter()
    subject = WholeGround(pruned(embedding, values))
    return CaseResult(*measure_subject(subject, measures), small_map(subject), time.perf_counter() - start)
