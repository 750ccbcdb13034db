"""The command line: ``blender scene.blend --background --command wayfarer evaluate|walk|report|export|study ...``.

The same through the bpy module: ``python3 dev.py command scene.blend -- evaluate ...``. Standard output holds nothing
but what was asked for; progress and whatever Blender has to say go to standard error (in Blender itself from the moment
the command starts; say --quiet for what comes before). Nothing is saved unless ``--out`` says where. Exit codes: 0 if
all went well, 1 with a sentence if something is wrong with the scene, 2 for a wrong command line, 130 after Ctrl-C; of
a study 3 if some of its cases failed, 143 after SIGTERM.
"""

import argparse
import contextlib
import json
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import MotionGraphError, SceneError, StorageError, StudyError
from ...core.evaluation.variability import variability_steps
from ...core.files import check_alone, check_folder, full_path, why, write_alone, write_files
from ...core.playback.styles import STYLES, walk_steps
from ...core.playback.walk_motion import motion_steps
from ...core.progress import ProgressLines, finish
from ...core.report.scene_report import report_files
from ..exports.engine import engine_folder_steps, write_engine_folder
from ..exports.report import scene_report_steps
from ..results.advice import embedding_advice, start_advice
from ..results.file import take_saved
from ..results.staleness import embedding_is_stale, graph_is_stale
from ..results.store import embedding_of, graph_of, results
from ..results.workflow import build_graph_steps, embed_scene_steps, keep_built, keep_embedded
from ..walks.baking import bake_motion
from ..walks.request import read_motion_request, read_request
from .large_ground import evaluate_in_parcels
from .output import clean_output, embedding_numbers, graph_numbers, summary_lines, warnings
from .scene import apply_override, choose_character, find_scene, open_blend
from .study import PROCESSES, add_place_options, add_study_options, program_words, run_study

NAME = "wayfarer"


class Ended(Exception):
    """A program that did the work has told why there is nothing to show; its exit code."""

    def __init__(self, code: int):
        self.code = code


# ----------------------------------------------------------------------------------------------- commands


def evaluate(options: argparse.Namespace, scene) -> dict:
    """Measure how well the character gets around in the scene."""
    if options.parcels is not None:
        return _evaluate_in_parcels(options, scene)
    if options.workers is not None or options.scheduler != PROCESSES:
        raise StudyError("Only a ground in parcels has workers; say --parcels METRES, too.")
    _embed(options, scene)
    embedding = embedding_of(scene)
    ways = finish(variability_steps(embedding), options.progress).sum(axis=2)
    covered = ways[ways > 0]
    return {
        "variability": {
            "total": int(ways.sum()),
            "mean": float(covered.mean()) if covered.size else 0.0,
            "median": float(np.median(covered)) if covered.size else 0.0,
            "highest": int(ways.max()),
        }
    }


def _evaluate_in_parcels(options: argparse.Namespace, scene) -> dict:
    """Evaluate a ground that is too large for one process."""
    if options.out is None:
        raise StudyError("A ground in parcels needs a folder to work in; say --out FOLDER.")
    words = program_words(options)
    _build_graph(options, scene)
    folder, options.out = full_path(options.out), None
    found = evaluate_in_parcels(scene, graph_of(scene), options.parcels, folder, *words)
    if isinstance(found, int):
        # It has said why.
        raise Ended(found)
    return found


def walk(options: argparse.Namespace, scene) -> dict:
    """Let the character walk, and bake the walk into an action."""
    settings = scene.wayfarer.walk
    if options.duration is not None:
        settings.duration = options.duration
    if options.seed is not None:
        settings.seed = options.seed
    if options.to:
        settings.style, settings.target = "PLACE", "CURSOR"
        scene.cursor.location.xy = options.to
        settings.walk_on = options.duration is not None
    if options.within is not None:
        settings.nearness = options.within
    _embed(options, scene)
    embedding = embedding_of(scene)
    if embedding.n_nodes == 0:
        raise SceneError(embedding_advice(scene)[0] + ".")
    request = read_request(bpy.context)
    if options.start:
        request = replace(request, start=tuple(options.start))
    made = finish(walk_steps(embedding, request), options.progress)
    closed = STYLES[request.style].closed
    steps = motion_steps(made, read_motion_request(scene, closed=closed))
    action = bake_motion(scene, finish(steps, options.progress))
    path = made.root_path
    advice = start_advice(request.start, made)
    return {
        "advice": [advice] if advice else [],
        "walk": {
            "action": action.name,
            "seconds": made.duration,
            "metres": results(scene).summary.walk.length,
            "segments": len(made),
            "from": path[0, :2].tolist(),
            "to": path[-1, :2].tolist(),
            "frames": [scene.frame_start, scene.frame_end],
        },
    }


def report(options: argparse.Namespace, scene) -> dict:
    """Write the report of the scene."""
    _embed(options, scene)
    if embedding_of(scene).n_nodes == 0:
        raise SceneError(embedding_advice(scene)[0] + ".")
    folder = full_path(options.folder)
    check_folder(folder, ["report.html"])
    files = report_files(finish(scene_report_steps(scene, options.thorough), options.progress))
    write_files(folder, files)
    return {"report": {"folder": str(folder), "files": list(files)}}


def export(options: argparse.Namespace, scene) -> dict:
    """Write the embedding and the clips for engines."""
    _embed(options, scene)
    folder = full_path(options.folder)
    steps = engine_folder_steps(scene, embedding_of(scene), folder, not options.no_clips, not options.no_table)
    files = finish(steps, options.progress)
    write_engine_folder(folder, files)
    return {"export": {"folder": str(folder), "files": list(files)}}


def _build_graph(options: argparse.Namespace, scene) -> None:
    """The motion graph that the scene asks for now; one that was saved with it is used if it fits."""
    settings = scene.wayfarer
    if settings.character is not None and not settings.clips:
        settings.refresh_clips()
    if not settings.environment.has_ground:
        raise SceneError(
            "The scene has no ground; choose a ground or obstacles in the Wayfarer tab, or with --set ground=OBJECT."
        )
    if results(scene).graph is None or graph_is_stale(scene):
        keep_built(scene, built := finish(build_graph_steps(scene), options.progress))
        for name, reason in built.problems:
            options.progress.say(f"Left out '{name}': {reason}")


def _embed(options: argparse.Namespace, scene) -> None:
    """Motion graph and embedding as the scene asks for now; those that were saved with it are used if they fit."""
    _build_graph(options, scene)
    if results(scene).embedding is None or embedding_is_stale(scene):
        steps = embed_scene_steps(scene, bpy.context.evaluated_depsgraph_get())
        keep_embedded(scene, finish(steps, options.progress))


# ------------------------------------------------------------------------------------------- command line


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=NAME,
        description="Where can the character go in this scene, and in how many ways?",
        epilog="Exit codes: 0 if all went well, 1 if something is wrong with the scene, 2 for a wrong command line; of "
        "a study 3 if some of its cases failed.",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--scene", metavar="NAME", help="default: the scene that was open when the file was saved")
    common.add_argument("--character", metavar="NAME", help="armature object; default: the one chosen in the scene")
    common.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        dest="overrides",
        help="another value for a setting, such as cell_size=0.1, environment.radius=0.3, tiled=yes; several times",
    )
    common.add_argument("--json", metavar="FILE", help="write all numbers to this file; - for standard output")
    common.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="save the scene with its results as this .blend; with --parcels, the folder to work in",
    )
    common.add_argument("--quiet", action="store_true", help="no progress on standard error")

    command = commands.add_parser("evaluate", parents=[common], help="coverage, variability, numbers of the embedding")
    command.set_defaults(work=evaluate)
    command.add_argument(
        "--parcels",
        metavar="METRES",
        type=_positive,
        help="embed a ground too large for one process in parcels of this side; start it again to go on",
    )
    add_place_options(command)
    command = commands.add_parser("walk", parents=[common], help="let the character walk, and bake the walk")
    command.set_defaults(work=walk)
    command.add_argument("--duration", metavar="SECONDS", type=_positive, help="how long to walk at least")
    command.add_argument("--seed", metavar="N", type=_natural, help="another number, another walk")
    place = {"metavar": ("X", "Y"), "nargs": 2, "type": _coordinate}
    command.add_argument("--from", **place, dest="start", help="where to start (m); default: anywhere")
    command.add_argument("--to", **place, help="walk there (m) the quickest way; with --duration, wander on")
    command.add_argument("--within", metavar="METRES", type=_positive, help="how near to come with --to")
    command = commands.add_parser("report", parents=[common], help="a page on the scene, with its tables and pictures")
    command.set_defaults(work=report)
    command.add_argument("folder", metavar="FOLDER", type=Path, help="where to write the files")
    command.add_argument("--thorough", action="store_true", help="look at everything, which takes longer")
    command = commands.add_parser("export", parents=[common], help="embedding and clips for engines")
    command.set_defaults(work=export)
    command.add_argument("folder", metavar="FOLDER", type=Path, help="where to write the files")
    command.add_argument("--no-clips", action="store_true", help="only the embedding, without clips.glb")
    command.add_argument("--no-table", action="store_true", help="without the plain table of nodes and links")
    command = commands.add_parser("study", help="many scenes, clip sets and settings, on all cores or on a cluster")
    add_study_options(command)
    return parser


def _positive(text: str) -> float:
    value = _coordinate(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not more than 0")
    return value


def _natural(text: str) -> int:
    if not text.isdecimal() or int(text) > 2**31 - 1:
        raise argparse.ArgumentTypeError(f"'{text}' is no whole number from 0 to {2**31 - 1}")
    return int(text)


def _coordinate(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is no number")
    return value


def run(arguments: list[str], blend: Path | None = None) -> int:
    """Run one command on the open file, or on the file ``blend``; returns the exit code."""
    try:
        with clean_output() as out:
            # Help is asked for, too.
            with contextlib.redirect_stdout(out):
                try:
                    options = _parser().parse_args(arguments)
                finally:
                    out.flush()
            # Operators tell what they have to say through Python's standard output.
            with contextlib.redirect_stdout(sys.stderr):
                return run_study(options, out) if options.command == "study" else _run(options, blend, out)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 2
    except Ended as end:
        return end.code
    except KeyboardInterrupt:
        print(f"{NAME}: stopped.", file=sys.stderr, flush=True)
        return 130
    except MotionGraphError as error:
        sentence = str(error)
    except OSError as error:
        # Neither a disk that is full nor a pipe says which file it was.
        sentence = f"'{error.filename or 'The answer'}' cannot be written: {why(error)}."
    with contextlib.suppress(OSError):
        print(f"{NAME}: {sentence}", file=sys.stderr, flush=True)
    return 1


def _run(options: argparse.Namespace, blend: Path | None, out) -> int:
    # "Reading walk", "Reading turn" are one phase.
    write = None if options.quiet else sys.stderr.write
    options.progress = ProgressLines(write, lambda progress: progress.message.partition(" ")[0])
    started = time.perf_counter()
    _check_places(options)
    if blend is not None:
        open_blend(blend)
    # Without a window, no timer does it.
    take_saved()
    scene = find_scene(options.scene)
    with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
        _prepare(options, scene)
        special = options.work(options, scene)
        # A ground in parcels has no embedding in Blender.
        whole = {} if "embedding" in special else embedding_numbers(scene)
        numbers = {"command": options.command, **graph_numbers(scene), **whole, **special}
        numbers["warnings"] = warnings(scene, bool(whole)) + [f"{said}." for said in numbers.pop("advice", ())]
        if options.out is not None:
            numbers["saved"] = _save(options.out)
    numbers["seconds"] = round(time.perf_counter() - started, 3)
    text = json.dumps(numbers, default=float)
    if options.json == "-":
        print(text, file=out, flush=True)
    else:
        if options.json is not None:
            write_alone(Path(options.json), json.loads(text))
        print("\n".join(summary_lines(numbers)), file=out, flush=True)
    for warning in numbers["warnings"]:
        print(f"Warning: {warning}", file=sys.stderr, flush=True)
    return 0


def _prepare(options: argparse.Namespace, scene) -> None:
    """Choose the character and change the settings as told to."""
    choose_character(scene, options.character)
    for override in options.overrides:
        problem = apply_override(scene.wayfarer, override)
        if problem:
            raise SceneError(problem)


def _check_places(options: argparse.Namespace) -> None:
    """Before the work, which may take long: StorageError if its results could not be written."""
    if options.json not in (None, "-") and not full_path(options.json).parent.is_dir():
        raise StorageError(f"'{options.json}' cannot be written: there is no such folder; make it first.")
    if options.json not in (None, "-"):
        check_alone(Path(options.json))
    if options.out is None or getattr(options, "parcels", None) is not None:
        return
    path = full_path(options.out)
    if path.suffix != ".blend":
        raise StorageError(f"'{path}' is no .blend file; give --out a name that ends in .blend.")
    if not path.parent.is_dir():
        raise StorageError(f"There is no folder '{path.parent}' to save in; make it first.")


def _save(path: Path) -> str:
    path = full_path(path)
    try:
        # A copy: relative paths follow, and what is open stays what it was.
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    except RuntimeError as error:
        raise StorageError(
            f"'{path}' cannot be saved; see that the disk has room, and that you may write to the folder."
        ) from error
    return str(path)


_handle = None


def register():
    global _handle
    _handle = bpy.utils.register_cli_command(NAME, run)


def unregister():
    global _handle
    bpy.utils.unregister_cli_command(_handle)
    _handle = None
