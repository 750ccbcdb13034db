"""Benchmarks of walking."""

import numpy as np
from scipy.sparse.csgraph import dijkstra

from core.embedding.embedding import embed
from core.evaluation.goals import goal_at
from core.playback.cleanup import clean_feet
from core.playback.crowd import crowd_steps, scattered_starts
from core.playback.curve import walk_along_steps
from core.playback.directed import walk_through_steps
from core.playback.loop import loop_steps
from core.playback.synthesis import synthesize
from core.playback.time_to_go import rows_of
from core.playback.walk import WalkSettings, nearest_node, random_walk_steps
from core.progress import finish
from tests.bench import problems
from tests.bench.benchmark import Benchmark
from tests.core.motion_graphs import sample_graph


def minute_of_walking() -> Benchmark:
    """A random walk of 60 s and its poses."""
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(
        run=lambda: synthesize(finish(random_walk_steps(embedding, np.random.default_rng(0), WalkSettings(60.0)))),
        counts=lambda clip: {"frames": clip.n_frames},
    )


def foot_cleanup() -> Benchmark:
    """A minute of walking synthesised, with its feet held in place."""
    embedding = embed(problems.graph(0.12), problems.room())
    walk = finish(random_walk_steps(embedding, np.random.default_rng(0), WalkSettings(60.0)))

    def played():
        # Afresh, because clips remember where their joints are.
        return clean_feet(walk, synthesize(walk))

    return Benchmark(run=played, counts=lambda found: {"frames": found.clip.n_frames, "plants held": len(found.plants)})


def way_across() -> Benchmark:
    """The quickest walk from one corner of the room to the other, beside Dijkstra over explicit links."""
    embedding = embed(problems.graph(0.12), problems.room())
    start = nearest_node(embedding, (1.0, 1.0), np.random.default_rng(0))
    goal = goal_at(embedding, (6.0, 7.0), 0.3)

    def by_links():
        nodes, links = embedding.to_csr()
        row = np.flatnonzero((nodes == start).all(axis=1))[0]
        ends = set(map(tuple, rows_of(embedding, goal).tolist()))
        at_goal = [i for i, node in enumerate(map(tuple, nodes.tolist())) if node in ends]
        return dijkstra(links, indices=row)[at_goal].min()

    return Benchmark(
        run=lambda: finish(walk_through_steps(embedding, start, [goal])),
        counts=lambda walk: {"frames": int(walk.node_frames[-1])},
        reference=by_links,
        reference_counts=lambda seconds: {"frames": round(seconds * embedding.graph.frame_rate)},
        reference_name="Dijkstra over explicit links",
        reference_repeats=1,
    )


def way_through() -> Benchmark:
    """The quickest walk through three corners of the room, as a whole."""
    embedding = embed(problems.graph(0.12), problems.room())
    start = nearest_node(embedding, (1.0, 1.0), np.random.default_rng(0))
    goals = [goal_at(embedding, corner, 0.3) for corner in ((6.0, 7.0), (6.0, 1.0), (1.0, 7.0))]
    return Benchmark(
        run=lambda: finish(walk_through_steps(embedding, start, goals)),
        counts=lambda walk: {"frames": int(walk.node_frames[-1])},
    )


def closed_walk() -> Benchmark:
    """A loop of 30 s."""
    embedding = embed(problems.graph(0.12), problems.room())
    return Benchmark(
        run=lambda: finish(loop_steps(embedding, np.random.default_rng(3), WalkSettings(30.0))),
        counts=lambda walk: {"frames": int(walk.node_frames[-1])},
    )


def along_a_curve() -> Benchmark:
    """A walk along a figure of eight through an empty hall, by the sample character."""
    embedding = embed(sample_graph(), problems.room(pillars_per_area=0.02))
    angle = np.linspace(0, 2 * np.pi, 60)
    curve = np.column_stack([3.5 + 2.3 * np.cos(angle), 4 + 1.8 * np.sin(2 * angle)])
    return Benchmark(
        run=lambda: finish(walk_along_steps(embedding, curve)),
        counts=lambda walk: {"frames": int(walk.node_frames[-1])},
        repeats=1,
    )


def fifty_walkers() -> Benchmark:
    """50 sample characters on a ground of 20 x 20 m with pillars, for a minute."""
    embedding = embed(sample_graph(), problems.room(20.0, 20.0))
    starts = scattered_starts(embedding, 50, np.random.default_rng(1), 0.8)
    return Benchmark(
        run=lambda: finish(crowd_steps(embedding, starts, 60.0, np.random.default_rng(1))),
        counts=lambda found: {
            "walkers": len(found.walks),
            "links": sum(map(len, found.walks)),
            "closest mm": int(1000 * found.closest),
        },
        repeats=1,
    )


BENCHMARKS = {
    "walk": minute_of_walking,
    "cleanup": foot_cleanup,
    "directed": way_across,
    "waypoints": way_through,
    "loop": closed_walk,
    "curve": along_a_curve,
    "crowd": fifty_walkers,
}
