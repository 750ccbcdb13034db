"""Grounds too large for one process, from Blender: embedded in parcels by a program of its own, and read back.

``blender FILE --background --command wayfarer evaluate --parcels METRES --out FOLDER``. The folder is that of a study
of one case: it holds what was read from the scene, what the workers found so far, and in the end table, page and maps.
"""

import csv
import io
import json
import re
from pathlib import Path

from ...core.errors import StudyError
from ...core.files import read_regular, write_files
from ...core.motion.graph import MotionGraph
from ...core.motion.graph_archive import graph_to_bytes
from ...core.progress import finish
from ...core.study.geometry import SceneGeometry, grid_of, scene_to_bytes
from ...core.study.lock import only_one
from ...core.study.plan import read_plan
from ...core.study.run import run_study_steps
from .study import run_program, scene_geometry

_STUDY = "parcels.toml"
_LOCK = ".evaluate.lock"
"""A file that is locked from before the study is written until it is read; its program has a lock of its own."""

_SOME_FAILED = 3
"""The program's exit code if it has told in its table why there is no result."""

_MEASURES = (
    "nodes",
    "links",
    "coverage",
    "covered_area",
    "free_area",
    "total_variability",
    "variability",
    "median_variability",
    "highest_variability",
)


def evaluate_in_parcels(scene, graph: MotionGraph, parcel_size: float, folder: Path, *words: str) -> dict | int:
    """Embed the scene's motion graph in parcels, and measure; ``words`` are options of the program that does it.

    Started again with the same folder, it goes on where it was. Returns numbers as :func:`.command.evaluate`'s, or the
    program's exit code, if it had to tell why there are none.

    Raises SceneError or StudyError if it cannot begin, StudyError if the ground cannot be embedded.
    """
    if folder.suffix == ".blend" or folder.is_file():
        raise StudyError(f"'{folder}' is no folder; with --parcels, give --out a folder for results and maps.")
    geometry = scene_geometry(scene)
    if any(folder.glob("[!.]*")) and not (folder / _STUDY).exists():
        raise StudyError(f"'{folder}' holds something else; give --out an empty folder, or one to go on in.")
    with only_one(folder, _LOCK):
        # Nor may a program still run whose Blender has gone.
        with only_one(folder):
            _write_study(
                folder, _plain(scene.name), _plain(scene.wayfarer.character.name), geometry, graph, parcel_size
            )
        code = run_program(folder / _STUDY, folder, *words)
        if code == _SOME_FAILED:
            raise StudyError(_problem(folder))
        if code:
            return code
        # The program has finished the only case, so that it is only read.
        outcome = finish(run_study_steps(read_plan(folder / _STUDY), folder)).outcomes[0]
    if outcome.result is None:
        raise StudyError(outcome.problem)
    found = outcome.result.numbers
    grid = grid_of(geometry, {})
    return {
        "embedding": {
            "cells": list(grid.shape[:2]),
            "headings": grid.n_headings,
            "cell_size": grid.cell_size,
            "nodes": found["nodes"],
            "links": found["links"],
        },
        "coverage": {
            "share": found["coverage"],
            "square_metres": found["covered_area"],
            "free_square_metres": found["free_area"],
        },
        "variability": {
            "total": found["total_variability"],
            "mean": found["variability"],
            "median": found["median_variability"],
            "highest": found["highest_variability"],
        },
        "parcels": {
            "folder": str(folder),
            "parcel_size": parcel_size,
            "maps": [str(path.relative_to(folder)) for path in sorted((folder / outcome.maps).glob("*.png"))],
            "seconds": outcome.result.seconds,
        },
    }


def _problem(folder: Path) -> str:
    """Return why the only case failed, as the program reported."""
    text = read_regular(folder / "results.csv").decode()
    return next(csv.DictReader(io.StringIO(text, newline="")))["problem"]


def _plain(name: str) -> str:
    """A name as a study's file may have it."""
    return re.sub(r"[^\w .+-]|^\W", "_", name)


def _quoted(name: str) -> str:
    """A name in TOML, which knows no pairs of surrogates."""
    return json.dumps(name, ensure_ascii=False)


def _write_study(
    folder: Path, name: str, character: str, geometry: SceneGeometry, graph: MotionGraph, parcel_size: float
) -> None:
    """Write the scene as it was read, and the file that says what is to be done with it."""
    lines = [
        "# Written by wayfarer evaluate --parcels: the scene as it was, and what is measured in it.",
        f"title = {_quoted(name)}",
        f"measures = {json.dumps(list(_MEASURES))}",
        f'[scenes]\n{_quoted(name)} = "scene.npz"',
        f'[clips]\n{_quoted(character)} = "graph.npz"',
        f"[settings]\nparcel_size = {parcel_size!r}",
    ]
    files = {
        "scene.npz": scene_to_bytes(geometry),
        "graph.npz": graph_to_bytes(graph),
        _STUDY: ("\n".join(lines) + "\n").encode(),
    }
    write_files(folder, files)
