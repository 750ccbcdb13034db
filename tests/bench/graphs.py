"""Benchmarks of building motion graphs."""

from core.motion.graph import MotionGraphSettings, build_motion_graph
from tests.bench import problems
from tests.bench.benchmark import Benchmark


def motion_graph() -> Benchmark:
    """Clips to motion graph (resampling, contacts, costs, cutting, component)."""
    clips = list(problems.clips())
    return Benchmark(
        run=lambda: build_motion_graph(clips, MotionGraphSettings()),
        counts=lambda graph: {"segments": len(graph.segments), "links": len(graph.links)},
    )


BENCHMARKS = {"graph": motion_graph}
