"""Studies from Blender: reads .blend files into arrays, then leaves the work to a program of its own.

``blender --background --command wayfarer study FILE.toml``, or ``python3 dev.py study FILE.toml``. The open file is
replaced. What has been read lies in the study's folder with the state of the files that it came from, and is not read
again while they stay as they are.
"""

import argparse
import contextlib
import hashlib
import json
import logging
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from fnmatch import fnmatchcase
from functools import partial
from inspect import getfile
from pathlib import Path

import bpy
import numpy as np
import scipy

from ...core.errors import ClipError, MotionGraphError, StudyError
from ...core.files import check_folder, from_json, full_path, read_regular, remove_files, write_files
from ...core.progress import finish
from ...core.study.clip_set import ClipSet, clip_set_to_bytes
from ...core.study.geometry import SceneGeometry, scene_to_bytes
from ...core.study.plan import Source, StudyPlan, read_plan
from ...core.study.sources import CLIPS, SCENES, check_study_folder, problem_file, read_file
from ...core.study.version import core_version, source_digest
from ..scene.inputs import graph_settings, prepared_clips_steps, read_character, read_shapes, scene_regions
from .scene import choose_character, find_scene, open_blend

_PROGRAM = Path(__file__).resolve().parent / "cluster.py"
PROCESSES = "processes"
"""Where the work is done unless told otherwise."""

_STATES = "read/states.json"

LARGEST_BLEND = 2**40
"""Bytes of a .blend file that is compared with what it was: any."""

_PATIENCE = 20
"""Seconds that the program has to end when it is stopped."""


def add_study_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command ``study``."""
    parser.add_argument("file", metavar="FILE.toml", type=Path, help="scenes, clip sets, settings and measures")
    parser.add_argument("--out", metavar="FOLDER", type=Path, help="default: beside the file, with its name")
    add_place_options(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress on standard error")


def add_place_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say where the work is done."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        default=PROCESSES,
        help="of a Dask scheduler; 'local' is a Dask cluster on this machine, 'processes' does without Dask; "
        f"default: {PROCESSES}",
    )
    parser.add_argument(
        "--workers", metavar="N", type=int, help="processes on this machine; default: one for each core"
    )


def run_study(options: argparse.Namespace, out) -> int:
    """Read what a study needs, run it, and return its exit code; ``out`` is the file for what was asked for.

    Raises StudyError if it cannot begin.
    """
    file = full_path(options.file)
    words = program_words(options)
    plan = read_plan(file)
    folder = full_path(options.out or file.with_name(f"{file.stem}-study"))
    check_study_folder(folder)
    read_sources(plan, folder, (lambda line: None) if options.quiet else partial(print, file=sys.stderr, flush=True))
    return run_program(file, folder, *words, out=out)


def program_words(options: argparse.Namespace) -> list[str]:
    """Return where the work runs, in words for :mod:`.cluster`; StudyError if nobody is to do it."""
    if options.workers is not None and options.workers < 1:
        raise StudyError(f"{options.workers} workers cannot do anything; say --workers 1 or more.")
    words = ["--scheduler", options.scheduler]
    words += ["--workers", str(options.workers)] if options.workers else []
    return words + (["--quiet"] if options.quiet else [])


def run_program(file: Path, folder: Path, *words: str, out=None) -> int:
    """Run a study for which everything has been read; returns the exit code of :mod:`.cluster`.

    ``out`` is the file for what it tells in the end, standard error by default.
    """
    words = (str(file), "--out", str(folder), *words)
    # Blender finds NumPy and SciPy in folders that its bare Python may not know. The current folder is none of them:
    # what lies in it must not be taken for a module, here or in workers.
    places = dict.fromkeys(str(Path(getfile(module)).resolve().parents[1]) for module in (np, scipy))
    known = [*places, *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(place for place in known if os.path.isabs(place)),
        "PYTHONSAFEPATH": "1",
    }
    command = [sys.executable, "-P", str(_PROGRAM), *words]
    with subprocess.Popen(command, stdout=out or 2, env=environment) as process, stops_with(process):
        try:
            return process.wait()
        except KeyboardInterrupt:
            # It was told, too, and says what there is to say when its workers have ended.
            with contextlib.suppress(KeyboardInterrupt, subprocess.TimeoutExpired):
                process.wait(_PATIENCE)
            process.kill()
            return 130


@contextlib.contextmanager
def stops_with(process: subprocess.Popen):
    """Hand on SIGTERM to a program, which then ends its workers and says so by its exit code."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, lambda *_: process.terminate())
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def read_sources(plan: StudyPlan, folder: Path, tell: Callable[[str], None]) -> None:
    """Read the .blend files of a study into arrays in its folder, but for what was read before and has not changed.

    What cannot be read leaves a sentence there, and the study goes on without it; the next start tries again.
    """
    states = _known_states(folder)
    wanted = [(SCENES, source) for source in plan.scenes] + [(CLIPS, source) for source in plan.clip_sets]
    for kind, source in wanted:
        if not source.is_blend:
            continue
        name = f"{kind}/{source.name}"
        asked = [str(source.file), source.scene, source.character, list(source.actions)]
        # Another version may read other things.
        asked += [core_version(), source_digest(Path(__file__).resolve().parent)]
        known = states.get(name) if read_file(folder, kind, source).exists() else None
        if known and known["asked"] == asked and known["files"] == _states([entry[0] for entry in known["files"]]):
            continue
        check_folder(folder, (_inside(folder, place(folder, kind, source)) for place in (read_file, problem_file)))
        tell(f"Reading {source.name} from {source.file.name}")
        libraries = _read(kind, source, folder, tell)
        states[name] = {"asked": asked, "files": _states([str(source.file), *libraries])}
        write_files(folder, {_STATES: json.dumps(states).encode()})


def _known_states(folder: Path) -> dict:
    """Return what was read before, and from which files; empty if nothing was."""
    with contextlib.suppress(OSError, ValueError, LookupError, TypeError, AttributeError):
        states = from_json(read_regular(folder / _STATES))
        return {
            name: {"asked": known["asked"], "files": [[str(file), *seen] for file, *seen in known["files"]]}
            for name, known in states.items()
        }
    return {}


def _states(files: list[str]) -> list[list]:
    """Return paths of files, with their times of last change and digests: the time alone can stay the same."""
    found = []
    for file in files:
        try:
            digest = hashlib.sha256(read_regular(file, LARGEST_BLEND)).hexdigest()
            found.append([file, os.stat(file).st_mtime_ns, digest])
        except OSError:
            found.append([file, 0, ""])
    return found


def _inside(folder: Path, path: Path) -> str:
    return path.relative_to(folder).as_posix()


def _read(kind: str, source: Source, folder: Path, tell: Callable[[str], None]) -> list[str]:
    """Read one source into its file, or the reason why that failed into another; returns the libraries it links to."""
    file, problem = read_file(folder, kind, source), problem_file(folder, kind, source)
    remove_files(folder, [_inside(folder, file), _inside(folder, problem)])
    try:
        # Opened anew for every source: another one may have chosen other clips.
        open_blend(full_path(source.file))
        scene = find_scene(source.scene or None)
        with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
            if kind == SCENES:
                raw = scene_to_bytes(scene_geometry(scene))
            else:
                raw = clip_set_to_bytes(clip_set(scene, source, tell))
    except MotionGraphError as error:
        write_files(folder, {_inside(folder, problem): str(error).encode()})
    except Exception:
        # Whatever is wrong with one file, the others can still be studied.
        logging.getLogger(__name__).exception("A source of the study cannot be read.")
        said = (
            f"'{source.file.name}' cannot be read, for a reason that was not foreseen; please report what the log says."
        )
        write_files(folder, {_inside(folder, problem): said.encode()})
    else:
        write_files(folder, {_inside(folder, file): raw})
    return [bpy.path.abspath(library.filepath) for library in bpy.data.libraries]


def scene_geometry(scene) -> SceneGeometry:
    """Return the meshes of a scene, and its settings; SceneError if that makes no ground."""
    settings = scene.wayfarer.environment
    shapes = read_shapes(scene, bpy.context.evaluated_depsgraph_get())
    return SceneGeometry(
        obstacles=shapes.obstacles,
        low=shapes.low,
        high=shapes.high,
        ground=None if shapes.ground is None else shapes.ground.triangles(),
        regions=tuple(scene_regions(scene, shapes)),
        body=settings.to_core(shapes.ground_height),
        footprint=scene.wayfarer.embedding.to_core().footprint,
        cell_size=settings.cell_size,
        n_headings=settings.n_headings,
        tiled=settings.tiled,
    )


def clip_set(scene, source: Source, tell: Callable[[str], None]) -> ClipSet:
    """Return the clips of a scene's character for its motion graph; ``tell`` hears of those that cannot be read.

    Raises ClipError if there are none, SceneError if there is no character.
    """
    settings = scene.wayfarer
    choose_character(scene, source.character or None, 'write character = "NAME"')
    if source.actions or source.character or not settings.clips:
        settings.refresh_clips()
    if source.actions:
        for clip in settings.clips:
            clip.use = any(fnmatchcase(clip.action.name, pattern) for pattern in source.actions)
    clips, problems = read_character(scene)
    if not clips:
        name, reason = problems[0]
        raise ClipError(f"No action of '{settings.character.name}' can be used. '{name}': {reason}")
    for name, reason in problems:
        tell(f"Left out '{name}': {reason}")
    graph = settings.graph
    prepared = finish(prepared_clips_steps(clips, graph.steady_heading, graph.mirror_clips))
    return ClipSet(tuple(prepared), graph_settings(scene))
