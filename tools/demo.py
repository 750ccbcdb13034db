"""The whole workflow without a window: python3 dev.py demo [--clips BVH_FOLDER] [--blend FILE] [--out FOLDER].

Calls the operators that the panel's buttons call, then draws pictures and saves the file.
"""

import argparse
import json
import tempfile
import uuid
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from ..addon.bridge.body import add_body, remove_body
from ..addon.bridge.owned import OUTPUT, ensure_collection, find_walk_curve
from ..addon.properties import MapQuantity
from ..addon.render.floor import find_floor
from ..addon.results.store import embedding_of, graph_of, results, walk_of
from ..addon.walks.request import read_motion_request, read_request
from ..core.errors import ClipError, SceneError, StorageError
from ..core.evaluation.floor import floor_cells
from ..core.evaluation.weak_spots import connected_areas
from ..core.files import check_folder, full_path, why, write_files
from ..core.playback.styles import walk_steps
from ..core.playback.walk import Walk
from ..core.playback.walk_motion import motion_steps
from ..core.progress import finish
from ..core.wording import area, counted, number, place, share, time
from .pictures.map_picture import MapScene, draw_map
from .pictures.view_picture import choose_moments, draw_view
from .pictures.viewports import add_camera_and_sun, set_up_viewports

FILES = ("demo.blend", "map.png", "view.png", "report.json")

_FRAME_RATE = 30
_SMALLEST_GAP = 1.0
_TRIED_WALKS = 4
"""Seeds of the sample's walk, of which the one with the fewest defects is shown; the report says so."""


def main(words: list[str], journal, start_seconds: float) -> None:
    options = _parse(words)
    _check(options)
    journal.note("start", "Starting Blender", start_seconds)
    report = run(options, journal)
    write_files(options.out, {"report.json": (json.dumps(report, indent=2) + "\n").encode()})
    _tell(report, options.out)


def _parse(argv: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="dev.py demo", description="Run the whole workflow, windowless.")
    parser.add_argument("--clips", metavar="BVH_FOLDER", type=Path, help="use these motions")
    parser.add_argument("--blend", metavar="FILE", type=Path, help="use this scene and its actions")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=Path("demo"), help="default: demo")
    options = parser.parse_args(argv)
    for name in ("clips", "blend", "out"):
        path = getattr(options, name)
        # Blender resolves relative paths against the open file.
        setattr(options, name, full_path(path) if path else None)
    return options


def _check(options: argparse.Namespace) -> None:
    if options.clips is not None and not options.clips.is_dir():
        raise ClipError(f"There is no folder '{options.clips}'; name one with BVH files in it.")
    if options.clips is not None and not any(path.suffix.lower() == ".bvh" for path in options.clips.iterdir()):
        raise ClipError(f"The folder '{options.clips}' holds no BVH files; name one with motion capture in it.")
    if options.blend is not None and not options.blend.is_file():
        raise SceneError(f"There is no file '{options.blend}'; name a .blend file.")
    make_folder(options.out)
    check_folder(options.out, FILES)


def make_folder(folder: Path) -> None:
    """Make the folder to write to; StorageError if it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"The folder '{folder}' cannot be made: {why(error)}.") from None


def _tell(report: dict, out: Path) -> None:
    total = sum(report["seconds"].values())
    print("", *report["summary"], f"All of it took {total:.0f} s.", sep="\n")
    for name in FILES:
        print(f"  {out / name}")


def run(options: argparse.Namespace, journal) -> dict:
    """Run everything from the first operator to the last file; return the report.

    Raises RuntimeError, as operators do, and MotionGraphError if something is wrong with the input.
    """
    operators, scene = bpy.ops.wayfarer, bpy.context.scene
    if options.blend is not None:
        journal.run("open", f"Opening {options.blend.name}", _open, options.blend)
        scene = bpy.context.scene
    else:
        scene.render.fps = _FRAME_RATE
    if options.clips is not None:
        journal.run("import", f"Importing {options.clips.name}", _import, options.clips)
    elif options.blend is None:
        journal.run("character", "Making the sample character", operators.add_sample_character)
    if options.blend is None:
        journal.run("room", "Making the sample room", operators.add_sample_room)
    else:
        _complete(scene, options.blend.name)
    journal.run("graph", "Building the motion graph", operators.build_motion_graph)
    journal.run("embed", "Embedding it in the scene", operators.embed)
    journal.run("map", "Painting the map", operators.paint_map)
    tried = []
    if options.blend is None:
        tried = journal.run("walk choice", f"Choosing from {_TRIED_WALKS} walks", _choose_walk)
    journal.run("walk", "Walking", operators.random_walk)

    shown = shown_scene()
    with tempfile.TemporaryDirectory() as folder:
        pictures = {name: Path(folder) / name for name in ("map.png", "view.png")}
        journal.run("map picture", "Drawing map.png", _draw_map, pictures["map.png"], shown)
        journal.run("view picture", "Drawing view.png", draw_walk_view, pictures["view.png"], shown)
        write_files(options.out, {name: picture.read_bytes() for name, picture in pictures.items()})
    journal.run("save", "Saving demo.blend", _save, options.out, shown)
    return _report(journal.seconds, tried)


def _complete(scene, file_name: str) -> None:
    """See to it that a user's scene has what the operators need, or say what is missing."""
    settings = scene.wayfarer
    if settings.character is None:
        rigs = [obj for obj in scene.objects if obj.type == "ARMATURE"]
        if len(rigs) != 1:
            raise ClipError(
                f"'{file_name}' does not say which of its {len(rigs)} armatures is the character; open it, choose one "
                "in the Wayfarer tab and save it."
            )
        settings.character = rigs[0]
    # The legend of the picture is that of this map.
    settings.map.quantity = MapQuantity.VARIABILITY.name
    if not settings.clips:
        bpy.ops.wayfarer.refresh_clips()
    if not settings.environment.has_ground:
        raise SceneError(
            f"'{file_name}' has no ground; open it, choose a ground or obstacles in the Wayfarer tab and save it."
        )


@dataclass(frozen=True)
class TriedWalk:
    """A walk that was tried.

    Attributes
    ----------
    seed : int
    defects : float
        As :attr:`core.playback.quality.WalkQuality.defects` counts them, after the feet were held.
    crosses : bool
        It plays what the regions ask for, such as a step over; True if they ask for nothing.
    """

    seed: int
    defects: float
    crosses: bool


def _choose_walk() -> list[TriedWalk]:
    """Walk with some seeds, and choose the best: one that crosses what there is to cross, with the fewest defects."""
    scene = bpy.context.scene
    embedding, request, motion_request = embedding_of(scene), read_request(bpy.context), read_motion_request(scene)
    tried = []
    for seed in range(_TRIED_WALKS):
        walk = finish(walk_steps(embedding, replace(request, seed=seed)))
        tried.append(TriedWalk(seed, finish(motion_steps(walk, motion_request)).after.defects, _crosses(walk)))
    tried.sort(key=lambda found: (not found.crosses, found.defects, found.seed))
    scene.wayfarer.walk.seed = tried[0].seed
    return tried


def _crosses(walk: Walk) -> bool:
    tags, segments = walk.embedding.environment.tags, walk.embedding.graph.segments
    known = tags & {tag for segment in segments for tag in segment.tags}
    return not known or any(known & set(segments[s].tags) for s in set(walk.segments.tolist()))


def _open(path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(path))


def _import(folder) -> None:
    bpy.ops.wayfarer.import_motion(directory=str(folder))


def shown_scene() -> MapScene:
    scene = bpy.context.scene
    settings, found = scene.wayfarer.environment, results(scene)
    grid = embedding_of(scene).environment.grid
    return MapScene(
        floor=cast(bpy.types.Object, find_floor(scene)),
        obstacles=tuple(settings.obstacles.all_objects) if settings.obstacles else (),
        regions=tuple(region.object for region in settings.regions if region.object),
        walk=find_walk_curve(ensure_collection(scene, OUTPUT)),
        low=grid.origin,
        high=(grid.origin[0] + grid.size[0], grid.origin[1] + grid.size[1]),
        ground_height=found.ground_height,
    )


def _draw_map(path, shown: MapScene) -> None:
    found = results(bpy.context.scene)
    summary, highest = found.summary, found.painted.numbers["map_highest"] if found.painted is not None else 0
    notes = [
        f"{counted(summary.clips, 'clip')}, {counted(len(graph_of(bpy.context.scene).segments), 'segment')}",
        f"{counted(summary.nodes, 'node')}, {counted(summary.links, 'link')}",
        f"{share(summary.coverage)} of the free floor covered",
    ]
    draw_map(
        path,
        shown,
        title="Where it can go",
        notes=notes,
        highest=f"up to {number(highest)}",
        regions=_region_words(),
        walk=f"a walk of {time(summary.walk.seconds)}",
    )


def _region_words() -> str:
    """The tag that the regions ask for, if they all ask for the same."""
    rules = {(region.rule, region.tag) for region in bpy.context.scene.wayfarer.environment.regions}
    if len(rules) != 1:
        return "regions with rules"
    rule, tag = rules.pop()
    return {"REQUIRE": f"only '{tag}' motion here", "FORBID": f"no '{tag}' motion here"}.get(
        rule, f"'{tag}' motion here only"
    )


def draw_walk_view(path, shown: MapScene) -> None:
    scene = bpy.context.scene
    walk = walk_of(scene)
    bodies = [child for child in scene.wayfarer.character.children_recursive if child.type == "MESH"]
    own = None
    if not bodies:
        own = add_body(scene.wayfarer.character)
        bodies = [own] if own is not None else []
    rate = scene.render.fps / scene.render.fps_base / walk.embedding.graph.frame_rate
    moments = choose_moments(walk.root_path, _special_frames(walk))
    try:
        draw_view(path, shown, bodies, [scene.frame_start + round(moment * rate) for moment in moments])
    finally:
        if own is not None:
            remove_body(own)


def _special_frames(walk) -> np.ndarray:
    """(F,) bool: frames that carry a tag that some region speaks of."""
    tags = walk.embedding.environment.tags
    frames = np.zeros(len(walk.root_path), dtype=bool)
    for i, segment in enumerate(walk.segments):
        for tag, mask in walk.embedding.graph.segments[segment].tags.items():
            if tag in tags:
                frames[walk.node_frames[i] : walk.node_frames[i + 1] + 1] |= mask
    return frames


def _save(out: Path, shown: MapScene) -> None:
    scene = bpy.context.scene
    set_up_viewports(shown)
    add_camera_and_sun(scene, shown)
    # The walk at its own pace, even where the viewport is slow.
    scene.sync_mode = "FRAME_DROP"
    bpy.context.preferences.filepaths.save_version = 0
    # In the same folder, which relative paths begin from.
    path = out / f".writing-{uuid.uuid4().hex}.blend"
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, copy=True)
        write_files(out, {"demo.blend": path.read_bytes()})
    finally:
        path.unlink(missing_ok=True)


def _report(seconds: dict[str, float], tried: list[TriedWalk]) -> dict:
    scene = bpy.context.scene
    summary, graph = results(scene).summary, graph_of(scene)
    gaps = _gaps(embedding_of(scene))
    return {
        "summary": _sentences(scene, tried, gaps),
        "clips": summary.clips,
        "segments": len(graph.segments),
        "graph_links": len(graph.links),
        "nodes": summary.nodes,
        "links": summary.links,
        "coverage": round(summary.coverage, 4),
        "walk_seconds": round(summary.walk.seconds, 2),
        "walk_metres": round(summary.walk.length, 2),
        "walk_seed": scene.wayfarer.walk.seed,
        "walks_tried": [{"seed": walk.seed, "defects_per_minute": round(walk.defects, 2)} for walk in tried],
        "seconds": {step: round(value, 2) for step, value in seconds.items()},
        "not_covered": gaps,
        "dropped": [
            {"clip": dropped.clip, "seconds": round(dropped.seconds, 2), "reason": dropped.reason}
            for dropped in graph.dropped
        ],
    }


def _sentences(scene, tried: list[TriedWalk], gaps: list[dict]) -> list[str]:
    """The demo's outcome for people."""
    summary, graph = results(scene).summary, graph_of(scene)
    said = [
        f"{counted(len(graph.segments), 'segment')} and {counted(len(graph.links), 'link')} from "
        f"{counted(summary.clips, 'clip')} became {counted(summary.nodes, 'node')} and "
        f"{counted(summary.links, 'link')}.",
        f"The character can be in {share(summary.coverage)} of the free floor; it walks for "
        f"{time(summary.walk.seconds)}.",
    ]
    if tried:
        said.append(f"Of {counted(len(tried), 'walk')} that were tried, the one with the fewest defects is shown.")
    for gap in gaps:
        where = place(gap["x"], gap["y"])
        said.append(f"It cannot get to {area(gap['square_metres'])} of free floor around {where}.")
    return said


def _gaps(embedding) -> list[dict]:
    """Free floor that the character cannot get to, in connected pieces of a square metre or more, largest first."""
    grid = embedding.environment.grid
    missed = floor_cells(embedding) & ~embedding.covered().any(axis=2)
    gaps = []
    for cells in connected_areas(missed, grid.tiled):
        size = cells.shape[1] * grid.cell_size**2
        if size >= _SMALLEST_GAP:
            x, y = grid.positions(cells.T).mean(axis=0)
            gaps.append({"square_metres": round(size, 2), "x": round(float(x), 2), "y": round(float(y), 2)})
    return sorted(gaps, key=lambda gap: -gap["square_metres"])
