"""Section 5 of the paper with our own code: python3 dev.py reproduce [--clips BVH_FOLDER] [--out FOLDER] [--quick]."""

import argparse
import json
import os
import tempfile
from pathlib import Path

import bpy

from ...core.errors import ClipError
from ...core.files import check_folder, full_path, write_files
from ...core.report.drawing import svg
from ...core.report.page import Figure, FigureRow, Paragraph, Section, html_page
from ...core.report.table import plain, table
from ...core.report.topics import CAPTURE, IMPORTANCE, METRICS
from ..demo import draw_walk_view, make_folder, shown_scene
from .beyond import SHORT, WHOLE, compare_scenes, examine, sections_of
from .chapter import PAPER, Chapter, Comparison
from .cost import measure_cost
from .footprint_growth import draw_footprint_growth
from .graphs import describe_graphs, make_graphs
from .other_scenes import draw_crowds, draw_halls, draw_tile
from .room import draw_rooms
from .stage import Coarseness, bring_clips, open_place
from .tuning import draw_global_pruning, draw_headings, draw_local_pruning, draw_times


def main(words: list[str], journal, start_seconds: float) -> None:
    options = _parse(words)
    _check(options)
    journal.note("start", "Starting Blender", start_seconds)
    report = run(options, journal)
    print(f"\n{'':<62}{'the paper':<34}ours")
    for row in report["comparisons"]:
        print(f"{row['what']:<62}{row['paper']:<34}{row['ours']}")
    print(f"\nAll of it took {sum(journal.seconds.values()):.0f} s.\n  {options.out / 'report.html'}")


def _parse(argv: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="dev.py reproduce", description="The paper's section 5 with our own code.")
    parser.add_argument(
        "--clips",
        metavar="BVH_FOLDER",
        type=Path,
        help="use these motions; default: the recorded ones where they are at hand (WAYFARER_DATA), otherwise the "
        "sample character",
    )
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=Path("reproduce"), help="default: reproduce")
    parser.add_argument(
        "--quick", action="store_true", help="the sample character unless --clips is given, on coarse grids"
    )
    options = parser.parse_args(argv)
    if options.clips is None and not options.quick:
        options.clips = _recorded()
    # Blender resolves relative paths against the open file.
    options.clips = full_path(options.clips) if options.clips else None
    options.out = full_path(options.out)
    return options


def _recorded() -> Path | None:
    """The folder of recorded motions that are alike the paper's, if they are at hand."""
    beside = Path(__file__).resolve().parents[3] / "shared" / "data"
    folder = Path(os.environ.get("WAYFARER_DATA", beside)) / "cmu16"
    return folder if folder.is_dir() else None


def _check(options: argparse.Namespace) -> None:
    if options.clips is not None and not options.clips.is_dir():
        raise ClipError(f"There is no folder '{options.clips}'; name one with BVH files in it.")
    make_folder(options.out)
    check_folder(options.out, ["report.html", "report.json", "view.png"])


def run(options: argparse.Namespace, journal) -> dict:
    """Run everything; return what went into report.json.

    Raises RuntimeError, as operators do, and MotionGraphError if something is wrong with the input.
    """
    quick, out = options.quick, options.out
    coarse = Coarseness(2.0, 12) if quick else Coarseness()
    step = journal.run
    clips, trimmed = step("clips", "Bringing the clips", bring_clips, options.clips, quick)
    graphs, tried = step(
        "graphs", "Building motion graphs", make_graphs, clips, *([(0.12, 0.3), (0.5,)] if quick else [])
    )
    places = {}
    for key in ("ROOM", "TWO_STEPS", "S_HALL", "TILE", "STEP_ROOM"):
        places[key] = step("scenes", f"Reading {key.lower()}", open_place, key, coarse)

    parts = {"motion_graph": describe_graphs(graphs, tried, trimmed)}
    rooms, parts["room"] = step("room", "Fig. 1: the room", draw_rooms, graphs, places["STEP_ROOM"], places["ROOM"])
    parts["growth"] = step("growth", "Fig. 4: footprint growth", draw_footprint_growth, *([2000] if quick else []))
    parts["local"] = step("local", "Fig. 5: local pruning", draw_local_pruning, rooms)
    parts["global"] = step("global", "Fig. 6: global pruning", draw_global_pruning, rooms)
    parts["headings"] = step("headings", "Fig. 7: single headings", draw_headings, rooms)
    parts["times"] = step("times", "Fig. 8: time to reach", draw_times, rooms)
    tile, parts["tile"] = step("tile", "Fig. 9: a tile", draw_tile, places["TILE"], graphs.best)
    halls, parts["halls"] = step(
        "halls", "Fig. 10: other halls", draw_halls, places["S_HALL"], places["TWO_STEPS"], graphs.best
    )
    sides = (1, 2) if quick else (1, 2, 3, 4, 5, 6)
    parts["cost"] = step("cost", "Cost", measure_cost, graphs, places["ROOM"], places["TILE"], sides)

    scenes = {
        "step_room": (places["STEP_ROOM"], rooms.embedding),
        "s_hall": (places["S_HALL"], halls["s_hall"]),
        "two_steps": (places["TWO_STEPS"], halls["two_steps"]),
        "tile": (places["TILE"], tile),
    }
    reports = {}
    for name, (place, embedding) in scenes.items():
        if quick and name in halls:
            continue
        whole = name == "step_room" and not quick
        topics = WHOLE if whole else SHORT | {IMPORTANCE} if name == "step_room" else SHORT
        label = f"Examining {place.layout.label.lower()}"
        reports[name] = step("examine", label, examine, place, embedding, out / name, topics, whole)
    parts["scenes"] = compare_scenes(reports)
    crowded = {name: scenes[name] for name in ("step_room", "tile")}
    parts["crowds"] = step("crowds", "Crowds", draw_crowds, crowded, 6 if quick else 12, 5.0 if quick else 10.0)

    pictures = {}
    if not quick:
        pictures["view"] = step("view", "Drawing the room in perspective", _draw_view)
    more = sections_of(reports["step_room"], (IMPORTANCE, CAPTURE, METRICS))
    report = {
        "paper": PAPER,
        "clips": str(options.clips) if options.clips else "sample character",
        "quick": quick,
        "comparisons": [vars(comparison) for part in parts.values() for comparison in part.comparisons],
        **{name: part.numbers for name, part in parts.items()},
    }
    step("write", "Writing figures and report", _write, out, parts, more, pictures, report, options)
    return report


def _draw_view() -> bytes:
    """The room with the step as the add-on shows it: operators of the panel, then its own picture in perspective."""
    operators, settings = bpy.ops.wayfarer, bpy.context.scene.wayfarer
    settings.walk.duration = 40.0
    for name in ("build_motion_graph", "embed", "paint_map", "random_walk"):
        getattr(operators, name)()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "view.png"
        draw_walk_view(path, shown_scene())
        return path.read_bytes()


def _write(out: Path, parts: dict[str, Chapter], more: list[Section], pictures: dict, report: dict, options) -> None:
    charts = {name: chart for part in parts.values() for name, chart in part.figures.items()}
    page = html_page(_TITLE, _lead(options), _sections(parts, more, pictures))
    files = {
        **{f"{name}.svg": svg(chart).encode() for name, chart in charts.items()},
        **{f"{name}.png": picture for name, picture in pictures.items()},
        "report.html": page.encode(),
        "report.json": (json.dumps(report, indent=2, default=_plain) + "\n").encode(),
    }
    write_files(out, files)


_TITLE = "Evaluating and tuning motion graphs: the paper reproduced"


def _lead(options: argparse.Namespace) -> str:
    motion = f"the motions of {options.clips.name}" if options.clips else "the sample character"
    quick = (
        " A quick run: coarser grids than the paper's, so that counts are far from its numbers."
        if options.quick
        else ""
    )
    return (
        f"Section 5 of {PAPER}, with our own code and {motion}. No count was tuned to fit: where a number differs, the "
        f"table says why.{quick}"
    )


def _sections(parts: dict[str, Chapter], more: list[Section], pictures: dict[str, bytes]) -> list[Section]:
    comparisons: list[Comparison] = [c for part in parts.values() for c in part.comparisons]
    overview = table(
        ["what", "the paper", "ours", "a word on the difference"],
        [[c.what, c.paper, c.ours, c.why] for c in comparisons],
    )
    sections = [Section("The paper's numbers and ours", (overview,))]
    for name, part in parts.items():
        blocks = part.section.blocks
        if name == "room" and "view" in pictures:
            caption = "The same room as the add-on shows it, with the character at several moments of a walk."
            blocks = (*blocks, FigureRow((Figure(pictures["view"], caption),)))
        sections.append(Section(part.section.title, blocks))
    note = Paragraph("Each scene's own report, with tables and maps as files, lies in a folder of its name.")
    return [*sections, *more, Section("Files", (note,))]


def _plain(value):
    """Convert NumPy's numbers, which json does not know."""
    return plain(value)
