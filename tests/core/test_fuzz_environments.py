"""Any triangles, grids and graphs whatever make a sound embedding or a sentence: never another error."""

import gc
import os
import tracemalloc
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import core
from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintRule, FootprintSettings
from core.environment.environment import Environment, EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.environment.regions import Region, RegionRule
from core.errors import MotionGraphError
from core.evaluation.variability import floor_variability
from core.evaluation.weak_spots import weak_spots_steps
from core.motion.graph import MotionGraph, MotionSegment
from core.playback.walk import WalkSettings, random_walk_steps
from core.progress import finish
from core.tuning.local_pruning import prune_local_steps

from .studies import small_graph

# Nightly: WAYFARER_FUZZ=100 tries a hundred times as many.
CORE = Path(core.__path__[0])
EFFORT = int(os.environ.get("WAYFARER_FUZZ", "1"))
ODD_LENGTHS = (0.0, -1.0, np.nan, np.inf, -np.inf, 1e-300, 1e-7, 0.07, 40.0, 1e9, 1e308)
SOUND_LENGTHS = (0.0, 0.07, 0.3, 1.0)
GROUND_LENGTHS = (0.3, 1.0, 2.5, 4.0)


def lengths(draw, sound: tuple[float, ...] = SOUND_LENGTHS) -> float:
    """Mostly a sound one: if there were an odd one in every problem, none would ever be embedded."""
    # A number from the middle: Hypothesis likes to try the ends.
    return draw(st.sampled_from(ODD_LENGTHS if draw(st.integers(0, 39)) == 23 else sound))


@st.composite
def triangles(draw) -> np.ndarray:
    """(T, 3, 3): points, lines, slivers, walls, far away, too large, not a number."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shapes = rng.normal(0, draw(st.sampled_from([0.0, 1e-9, 0.5, 3.0, 1e6, 1e150])), (draw(st.integers(0, 12)), 3, 3))
    shapes += rng.normal(0, 1, (len(shapes), 1, 3))
    kind = draw(st.sampled_from(["as they are", "points", "lines", "walls", "flat"]))
    if kind in ("points", "lines"):
        shapes[:, 1:] = shapes[:, :1] if kind == "points" else shapes[:, 1:2]
    if kind == "walls":
        shapes[:, 2, :2] = shapes[:, 1, :2]
    if kind == "flat":
        shapes[:, :, 2] = draw(st.sampled_from([0.0, 0.3, 1.0]))
    if len(shapes) and draw(st.integers(0, 9)) == 0:
        shapes[0, 0, draw(st.integers(0, 2))] = draw(st.sampled_from([np.nan, np.inf, -np.inf, 1e308]))
    return shapes


@st.composite
def regions(draw) -> list[Region]:
    return [
        Region(f"Region {place}", draw(st.sampled_from(RegionRule)), "step", draw(triangles()), lengths(draw))
        for place in range(draw(st.integers(0, 2)))
    ]


def draw_environment(draw):
    low = (draw(st.sampled_from([0.0, -3.0, 1e6])), 0.0)
    high = (low[0] + lengths(draw, GROUND_LENGTHS), lengths(draw, GROUND_LENGTHS))
    headings = draw(st.sampled_from([1, 3, 8, 12, 8, 3, 0, -4]))
    cell_size, tiled = lengths(draw, (0.3, 0.25, 0.1)), draw(st.booleans())
    if tiled and draw(st.booleans()):
        # Only whole numbers of cells can be tiled.
        with np.errstate(all="ignore"):
            high = tuple(np.add(low, np.ceil(np.subtract(high, low) / cell_size) * cell_size))
    grid = Grid.over_rectangle(low, high, cell_size, headings, tiled)
    heights = EnvironmentSettings(
        radius=lengths(draw), step_height=lengths(draw), head_height=1.8, ground_height=lengths(draw)
    )
    return build_environment(grid, draw(triangles()), draw(regions()), heights)


def draw_graph(draw) -> MotionGraph:
    """Segments from standing still to far beyond the ground, links from none to all."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, segments = draw(st.integers(1, 4)), []
    for number in range(n):
        n_frames = draw(st.integers(2, 12))
        path = np.zeros((n_frames, 3))
        path[1:] = np.cumsum(
            rng.normal(0, draw(st.sampled_from([0.0, 1e-9, 0.1, 0.5, 50.0])), (n_frames - 1, 3)), axis=0
        )
        tags = {"step": rng.random(n_frames) < 0.5} if draw(st.booleans()) else {}
        segments.append(MotionSegment(f"s{number}", 0, 0, n_frames - 1, path, (n_frames - 1) / 30, tags))
    links = np.argwhere(rng.random((n, n)) < draw(st.sampled_from([0.0, 0.5, 1.0])))
    return MotionGraph((), 30.0, tuple(segments), links, np.zeros(len(links)))


def attempted(make, *arguments):
    """What came of it, or the sentence of why nothing did; whatever else is raised fails the test."""
    try:
        return make(*arguments)
    except MotionGraphError as error:
        sentence = str(error)
        assert sentence.endswith(".") and len(sentence) > 20 and "Traceback" not in sentence, sentence
        return sentence


@settings(max_examples=60 * EFFORT, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_a_scene_makes_a_sound_environment_and_embedding_or_a_sentence(data):
    environment = attempted(draw_environment, data.draw)
    if isinstance(environment, str):
        return
    free = environment.free_cells()
    assert free.shape == environment.grid.shape[:2] and free.dtype == bool
    footprint = attempted(
        lambda: FootprintSettings(*(lengths(data.draw) for _ in range(4)), data.draw(st.sampled_from(FootprintRule)))
    )
    if isinstance(footprint, str):
        return
    graph = draw_graph(data.draw)
    embedding = attempted(embed, graph, environment, EmbeddingSettings(footprint, memory_limit=1e7))
    if isinstance(embedding, str):
        return
    x, y, heading, segment = embedding.node_mask().shape
    assert (x, y, heading) == environment.grid.shape and segment == len(graph.segments)
    # A node stands on free floor, has a way in and a way out.
    assert not np.any(embedding.covered().any(axis=2) & ~free)
    n_in, n_out = (np.count_nonzero(degree) for degree in (embedding.in_degree(), embedding.out_degree()))
    assert n_in == n_out == embedding.n_nodes
    assert floor_variability(embedding).shape == free.shape
    attempted(lambda: finish(weak_spots_steps(embedding)))
    steps = random_walk_steps(embedding, np.random.default_rng(0), WalkSettings(1.0))
    walk = attempted(finish, steps)
    assert isinstance(walk, str) == (embedding.n_nodes == 0)
    pruned = attempted(lambda k: finish(prune_local_steps(embedding, k)), data.draw(st.integers(-1, 3)))
    assert isinstance(pruned, str) or pruned.n_nodes <= embedding.n_nodes


def held_by_core():
    """Bytes that were allocated by the core's code; threads of other tests may be alive, and allocate as well."""
    # What waits for the collector of cycles is not kept.
    gc.collect()
    ours = tracemalloc.take_snapshot().filter_traces([tracemalloc.Filter(True, str(CORE / "*"))])
    return sum(trace.size for trace in ours.traces)


def test_memory_stays_bounded_over_a_hundred_embeddings():
    """Each knows the one before for a moment, and none of them all of their ancestors."""
    rng, grid, graph = np.random.default_rng(0), Grid((8, 8, 4), 0.5), small_graph()
    embedding, taken = None, []
    tracemalloc.start()
    try:
        for number in range(100):
            blocked = np.zeros((32, 32), dtype=bool)
            x, y = rng.integers(0, 24, 2)
            blocked[x : x + 10, y : y + 10] = True
            embedding = embed(graph, Environment(grid, blocked), previous=embedding)
            _ = embedding.n_links
            if number < 10 or number >= 80:
                taken.append(held_by_core())
    finally:
        tracemalloc.stop()
    assert embedding.n_nodes > 0 and min(taken) > 10_000
    first, last = max(taken[:10]), max(taken[10:])
    assert last < 1.2 * first, f"{first / 1e6:.2f} MB in the first ten, {last / 1e6:.2f} in the last twenty"
