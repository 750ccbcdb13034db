"""Benchmarks of the embedding: rooms, tiles, large grounds, and a room in which something moves."""

from dataclasses import replace

import numpy as np

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.motion.graph import MotionGraph, MotionGraphSettings
from tests.bench import problems
from tests.bench.benchmark import Benchmark
from tests.bench.explicit import embed_explicitly

WIDE = FootprintSettings(position_rate=0.15, heading_rate=0.12)


def _counts(embedding) -> dict:
    return {"nodes": embedding.n_nodes, "links": embedding.n_links}


def _against_explicit(max_cost: float, footprint: FootprintSettings, repeats: int) -> Benchmark:
    graph, environment = problems.graph(max_cost), problems.room()
    settings = EmbeddingSettings(footprint)
    return Benchmark(
        run=lambda: embed(graph, environment, settings),
        counts=_counts,
        reference=lambda: embed_explicitly(graph, environment, settings),
        reference_counts=lambda result: dict(zip(("nodes", "links"), result, strict=True)),
        reference_name="explicit links, SciPy's strong components",
        repeats=repeats,
    )


def room() -> Benchmark:
    """The paper's room, 7 x 8 m in cells of 12.5 cm and 24 headings, with a tight motion graph."""
    return _against_explicit(0.1, FootprintSettings(), 5)


def room_default() -> Benchmark:
    """The same room with the default threshold, and so several times the links."""
    return _against_explicit(MotionGraphSettings().max_cost, FootprintSettings(), 3)


def room_wide() -> Benchmark:
    """The default motion graph with wide footprints: the explicit links would not fit into this benchmark's time."""
    graph, environment = problems.graph(MotionGraphSettings().max_cost), problems.room()
    return Benchmark(lambda: embed(graph, environment, EmbeddingSettings(WIDE)), counts=_counts)


def tile() -> Benchmark:
    """A tile of 6 x 6 m in cells of 15 cm, joined to itself on all sides."""
    grid = Grid.over_rectangle((0, 0), (6, 6), 0.15, 24, tiled=True)
    samples = np.zeros((160, 160), dtype=bool)
    samples[40:80, 50:70] = samples[100:120, 110:150] = True
    graph, environment = problems.graph(0.12), Environment(grid, samples)
    return Benchmark(lambda: embed(graph, environment), counts=_counts)


def _moved(graph: MotionGraph, environment: Environment) -> Benchmark:
    blocked = environment.blocked.copy()
    blocked[100:120, 60:75] = True
    nudged = environment.blocked.copy()
    nudged[103:123, 60:75] = True
    previous = embed(graph, replace(environment, blocked=blocked))
    after = replace(environment, blocked=nudged)
    return Benchmark(
        run=lambda: embed(graph, after, previous=previous),
        counts=_counts,
        reference=lambda: embed(graph, after),
        reference_counts=_counts,
        reference_name="from scratch",
    )


def moved() -> Benchmark:
    """The room again after one pillar has moved by a hand's breadth; the reference starts from scratch."""
    return _moved(problems.graph(0.12), problems.room())


def moved_scarce() -> Benchmark:
    """The same with few links, and fewer pillars: there are thousands of components that could be the largest."""
    return _moved(problems.scarce_graph(), problems.room(pillars_per_area=0.04))


def ground(side: float, repeats: int) -> Benchmark:
    """A square ground with scattered pillars."""
    graph, environment = problems.graph(0.12), problems.room(side, side)
    return Benchmark(lambda: embed(graph, environment), counts=_counts, repeats=repeats)


BENCHMARKS = {
    "embed": room,
    "embed-default": room_default,
    "embed-wide": room_wide,
    "embed-tile": tile,
    "embed-moved": moved,
    "embed-moved-scarce": moved_scarce,
    "embed-40m": lambda: ground(40.0, 2),
    "embed-100m": lambda: ground(100.0, 1),
}
