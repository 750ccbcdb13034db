"""The motion graph: as near to the paper's as the motion allows, and the one that we think best."""

from dataclasses import dataclass, replace

import numpy as np

from ...core import wording
from ...core.embedding.footprint import path_length
from ...core.errors import MotionGraphError
from ...core.motion.clip import MotionClip
from ...core.motion.graph import MotionGraph, MotionGraphSettings, ThresholdMode, build_motion_graph
from ...core.motion.repertoire import STEP_TAG
from ...core.report.chart import Series, line_chart
from ...core.report.page import Figure, FigureRow, Paragraph, Section
from ...core.report.table import table
from .chapter import Chapter, Comparison

#: The paper's: "23 motions, 77 s" became so many segments and links.
PAPER_MOTIONS, PAPER_SECONDS, PAPER_SEGMENTS, PAPER_LINKS = 23, 77, 55, 147

#: Minimum lengths of segments that are tried (s): a third of a second is half a step, a second two.
MIN_DURATIONS = (0.33, 0.4, 0.5, 0.67, 1.0)

#: Thresholds (rad2) at which is looked whether the motion that steps over takes part.
COSTS = (0.08, 0.1, 0.12, 0.15, 0.18, 0.21, 0.24, 0.27, 0.3)


@dataclass(frozen=True)
class Graphs:
    """Motion graphs of the same clips.

    Attributes
    ----------
    clips : list of MotionClip
    nearest : MotionGraph
        Of those with at most the paper's number of links the one whose number of segments is nearest to the paper's.
    nearest_duration : float
        Minimum length of its segments (s).
    best : MotionGraph
        By the default settings.
    by_cost : tuple of MotionGraph
        By the default minimum length, at ever higher thresholds.
    """

    clips: list[MotionClip]
    nearest: MotionGraph
    nearest_duration: float
    best: MotionGraph
    by_cost: tuple[MotionGraph, ...]


def make_graphs(
    clips: list[MotionClip], costs: tuple[float, ...] = COSTS, durations: tuple[float, ...] = MIN_DURATIONS
) -> tuple[Graphs, list[list]]:
    """The graphs, and a row of duration, segments, links, threshold and clips for each one tried for the nearest."""
    default = MotionGraphSettings()
    tried: list[tuple[float, MotionGraph]] = []
    for duration in durations:
        settings = replace(
            default, min_segment_duration=duration, threshold_mode=ThresholdMode.LINKS, max_links=PAPER_LINKS
        )
        try:
            tried.append((duration, build_motion_graph(clips, settings)))
        except MotionGraphError:
            # No graph of this minimum length is so small.
            continue
    if not tried:
        raise MotionGraphError(f"These clips make no motion graph of {PAPER_LINKS} links or less; use others.")
    by_cost = []
    for cost in costs:
        try:
            by_cost.append(build_motion_graph(clips, replace(default, max_cost=cost)))
        except MotionGraphError:
            # So strict that nothing connects.
            continue
    duration, nearest = min(tried, key=lambda found: _distance(found[1]))
    best = build_motion_graph(clips, default)
    rows = [
        [
            d,
            len(g.segments),
            len(g.links),
            g.max_cost,
            _n_clips(g),
            mean_length(g)[0],
            "nearest" if g is nearest else "",
        ]
        for d, g in tried
    ]
    return Graphs(clips, nearest, duration, best, tuple(by_cost)), rows


def describe_graphs(graphs: Graphs, rows: list[list], trimmed: list[str]) -> Chapter:
    """The section on the motion graph.

    ``rows`` come from :func:`make_graphs`, ``trimmed`` from :func:`.stage.bring_clips`.
    """
    nearest, best = graphs.nearest, graphs.best
    seconds = sum(clip.duration for clip in graphs.clips)
    tried = table(
        ["minimum length (s)", "segments", "links", "threshold (rad²)", "clips that take part", "mean length (s)", ""],
        rows,
    )
    doctored = f" The clip doctor found what is no motion, and it was cut off. {' '.join(trimmed)}" if trimmed else ""
    costs = np.array([graph.max_cost for graph in graphs.by_cost])
    charts = {
        f"motion_graph_{name}": line_chart(
            f"{name.capitalize()} against the threshold",
            "transition cost up to which frames are linked (rad²)",
            name,
            [Series(name, costs, np.array([len(getattr(graph, name)) for graph in graphs.by_cost]))],
        )
        for name in ("segments", "links")
    }
    first = next((graph.max_cost for graph in graphs.by_cost if steps_over(graph)), None)
    stepping = (
        "None of them steps over anything."
        if first is None
        else f"The motion that steps over takes part from a threshold of {wording.exact(first)} on."
    )
    return Chapter(
        Section(
            "The motion graph",
            (
                Paragraph(
                    f"{len(graphs.clips)} motions, {wording.time(seconds)}. The paper does not tell its threshold and "
                    "its minimum length. For each of some minimum lengths the threshold was sought that gives as many "
                    f"links as possible, but at most {PAPER_LINKS}; nearest is the graph whose number of segments "
                    f"differs least from {PAPER_SEGMENTS}.{doctored}"
                ),
                tried,
                Paragraph(
                    f"Ours by default (threshold {wording.exact(best.max_cost)}, minimum "
                    f"{wording.exact(MotionGraphSettings().min_segment_duration)} s) has {len(best.segments)} segments "
                    f"and {len(best.links)} links from {_n_clips(best)} clips: a looser threshold, so that more of the "
                    f"motion is used. {stepping}"
                ),
                FigureRow(
                    tuple(Figure(c, "Graphs with the default minimum length of a segment.") for c in charts.values())
                ),
            ),
        ),
        figures=charts,
        numbers={
            "motions": len(graphs.clips),
            "seconds": seconds,
            "nearest": _numbers(nearest) | {"min_duration_s": graphs.nearest_duration},
            "best": _numbers(best),
            "steps_from_cost": first,
        },
        comparisons=(
            Comparison(
                "Motion capture: motions, seconds",
                f"{PAPER_MOTIONS}, {PAPER_SECONDS} s",
                f"{len(graphs.clips)}, {wording.time(seconds)}",
                "The paper's clips are not published; these were chosen to be alike."
                if len(graphs.clips) == PAPER_MOTIONS
                else "Other motion: the recorded clips are not at hand, these are procedural.",
            ),
            Comparison(
                "Motion graph: segments, links",
                f"{PAPER_SEGMENTS}, {PAPER_LINKS}",
                f"{len(nearest.segments)}, {len(nearest.links)}",
                f"Found by search, threshold {wording.short(nearest.max_cost)} and minimum "
                f"{wording.exact(graphs.nearest_duration)} s. Counts alike, but not the motion in them: so strict a "
                f"threshold leaves {_n_clips(nearest)} of {len(graphs.clips)} clips, in segments of "
                f"{wording.time(mean_length(nearest)[0])} on average (the paper's last up to "
                f"{wording.time(PAPER_SECONDS / PAPER_SEGMENTS)})"
                + (
                    "."
                    if steps_over(nearest)
                    else ", and none that steps over: for the scenes with a step the looser graph below is used."
                ),
            ),
            Comparison(
                "Our best motion graph",
                "-",
                f"{len(best.segments)}, {len(best.links)}",
                "Default settings. More links for about as many segments: frames are compared everywhere, and cuts are "
                "placed so that as many good transitions as possible meet there.",
            ),
        ),
    )


def steps_over(graph: MotionGraph) -> bool:
    """Test whether any segment carries the tag that the sample scenes' steps ask for."""
    return any(STEP_TAG in segment.tags for segment in graph.segments)


def mean_length(graph: MotionGraph) -> tuple[float, float]:
    """Seconds and metres of a graph's segments on average."""
    segments = graph.segments
    return (
        sum(segment.duration for segment in segments) / len(segments),
        sum(path_length(segment) for segment in segments) / len(segments),
    )


def children_per_segment(graph: MotionGraph) -> float:
    return len(graph.links) / len(graph.segments)


def _distance(graph: MotionGraph) -> float:
    """Distance of a graph's size from the paper's: the two ratios' logarithms."""
    return abs(np.log(len(graph.segments) / PAPER_SEGMENTS)) + abs(np.log(len(graph.links) / PAPER_LINKS))


def _n_clips(graph: MotionGraph) -> int:
    return len({segment.clip for segment in graph.segments})


def _numbers(graph: MotionGraph) -> dict:
    return {
        "segments": len(graph.segments),
        "links": len(graph.links),
        "max_cost": float(graph.max_cost),
        "clips": _n_clips(graph),
        "steps_over": steps_over(graph),
    }
