"""Pictures of a motion graph: its costs with cuts and links, its segments, its clips and their planted feet.

python tests/figures/motion_graph.py [--clips FOLDER] [--max-cost COST] [--min-duration SECONDS] --out FOLDER

Writes costs.png, graph.png, clips.png, clips.html and contacts.png. The clips are the BVH files of a folder (CMU's
scale, Y up; a few thousand frames in all), by default the recorded motions of the benchmarks or else the sample
character's.
"""

import argparse
import html
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import PowerNorm
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Patch

from core.motion.contacts import foot_contacts
from core.motion.distance import joined, pose_features
from core.motion.graph import MotionGraph, MotionGraphSettings, build_motion_graph
from core.motion.graph_summary import summarize
from tests.bench import problems
from tests.core.bvh import read_bvh
from tests.core.dense_costs import transition_costs
from tests.core.motion_graphs import DEFECTIVE_FRAMES
from tests.figures.graph_layout import spring_layout

# Okabe and Ito's colours, which the colour-blind can tell apart.
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
GREY = "#9a9a9a"
N_HUBS = 8
N_ZOOMED = 3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clips", type=Path, help="folder of BVH files")
    parser.add_argument("--max-cost", type=float, default=0.12, help="threshold (rad^2)")
    parser.add_argument("--min-duration", type=float, default=0.67, help="of a segment (s)")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    arguments = parser.parse_args()
    if arguments.clips:
        files = sorted(arguments.clips.glob("*.bvh"))
        clips = [read_bvh(file, drop_first=DEFECTIVE_FRAMES.get(file.stem, 0)) for file in files]
    else:
        clips = list(problems.clips())
    settings = MotionGraphSettings(max_cost=arguments.max_cost, min_segment_duration=arguments.min_duration)
    graph = build_motion_graph(clips, settings)
    arguments.out.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"font.size": 10, "axes.titlesize": 12})
    draw_costs(graph, settings, arguments.out / "costs.png")
    draw_graph(graph, arguments.out / "graph.png")
    draw_clips(graph, arguments.out / "clips.png")
    write_clips(graph, arguments.out / "clips.html")
    draw_contacts(graph, settings, arguments.out / "contacts.png")


def draw_costs(graph: MotionGraph, settings: MotionGraphSettings, file: Path) -> None:
    """Every frame against every other, and beside it the clips that share most links, closer up."""
    features = joined([pose_features(clip, settings.cost) for clip in graph.clips])
    costs = transition_costs(features, features)
    lengths = np.array([clip.n_frames for clip in graph.clips])
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    shown = _most_linked_clips(graph)
    chosen = np.concatenate([np.arange(offsets[c], offsets[c + 1]) for c in shown])
    figure, (whole, close) = plt.subplots(1, 2, figsize=(18, 9.4), constrained_layout=True)
    _cost_map(whole, graph, costs, range(len(lengths)), offsets, settings, marker=11)
    image = _cost_map(close, graph, costs[np.ix_(chosen, chosen)], shown, offsets, settings, marker=45)
    title = f"All {len(lengths)} clips, {offsets[-1]:,} frames at {graph.frame_rate:g} per second"
    whole.set_title(title, loc="left", pad=34)
    close.set_title("The clips that share most links, with their cuts", loc="left", pad=34)
    bar = figure.colorbar(image, ax=[whole, close], shrink=0.75, pad=0.01, extend="max")
    bar.set_label("transition cost D (rad²)")
    bar.ax.axhline(settings.max_cost, color=RED, linewidth=2)
    handles = [
        Line2D([], [], color=RED, marker="o", linestyle="", label=f"link (D ≤ {settings.max_cost:g} rad²)"),
        Line2D([], [], color="black", linewidth=0.8, label="border of clips"),
        Line2D([], [], color="black", linewidth=1, linestyle=":", label="cut"),
    ]
    whole.legend(handles=handles, loc="lower right", ncols=3, bbox_to_anchor=(1, 1.03), frameon=False)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _cost_map(axes, graph, costs, shown, offsets, settings, marker):
    """Costs between the frames of some clips; both axes are numbered through these clips."""
    # Square roots, that is to say distances, so that what is beyond the threshold shows its shape, too.
    norm = PowerNorm(0.5, vmin=0, vmax=25 * settings.max_cost)
    image = axes.imshow(costs, cmap="YlGnBu_r", norm=norm, interpolation="nearest", origin="lower")
    lengths = [int(offsets[c + 1] - offsets[c]) for c in shown]
    starts = dict(zip(shown, np.cumsum([0, *lengths[:-1]]).tolist(), strict=True))
    borders = np.cumsum(lengths)[:-1] - 0.5
    for border in borders:
        axes.axhline(border, color="black", linewidth=0.5 if len(lengths) > N_ZOOMED else 1.2)
        axes.axvline(border, color="black", linewidth=0.5 if len(lengths) > N_ZOOMED else 1.2)
    few = len(lengths) <= N_ZOOMED
    cuts = {starts[s.clip] + f for s in graph.segments if s.clip in starts for f in (s.first, s.last)}
    for cut in cuts:
        if few:
            axes.axhline(cut, color="black", linewidth=0.9, linestyle=":")
            axes.axvline(cut, color="black", linewidth=0.9, linestyle=":")
        else:
            axes.plot([cut, cut], [-40, -8], color="black", linewidth=0.7, clip_on=False)
            axes.plot([-40, -8], [cut, cut], color="black", linewidth=0.7, clip_on=False)
    ends = np.array([graph.segments[i].last for i in graph.links[:, 0]])
    begins = np.array([graph.segments[j].first for j in graph.links[:, 1]])
    one = np.array([graph.segments[i].clip for i in graph.links[:, 0]])
    two = np.array([graph.segments[j].clip for j in graph.links[:, 1]])
    inside = np.isin(one, list(shown)) & np.isin(two, list(shown)) & (graph.link_costs > 0)
    x = [starts[c] + f for c, f in zip(two[inside].tolist(), begins[inside].tolist(), strict=True)]
    y = [starts[c] + f for c, f in zip(one[inside].tolist(), ends[inside].tolist(), strict=True)]
    axes.scatter(x, y, s=marker, color=RED, edgecolors="white" if few else "none", linewidths=1, zorder=3)
    total = sum(lengths)
    axes.set_xlim(-0.5 if few else -40, total - 0.5)
    axes.set_ylim(-0.5 if few else -40, total - 0.5)
    middles = [starts[c] + n / 2 for c, n in zip(shown, lengths, strict=True)]
    names = [graph.clips[c].name for c in shown]
    # Names of short neighbours would run into each other.
    step = max(1, round(len(names) / 32))
    axes.set_xticks(middles[::step], names[::step], rotation=0 if few else 90, fontsize=11 if few else 9)
    axes.set_yticks(middles[::step], names[::step], rotation=90 if few else 0, fontsize=11 if few else 9, va="center")
    axes.tick_params(length=0)
    axes.set_xlabel("frame that the next segment starts with")
    axes.set_ylabel("frame that a segment ends with")
    for spine in axes.spines.values():
        spine.set_visible(False)
    return image


def _most_linked_clips(graph: MotionGraph) -> list[int]:
    """The few clips that most links lead between, in order."""
    shared = np.zeros((len(graph.clips), len(graph.clips)))
    for (i, j), cost in zip(graph.links.tolist(), graph.link_costs, strict=True):
        shared[graph.segments[i].clip, graph.segments[j].clip] += cost > 0
    shared += shared.T
    chosen = [int(shared.sum(axis=0).argmax())]
    while len(chosen) < min(N_ZOOMED, len(graph.clips)):
        among = shared[chosen].sum(axis=0)
        among[chosen] = -1
        chosen.append(int(among.argmax()))
    return sorted(chosen)


def draw_graph(graph: MotionGraph, file: Path) -> None:
    """Segments as dots, links as arrows; what was cut but dropped in grey around the component."""
    summary = summarize(graph)
    segments = [*graph.segments, *graph.dropped_segments]
    n_kept = len(graph.segments)
    links = np.concatenate([graph.links, graph.dropped_links])
    follows = np.array(
        [(segments[a].clip, segments[a].last) == (segments[b].clip, segments[b].first) for a, b in links]
    )
    places = spring_layout(len(segments), links, np.where(follows, 3.0, 1.0), np.arange(len(segments)) < n_kept)
    meetings = np.zeros(len(segments))
    meetings[:n_kept] = summary.in_degree * summary.out_degree
    radii = np.where(np.arange(len(segments)) < n_kept, 7 + 15 * np.sqrt(meetings / max(meetings.max(), 1)), 4.5)
    inner = (links < n_kept).all(axis=1)

    figure, axes = plt.subplots(figsize=(16, 11), constrained_layout=True)
    pairs = {tuple(link) for link in links.tolist()}
    for (a, b), onward, kept in sorted(
        zip(map(tuple, links.tolist()), follows, inner, strict=True), key=lambda drawn: (drawn[2], drawn[1])
    ):
        if a == b:
            continue
        colour, width, alpha = (RED, 2.0, 0.95) if onward else (BLUE, 0.9, 0.35)
        if not kept:
            colour, width, alpha = GREY, 0.8 if not onward else 1.4, 0.55
        axes.add_patch(
            FancyArrowPatch(
                places[a],
                places[b],
                arrowstyle="-|>",
                mutation_scale=8 + 2 * width,
                shrinkA=radii[a],
                shrinkB=radii[b],
                connectionstyle=f"arc3,rad={0.16 if (b, a) in pairs else 0.06}",
                color=colour,
                linewidth=width,
                alpha=alpha,
                zorder=1 + kept + onward,
            )
        )
    hubs = set(summary.hubs(N_HUBS).tolist())
    axes.scatter(*places[n_kept:].T, s=(2 * radii[n_kept:]) ** 2, color="#d0d0d0", edgecolors=GREY, zorder=4)
    dots = axes.scatter(
        *places[:n_kept].T,
        s=(2 * radii[:n_kept]) ** 2,
        c=meetings[:n_kept],
        cmap="viridis",
        edgecolors=["black" if i in hubs else "white" for i in range(n_kept)],
        linewidths=[2.2 if i in hubs else 1 for i in range(n_kept)],
        zorder=5,
    )
    for i in range(n_kept):
        dark = meetings[i] < 0.6 * meetings.max()
        axes.annotate(
            str(i), places[i], ha="center", va="center", fontsize=8, color="white" if dark else "black", zorder=6
        )
    bar = figure.colorbar(dots, ax=axes, shrink=0.5, pad=0.01)
    bar.set_label("in-degree x out-degree", labelpad=10)
    lines = [f"{i}: {graph.segments[i].name}" for i in summary.hubs(N_HUBS)]
    axes.text(
        0.005,
        0.005,
        "The best connected segments\n" + "\n".join(lines),
        transform=axes.transAxes,
        va="bottom",
        fontsize=10,
        bbox={"facecolor": "white", "edgecolor": GREY, "alpha": 0.9},
        zorder=7,
    )
    axes.legend(
        handles=[
            Line2D([], [], color=RED, linewidth=2, label="goes on in the same clip"),
            Line2D([], [], color=BLUE, linewidth=1.2, label="transition"),
            Line2D([], [], color="black", marker="o", markerfacecolor="white", linestyle="", label="hub"),
            Line2D([], [], color="#d0d0d0", marker="o", linestyle="", markeredgecolor=GREY, label="dropped segment"),
        ],
        loc="upper left",
        fontsize=10,
    )
    axes.set_title(
        f"{n_kept} segments and {len(graph.links)} links in the largest strongly connected component "
        f"(D ≤ {graph.max_cost:.2g} rad²), {len(graph.dropped_segments)} segments outside"
    )
    axes.margins(0.04)
    axes.set_axis_off()
    figure.savefig(file, dpi=100)
    plt.close(figure)


def _clip_rows(graph: MotionGraph) -> list[tuple[str, str, str, str, str]]:
    """Name, seconds, seconds kept, segments and losses of every clip."""
    rows = []
    for clip in summarize(graph).clips:
        losses = "; ".join(f"{seconds:.2f} s: {reason}" for seconds, reason in clip.losses)
        kept = f"{clip.kept_seconds:.1f}" if clip.n_segments else "-"
        rows.append((clip.name, f"{clip.seconds:.1f}", kept, str(clip.n_segments or "-"), losses))
    return rows


COLUMNS = ("clip", "seconds", "kept", "segments", "left out, and why")


def draw_clips(graph: MotionGraph, file: Path) -> None:
    """The use of every clip as a picture of a table; clips that are not in the graph at all in grey."""
    rows, summary = _clip_rows(graph), summarize(graph)
    figure, axes = plt.subplots(figsize=(15, 1.1 + 0.3 * len(rows)), layout="constrained")
    height = len(rows) + 1
    edges = np.array([0.0, 0.1, 0.17, 0.3, 0.38])
    for x, title in zip(edges, COLUMNS, strict=True):
        axes.text(x, 0, title, weight="bold", va="center")
    longest = max(clip.seconds for clip in summary.clips)
    for line, (clip, row) in enumerate(zip(summary.clips, rows, strict=True), start=1):
        if line % 2:
            axes.axhspan(line - 0.5, line + 0.5, color="#f2f2f2", linewidth=0)
        width = 0.075
        axes.barh(line, width * clip.seconds / longest, left=0.205, height=0.5, color="#cfcfcf")
        axes.barh(line, width * clip.kept_seconds / longest, left=0.205, height=0.5, color=GREEN)
        for x, text in zip(edges, row, strict=True):
            axes.text(x, line, text, va="center", color="black" if clip.n_segments else "#777777")
    axes.axhline(0.5, color="black", linewidth=1)
    axes.set_xlim(0, 1)
    axes.set_ylim(height - 0.4, -0.6)
    axes.set_axis_off()
    axes.set_title(
        f"{summary.kept_seconds:.1f} of {summary.seconds:.1f} s are kept at D ≤ {graph.max_cost:.2g} rad²", loc="left"
    )
    figure.savefig(file, dpi=100)
    plt.close(figure)


def write_clips(graph: MotionGraph, file: Path) -> None:
    """The same table to be read and searched."""
    header = "".join(f"<th>{column}</th>" for column in COLUMNS)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>\n" for row in _clip_rows(graph)
    )
    file.write_text(f'<meta charset="utf-8"><table>\n<tr>{header}</tr>\n{body}</table>\n', "utf-8")


def draw_contacts(graph: MotionGraph, settings: MotionGraphSettings, file: Path) -> None:
    """When which foot is planted, clip by clip, with the segments of the graph behind."""
    figure, axes = plt.subplots(figsize=(16, 1.4 + 0.36 * len(graph.clips)), layout="constrained")
    for row, clip in enumerate(graph.clips):
        planted = foot_contacts(clip, settings.contacts)
        axes.barh(row, clip.duration, height=0.84, color="#f0f0f0")
        for segment in (segment for segment in graph.segments if graph.clips[segment.clip] is clip):
            axes.barh(row, segment.duration, left=segment.first / clip.frame_rate, height=0.84, color="#cfe8dc")
            for frame in (segment.first, segment.last):
                axes.plot([frame / clip.frame_rate] * 2, [row - 0.42, row + 0.42], color="black", linewidth=1, zorder=3)
        for side, colour, level in ((0, BLUE, -0.19), (1, ORANGE, 0.19)):
            changes = np.flatnonzero(np.diff(np.concatenate([[0], planted[:, side].astype(int), [0]])))
            spans = (changes.reshape(-1, 2) - [[0, 1]]) / clip.frame_rate
            axes.barh(
                [row + level] * len(spans), spans[:, 1] - spans[:, 0], left=spans[:, 0], height=0.26, color=colour
            )
    axes.set_yticks(range(len(graph.clips)), [clip.name for clip in graph.clips])
    axes.set_ylim(len(graph.clips) - 0.4, -0.6)
    axes.set_xlim(0, max(clip.duration for clip in graph.clips))
    axes.set_xlabel("seconds")
    axes.set_title("Planted feet, cuts, and the motion that is kept", loc="left")
    axes.legend(
        handles=[
            Patch(color=BLUE, label="left foot planted"),
            Patch(color=ORANGE, label="right foot planted"),
            Patch(color="#cfe8dc", label="segment of the graph"),
            Patch(color="#f0f0f0", label="dropped"),
            Line2D([], [], color="black", linewidth=1, label="cut"),
        ],
        loc="lower right",
        ncols=5,
        bbox_to_anchor=(1, 1),
        frameon=False,
    )
    for spine in ("top", "right", "left"):
        axes.spines[spine].set_visible(False)
    axes.tick_params(axis="y", length=0)
    figure.savefig(file, dpi=100)
    plt.close(figure)


if __name__ == "__main__":
    main()
