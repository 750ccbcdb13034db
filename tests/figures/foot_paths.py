"""What foot contact clean-up does to a walk: paths, heights and speeds of the feet, a film strip, and a table.

python tests/figures/foot_paths.py FOLDER [--seconds 6]
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from core.embedding.embedding import embed
from core.motion.clip import MotionClip
from core.motion.contacts import foot_joints, joint_contacts
from core.motion.graph import MotionGraph
from core.playback.cleanup import clean_feet
from core.playback.plants import Plant, clip_plants, walk_plants
from core.playback.quality import foot_slide, walk_quality
from core.playback.synthesis import synthesize
from core.playback.walk import Walk, WalkSettings
from core.playback.wandering import wandering_walk_steps
from core.progress import finish
from tests.bench import problems
from tests.core.motion_graphs import recorded_graph, sample_graph

BEFORE, AFTER, PLANT = "#D55E00", "#0072B2", "#E8EEF4"
FILM_STEP = 4


def graphs() -> dict[str, MotionGraph]:
    """The sample character's graph, and the recorded one where the data is at hand."""
    found = {"sample": sample_graph()}
    if (problems.data_folder() / "cmu16").is_dir():
        found["cmu16"] = recorded_graph(problems.data_folder())
    return found


def table_row(name: str, seed: int, walk: Walk, before: MotionClip, after: MotionClip) -> str:
    """Slides (m/s) of the source clips, of the walk, and of the cleaned walk: mean and worst; edits; jumps."""
    graph, plants = walk.embedding.graph, walk_plants(walk)
    source = np.concatenate([foot_slide(clip_plants(c), c.world[1], c.frame_rate) for c in graph.clips])
    slides = [foot_slide(plants, clip.world[1], clip.frame_rate) for clip in (before, after)]
    strict = [strict_slide(walk, clip) for clip in (before, after)]
    report = walk_quality(walk, after)
    figures = [source.mean(), *(f(s) for s in slides for f in (np.mean, np.max)), *strict]
    jump = report.speed_jump.value if report.speed_jump else 0.0
    return "\t".join([name, str(seed), *(f"{figure:.4f}" for figure in figures), f"{jump:.3f}"])


def strict_slide(walk: Walk, clip: MotionClip) -> float:
    """Mean speed (m/s) over the ground of every joint that its clip says is planted, ankles of rolling feet too."""
    graph, feet = walk.embedding.graph, foot_joints(clip.skeleton)
    found = []
    for index, first in zip(walk.segments, walk.node_frames[:-1], strict=True):
        segment = graph.segments[index]
        for joints, planted in zip(feet, joint_contacts(graph.clips[segment.clip]), strict=True):
            on = planted[segment.first : segment.last + 1]
            path = clip.world[1][first : first + segment.n_frames][:, list(joints), :2]
            speed = np.linalg.norm(np.diff(path, axis=0), axis=2) * clip.frame_rate
            found.append(speed[on[1:] & on[:-1]])
    return float(np.concatenate(found).mean())


def draw(name: str, walk: Walk, before: MotionClip, after: MotionClip, seconds: float, file: Path) -> None:
    rate, skeleton = before.frame_rate, before.skeleton
    plants = walk_plants(walk)
    last = min(int(seconds * rate), before.n_frames - 1)
    times = np.arange(last + 1) / rate
    feet = foot_joints(skeleton)
    figure = plt.figure(figsize=(17, 15), constrained_layout=True)
    grid = figure.add_gridspec(4, 2, height_ratios=[1, 1, 2.4, 0.9])
    for side, foot in enumerate(feet):
        heights, speeds = figure.add_subplot(grid[0, side]), figure.add_subplot(grid[1, side])
        for panel in (heights, speeds):
            shade(panel, [plant for plant in plants if plant.side == side], rate, times[-1])
            for seam in walk.node_frames[(walk.node_frames > 0) & (walk.node_frames <= last)]:
                panel.axvline(seam / rate, color="#999999", linewidth=0.8, linestyle=":")
            panel.set_xlim(0, times[-1])
        for clip, colour, label in ((before, BEFORE, "before"), (after, AFTER, "after")):
            for joint, style in zip(foot, ("-", "--"), strict=False):
                position = clip.world[1][: last + 1, joint]
                heights.plot(times, position[:, 2], style, color=colour, label=f"{skeleton.names[joint]} {label}")
                speed = np.linalg.norm(np.diff(position[:, :2], axis=0), axis=1) * rate
                speeds.plot(times[1:], speed, style, color=colour)
        heights.set_ylabel("height (m)")
        heights.legend(fontsize=7, ncol=2)
        heights.set_title(f"{('Left', 'Right')[side]} foot; shaded: planted, dotted: seams")
        speeds.set_ylabel("speed on the ground (m/s)")
        speeds.set_ylim(0, 1.5)
    seen = figure.add_subplot(grid[2, :])
    for clip, colour, width in ((before, BEFORE, 1.0), (after, AFTER, 1.6)):
        for foot in feet:
            path = clip.world[1][: last + 1, foot[-1]]
            seen.plot(path[:, 0], path[:, 1], color=colour, linewidth=width)
    for plant in plants:
        if plant.last <= last:
            centre = after.world[1][plant.first : plant.last + 1, plant.pivots[-1], :2].mean(axis=0)
            seen.plot(*centre, "o", color=AFTER, markersize=4)
    seen.plot(*walk.root_path[: last + 1, :2].T, color="#BBBBBB", linewidth=1)
    seen.set_aspect("equal")
    seen.set_title("Toes from above: before and after; grey: the root's path")
    film(figure.add_subplot(grid[3, :]), before, after, last)
    figure.suptitle(f"{name}: foot contact clean-up")
    figure.savefig(file, dpi=80)
    plt.close(figure)


def shade(panel, plants: list[Plant], rate: float, end: float) -> None:
    for plant in plants:
        if plant.first / rate < end:
            panel.axvspan(plant.first / rate, min(plant.last / rate, end), color=PLANT, zorder=0)


def film(panel, before: MotionClip, after: MotionClip, last: int) -> None:
    """Stick figures side by side, seen from the left of where the character heads."""
    parents = before.skeleton.parents
    for n, frame in enumerate(range(0, min(last, 26 * FILM_STEP), FILM_STEP)):
        x, y, heading = before.ground_path[frame]
        for clip, colour, width in ((before, BEFORE, 0.9), (after, AFTER, 1.3)):
            place = clip.world[1][frame]
            along = (place[:, 0] - x) * np.cos(heading) + (place[:, 1] - y) * np.sin(heading) + 0.75 * n
            for joint in range(1, len(parents)):
                pair = [parents[joint], joint]
                panel.plot(along[pair], place[pair, 2], color=colour, linewidth=width)
    panel.axhline(0, color="#999999", linewidth=0.8)
    panel.set_aspect("equal")
    panel.set_title(f"Every {FILM_STEP}th frame, before and after")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=6.0)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    rows = [
        "graph\tseed\tsource mean\tbefore mean\tbefore worst\tafter mean\tafter worst\tevery planted joint before"
        "\tafter\tspeed jump at seams"
    ]
    for name, graph in graphs().items():
        embedding = embed(graph, problems.room())
        for seed in range(4):
            walk = finish(wandering_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(60.0)))
            before = synthesize(walk)
            after = clean_feet(walk, before).clip
            rows.append(table_row(name, seed, walk, before, after))
            sys.stdout.write(rows[-1] + "\n")
            if seed == 0:
                draw(name, walk, before, after, arguments.seconds, arguments.folder / f"foot_paths_{name}.png")
    (arguments.folder / "foot_paths.tsv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
