"""Benchmarks of building motion graphs."""

from dataclasses import replace

from core.motion.graph import MotionGraphSettings, build_motion_graph
from tests.bench import cuttings, problems
from tests.bench.benchmark import Benchmark
from tests.bench.dense_graph import dense_motion_graph


def motion_graph() -> Benchmark:
    """Clips to motion graph (resampling, contacts, costs, cutting, component)."""
    return Benchmark(
        run=lambda: build_motion_graph(_fresh(problems.clips()), MotionGraphSettings()),
        counts=_counts,
        reference=lambda: dense_motion_graph(_fresh(problems.clips()), MotionGraphSettings()),
        # Cut clip by clip, the graph is another one.
        reference_counts=lambda found: dict(zip(("reference segments", "reference links"), found, strict=True)),
        reference_name="all pairs joint by joint, greedy cuts",
        reference_repeats=1,
    )


def large_motion_graph() -> Benchmark | None:
    """160 clips, 611 s, 168 million pairs of frames: too many for the obvious way."""
    if not problems.large_clips():
        return None
    return Benchmark(
        run=lambda: build_motion_graph(_fresh(problems.large_clips()), MotionGraphSettings()),
        counts=_counts,
        repeats=3,
    )


def cutting() -> Benchmark:
    """Cuts that keep the most goodness beside greedy ones; prints a table of more problems and ways."""
    cuttings.print_table()
    problem = cuttings.CuttingProblem(list(problems.clips()), MotionGraphSettings())
    greedy = {f"greedy {key}": value for key, value in problem.outcome(problem.greedy()).items()}
    return Benchmark(run=problem.best, counts=lambda cuts: {**problem.outcome(cuts), **greedy})


def _counts(graph) -> dict:
    return {"segments": len(graph.segments), "links": len(graph.links)}


def _fresh(clips) -> list:
    """The clips without what they remember from an earlier run."""
    return [replace(clip) for clip in clips]


BENCHMARKS = {"graph": motion_graph, "graph-large": large_motion_graph, "cutting": cutting}
