"""Tasks of a study's workers, which read files of a folder that all workers share, and write new ones.

What is wrong with a scene or its clips is returned as a sentence; what is raised concerns the whole study (a full disk)
or is a fault of ours.
"""

import json
import os
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from ..embedding.embedding import Embedding
from ..errors import MotionGraphError, StorageError
from ..files import why, write_whole
from ..motion.graph import MotionGraph, build_motion_graph
from ..motion.graph_archive import graph_to_bytes, load_motion_graph
from ..parcels.embedding import ParcelSummary
from ..parcels.problem import create_problem, open_problem
from .case import CaseResult, case_result, embed_case, embedding_settings, measure_subject
from .clip_set import load_clip_set
from .geometry import SceneGeometry, environment_of, load_scene
from .maps import write_maps
from .measures import Measure
from .picture import small_map
from .settings import Value, graph_settings
from .subject import ParcelledGround
from .version import core_version

#: Written into every case's file; another one is not believed.
CASE_FORMAT = "wayfarer case 1"

#: What every case's file begins with.
CASE_MARK = b'{"format": "wayfarer case '


def end_with(parent: int) -> None:
    """End this process when its parent has ended, however that ended, also if it did before this process began."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    # Windows has launchers of Python between the two, which end with neither.
    if os.name == "posix" or os.getppid() == parent:
        threading.Thread(target=watch, daemon=True).start()


def build_graph(clips: str, values: Mapping[str, Value], out: str) -> str:
    """Cut and link the clips of a file, and write the motion graph; returns what is wrong with them, or nothing."""
    try:
        clip_set = load_clip_set(clips)
        graph = build_motion_graph(clip_set.clips, graph_settings(clip_set.settings, values))
    except MotionGraphError as error:
        return str(error)
    write_whole(Path(out), graph_to_bytes(graph))
    return ""


def measure_case(scene: str, graph: str, values: Mapping[str, Value], measures: Sequence[Measure], out: str) -> str:
    """Run a case and write what it came to; returns why it came to nothing, if so."""
    start = time.perf_counter()
    try:
        result = case_result(_embedding(scene, graph, _without_k(values)), values, measures)
    except MotionGraphError as error:
        return str(error)
    write_result(Path(out), replace(result, seconds=time.perf_counter() - start))
    return ""


def lay_out(scene: str, graph: str, values: Mapping[str, Value], folder: str) -> str:
    """Prepare a large ground for :mod:`core.parcels`; returns what is wrong with it, or nothing."""
    try:
        geometry = _scene(scene)
        environment, settings = environment_of(geometry, values), embedding_settings(geometry, values)
        if values.get("k"):
            return "A ground in parcels cannot be pruned; leave k or parcel_size out."
        create_problem(Path(folder), _graph(graph), environment, settings, float(values["parcel_size"]))
    except StorageError:
        raise
    except MotionGraphError as error:
        return str(error)
    except OSError as error:
        raise StorageError(f"'{folder}' cannot be written ({why(error)}); free some space and go on.") from None
    return ""


def measure_parcels(
    folder: str, summary: ParcelSummary, measures: Sequence[Measure], seconds: float, maps: str, out: str
) -> str:
    """Measure a ground that was embedded in parcels, and write its maps into the folder ``maps``; returns why that came
    to nothing, if so."""
    start = time.perf_counter()
    try:
        problem = open_problem(folder)
        subject = ParcelledGround(problem, summary)
        write_maps(subject, problem.plan.grid.origin, Path(maps))
        numbers, remarks = measure_subject(subject, measures)
        result = CaseResult(numbers, remarks, small_map(subject), seconds + time.perf_counter() - start)
    except StorageError:
        raise
    except MotionGraphError as error:
        return str(error)
    write_result(Path(out), result)
    return ""


def write_result(path: Path, result: CaseResult) -> None:
    """Write what a case came to, whole or not at all; StorageError if that cannot be done."""
    content = {"format": CASE_FORMAT, "version": core_version(), **result.to_json()}
    write_whole(path, json.dumps(content, default=_plain).encode())


def _plain(number):
    """NumPy's numbers as Python's."""
    return number.item()


def _without_k(values: Mapping[str, Value]) -> tuple[tuple[str, Value], ...]:
    return tuple((name, value) for name, value in values.items() if name != "k")


# Cases that differ in little only follow one another: their worker has at hand what they share.


@lru_cache(maxsize=2)
def _scene(path: str) -> SceneGeometry:
    return load_scene(path)


@lru_cache(maxsize=2)
def _graph(path: str) -> MotionGraph:
    return load_motion_graph(path)


@lru_cache(maxsize=1)
def _embedding(scene: str, graph: str, values: tuple[tuple[str, Value], ...]) -> Embedding:
    return embed_case(_scene(scene), _graph(graph), dict(values))
