"""The bit-plane embedding against the explicit one."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from core.embedding.component import largest_component_steps
from core.embedding.embedding import EmbeddingSettings, embed, embed_steps, needed_bytes, restrict_steps
from core.embedding.footprint import FootprintRule, FootprintSettings, footprints
from core.embedding.network import StepNetwork
from core.embedding.stencil import build_stencils
from core.embedding.sweep import sweep_steps
from core.embedding.unroll import unroll_steps
from core.embedding.warm_start import warm_start
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.errors import EmbeddingError
from core.evaluation.variability import variability
from core.motion.graph import MotionGraph, MotionSegment
from core.progress import finish

from .motion_graphs import sample_graph
from .reference import explicit_embedding, random_problem

FOOTPRINTS = [
    FootprintSettings(),
    FootprintSettings(0.05, 0.3, 0.2, 0.5),
    FootprintSettings(0.1, 0.2, 0.4, 0.4, FootprintRule.CONSERVATIVE),
    FootprintSettings(0.0, 0.1, 2.5, 0.5),
]


@given(st.integers(0, 10**6), st.booleans(), st.sampled_from(FOOTPRINTS))
@example(0, True, FOOTPRINTS[0])
def test_equals_the_explicit_embedding(seed, tiled, footprint_settings):
    graph, environment = random_problem(seed, tiled)
    wanted = EmbeddingSettings(footprint_settings)
    fast, slow = embed(graph, environment, wanted), explicit_embedding(graph, environment, wanted)
    assert np.array_equal(fast.node_mask(), slow.node_mask())
    assert (fast.n_nodes, fast.n_links) == (len(slow.nodes), len(slow.links))
    assert np.array_equal(fast.in_degree(), slow.in_degree())
    assert np.array_equal(fast.out_degree(), slow.out_degree())
    nodes, links = fast.to_csr()
    assert np.array_equal(np.ravel_multi_index(nodes.T, slow.shape) if len(nodes) else slow.nodes, slow.nodes)
    assert links.nnz <= len(slow.links)  # parallel links (two stencils between the same nodes) share one entry
    durations = np.array([segment.duration for segment in graph.segments])
    assert np.array_equal(links.data, durations[nodes[links.indices, 3]])
    pairs = np.unique(slow.links, axis=0)
    number = {node: i for i, node in enumerate(slow.nodes.tolist())}
    assert set(zip(*(a.tolist() for a in links.nonzero()), strict=True)) == {
        (number[a], number[b]) for a, b in pairs.tolist()
    }


def test_random_problems_are_not_all_trivial():
    """Guards the test above: its problems must hold embeddings, obstacles in their way and several components."""
    found = [explicit_embedding(*random_problem(seed, seed % 2 == 0), EmbeddingSettings()) for seed in range(60)]
    assert sum(len(e.nodes) > 0 for e in found) > 20
    assert sum(len(e.nodes) == 0 for e in found) > 3
    assert sum(0 < len(e.links) < len(e.all_links) for e in found) > 15


@settings(max_examples=500)
@given(st.integers(0, 10**6), st.booleans(), st.sampled_from([0, 5, 10**6]))
def test_largest_component_whatever_is_written_out(seed, tiled, explicit_links):
    """All ways to search lead to the same component, that of the explicit links, also where there are many."""
    rng = np.random.default_rng(seed)
    graph, environment = random_problem(seed, tiled)
    # Few links and many obstacles make many small components.
    environment = replace(environment, blocked=environment.blocked | (rng.random(environment.blocked.shape) < 0.05))
    stencils = build_stencils(graph.segments, environment.grid, FOOTPRINTS[0])
    sweep = finish(sweep_steps(graph.segments, stencils, environment.grid, environment.tags))
    unrolling = finish(unroll_steps(sweep, environment))
    network = StepNetwork(unrolling, graph.links, len(graph.segments))
    nodes = finish(largest_component_steps(network, explicit_links)).nodes
    found = np.array([network.layout.unpack(plane) for plane in nodes.planes])
    slow = explicit_embedding(graph, environment, EmbeddingSettings())
    nx, ny, n_headings, n_segments = slow.shape
    expected = slow.node_mask().transpose(3, 2, 0, 1).reshape(n_segments * n_headings, nx, ny)
    assert np.array_equal(found, expected)


def scattered_problem(seed, tiled, n_changes):
    """A random problem in which few links and many obstacles make many small components: its graph, and the unrollings
    of ``n_changes`` changes of the scene after one another."""
    rng = np.random.default_rng(seed)
    graph, environment = random_problem(seed, tiled)
    blocked = environment.blocked | (rng.random(environment.blocked.shape) < 0.05)
    stencils = build_stencils(graph.segments, environment.grid, FOOTPRINTS[0])
    sweep = finish(sweep_steps(graph.segments, stencils, environment.grid, environment.tags))
    unrollings = []
    for _ in range(n_changes):
        unrollings.append(finish(unroll_steps(sweep, replace(environment, blocked=blocked))))
        # Something comes, and something goes.
        blocked = blocked ^ (rng.random(blocked.shape) < rng.choice([0.01, 0.03]))
    return graph, unrollings


def components_by_size(network):
    """Sizes of all strongly connected components that hold a cycle, descending, by SciPy on all links."""
    indices, starts, ends = network.links_within(network.everything)
    matrix = coo_array((np.ones(len(starts)), (starts, ends)), shape=(len(indices),) * 2)
    _, label = connected_components(matrix, directed=True, connection="strong")
    sizes = np.bincount(label)
    with_cycle = (sizes > 1) | np.isin(np.arange(len(sizes)), label[starts[starts == ends]])
    return sorted(sizes[with_cycle].tolist(), reverse=True)


@settings(max_examples=250)
@given(st.integers(0, 10**6), st.booleans(), st.sampled_from([0, 5, 200, 10**6]))
def test_what_was_known_before_leads_to_the_same_component(seed, tiled, explicit_links):
    """Change after change, with a warm start and without, whatever is written out; and no other component is larger."""
    graph, unrollings = scattered_problem(seed, tiled, 4)
    known = None
    for unrolling in unrollings:
        network = StepNetwork(unrolling, graph.links, len(graph.segments))
        alone = finish(largest_component_steps(network, explicit_links))
        sizes = [*components_by_size(network), 0, 0]
        assert len(alone.nodes) == sizes[0] and alone.second_bound >= sizes[1]
        if known is None:
            found = alone
        else:
            before, component = known
            given_before = warm_start(network, before.valid, unrolling.valid, component.nodes, component.second_bound)
            found = finish(largest_component_steps(network, explicit_links, start=given_before))
        assert found.nodes == alone.nodes
        assert found.second_bound >= sizes[1]
        known = unrolling, found


def test_a_warm_start_leaves_little_to_search():
    """Guards the test above: rests are searched in part only, in problems of its kind; and parts are all that is."""
    left = []
    for seed in range(200):
        graph, (before, after) = scattered_problem(seed, False, 2)
        n_segments = len(graph.segments)
        old = finish(largest_component_steps(StepNetwork(before, graph.links, n_segments)))
        network = StepNetwork(after, graph.links, n_segments)
        given_before = warm_start(network, before.valid, after.valid, old.nodes, old.second_bound)
        everything = network.everything
        candidates = finish(given_before.candidates_steps(network, everything))
        if before.valid != after.valid:
            left.append(len(candidates) / len(everything))
    assert np.count_nonzero(np.array(left) < 0.5) > 20


@given(st.integers(0, 10**6), st.booleans())
def test_ends_of_links_are_those_of_the_links_written_out(seed, tiled):
    """Of the links that play the added starts of stencils, by comparing all links before with all links after."""
    graph, (before, after) = scattered_problem(seed, tiled, 2)
    added = [now & ~then for then, now in zip(before.valid, after.valid, strict=True)]
    network = StepNetwork(after, graph.links, len(graph.segments))
    only_added = StepNetwork(replace(after, valid=tuple(added)), graph.links, len(graph.segments))
    indices, starts, ends = only_added.links_within(only_added.everything)
    found_starts, found_ends = network.ends_of_links(added)
    assert found_starts == only_added.nodes(indices[np.unique(starts)])
    assert found_ends == only_added.nodes(indices[np.unique(ends)])


@settings(max_examples=150)
@given(st.integers(0, 10**6), st.booleans(), st.floats(0.3, 1.0))
def test_restricting_keeps_the_largest_component_of_the_nodes_left(seed, tiled, share):
    """Equal to SciPy's strong components of the written-out links between the nodes left."""
    embedding = embed(*random_problem(seed, tiled), EmbeddingSettings(FOOTPRINTS[1]))
    nodes, links = embedding.to_csr()
    left = np.random.default_rng(seed).random(len(nodes)) < share
    x, y, heading, segment = nodes[left].T
    _, ny, n_headings, _ = embedding.shape
    network = embedding.network
    restricted = finish(
        restrict_steps(embedding, network.nodes(np.column_stack([segment * n_headings + heading, x * ny + y])))
    )

    kept = links[left][:, left]
    _, label = connected_components(kept, directed=True, connection="strong")
    sizes = np.bincount(label) if len(label) else np.array([0])
    with_cycle = (sizes > 1) | np.isin(np.arange(len(sizes)), label[kept.diagonal() > 0])
    largest = np.max(sizes * with_cycle)
    assert restricted.n_nodes == largest
    if largest:
        best = min(np.flatnonzero((sizes == largest) & with_cycle), key=lambda c: np.flatnonzero(label == c)[0])
        assert np.array_equal(np.argwhere(restricted.node_mask()), nodes[left][label == best])
        inside = kept[label == best][:, label == best]
        assert restricted.n_links >= inside.nnz  # around a tiled ground two links may join the same nodes
        assert tiled or restricted.n_links == inside.nnz


def test_restricting_to_all_nodes_changes_nothing():
    embedding = embed(*random_problem(4, True), EmbeddingSettings())
    assert embedding.n_nodes > 0
    assert finish(restrict_steps(embedding, embedding.network.everything)).planes == embedding.planes
    assert finish(restrict_steps(embedding, embedding.network.empty)).n_nodes == 0


@given(st.integers(0, 10**6), st.booleans())
def test_every_node_can_be_left_and_entered(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), EmbeddingSettings(FOOTPRINTS[1]))
    mask = embedding.node_mask()
    assert np.all(embedding.in_degree()[mask] > 0)
    assert np.all(embedding.out_degree()[mask] > 0)
    assert np.array_equal(embedding.covered(), variability(embedding) > 0)
    assert np.array_equal(
        variability(embedding), (embedding.in_degree().astype(np.int64) * embedding.out_degree()).sum(axis=3)
    )


def brute_force_footprint(segment, heading, grid, settings):
    """Every cell within 12 of the start and every turn within a full circle, tested one by one."""
    length = sum(np.hypot(*(b - a)) for a, b in zip(segment.path[:, :2], segment.path[1:, :2], strict=False))
    angle = heading * 2 * np.pi / grid.n_headings
    x, y, turn = segment.path[-1]
    end = (np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y)
    cells = [(dx, dy) for dx in range(-12, 13) for dy in range(-12, 13)]
    distance = {(dx, dy): np.hypot(dx * grid.cell_size - end[0], dy * grid.cell_size - end[1]) for dx, dy in cells}
    off = {t: abs(t * grid.heading_step - turn) for t in range(-2 * grid.n_headings, 2 * grid.n_headings + 1)}
    # To each heading by the smallest turn only.
    off = {t: e for t, e in off.items() if e == min(off[u] for u in off if (u - t) % grid.n_headings == 0)}
    kept_cells = [c for c in cells if distance[c] <= settings.position_base + settings.position_rate * length]
    kept_turns = [t for t in off if off[t] <= settings.heading_base + settings.heading_rate * length]
    if settings.rule is FootprintRule.SNAP:
        kept_cells.append(min(cells, key=distance.get))
        kept_turns.append(min(off, key=off.get))
    return {(dx, dy, t) for dx, dy in kept_cells for t in kept_turns}


@given(st.integers(0, 10**6), st.sampled_from(FOOTPRINTS))
def test_footprint_equals_brute_force(seed, settings):
    graph, environment = random_problem(seed, False)
    grid = environment.grid
    for segment in graph.segments:
        fast = footprints(segment, grid, settings)
        found = list(zip(fast.heading.tolist(), fast.dx.tolist(), fast.dy.tolist(), fast.turn.tolist(), strict=True))
        assert found == sorted(set(found))
        for heading in range(0, grid.n_headings, 3):
            slow = brute_force_footprint(segment, heading, grid, settings)
            assert {f[1:] for f in found if f[0] == heading} == slow


@given(st.integers(0, 10**6), st.booleans())
def test_re_embedding_after_a_move_equals_embedding_from_scratch(seed, tiled):
    """A chain of changed obstacles and regions, each embedded with the help of the one before."""
    graph, environment = random_problem(seed, tiled)
    rng = np.random.default_rng(seed)
    previous = embed(graph, environment, EmbeddingSettings(FOOTPRINTS[1]))
    for change in range(4):
        blocked = environment.blocked.copy()
        x, y = rng.integers(0, blocked.shape)
        blocked[x : x + 3, y : y + 3] ^= change != 2  # the third change is none at all
        regions = tuple(replace(r, mask=np.roll(r.mask, int(rng.integers(3)), axis=0)) for r in environment.regions)
        if change == 3:  # another rule for the same tags, or other tags: then nothing may be kept that depends on them
            regions = regions[1:]
        environment = Environment(environment.grid, blocked, regions)
        helped = embed(graph, environment, previous.settings, previous=previous)
        scratch = embed(graph, environment, previous.settings)
        assert helped.planes == scratch.planes
        assert helped.unrolling.valid == scratch.unrolling.valid
        previous = helped


def test_a_previous_embedding_of_something_else_is_no_help():
    """Other footprints, another grid, another graph: the result must not borrow anything from the previous one."""
    graph, environment = random_problem(1, True)
    previous = embed(graph, environment)
    wide = EmbeddingSettings(FOOTPRINTS[1])
    assert embed(graph, environment, wide, previous).planes == embed(graph, environment, wide).planes
    assert embed(graph, environment, wide).n_nodes > previous.n_nodes
    other = random_problem(2, True)
    assert embed(*other, previous=previous).planes == embed(*other).planes


def test_cancelling_is_possible_at_every_step():
    graph, environment = random_problem(1, True)
    fractions = [progress.fraction for progress in embed_steps(graph, environment)]
    n_steps = len(fractions)
    assert n_steps >= 5
    assert fractions == sorted(fractions)
    for stop in range(n_steps):
        steps = embed_steps(graph, environment)
        for _ in range(stop + 1):
            assert 0 <= next(steps).fraction <= 1
        steps.close()


def test_refuses_what_does_not_fit_into_memory():
    graph, environment = random_problem(3, False)
    with pytest.raises(EmbeddingError, match="larger Cell Size"):
        embed(graph, environment, EmbeddingSettings(memory_limit=10))


@pytest.mark.parametrize("tiled", [False, True])
def test_memory_is_estimated_before_the_run(tiled):
    """Against what a run really takes: never less, and not so much more that it refuses what would fit."""
    grid = Grid.over_rectangle((0, 0), (24, 24), 0.125, 24, tiled)
    environment = Environment(grid, np.zeros((192 * 4, 192 * 4), dtype=bool))
    graph = sample_graph()
    estimate = needed_bytes(graph, grid, len(build_stencils(graph.segments, grid, FootprintSettings())))
    tracemalloc.start()
    embed(graph, environment)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < estimate < 2.5 * peak


def test_refuses_links_of_other_segments_and_impossible_footprints():
    graph, environment = random_problem(3, False)
    for links in ([[0, -1]], [[0, 99]], [0, 1]):
        with pytest.raises(EmbeddingError, match="do not join"):
            embed(replace(graph, links=np.array(links)), environment)
    for limit in (-0.1, np.nan, np.inf):
        with pytest.raises(EmbeddingError, match="zero or more"):
            FootprintSettings(heading_rate=limit)


def test_refuses_an_empty_graph():
    _, environment = random_problem(3, False)
    with pytest.raises(EmbeddingError, match="no segments"):
        embed(MotionGraph((), 30.0, (), np.empty((0, 2), dtype=int), np.empty(0)), environment)


def test_one_way_street_is_left_out():
    """A segment that only walks on can never come back on open ground, but does on a torus."""
    path = np.zeros((5, 3))
    path[:, 0] = np.linspace(0, 0.5, 5)
    segment = MotionSegment("on", 0, 0, 4, path, 4 / 30, {})
    graph = MotionGraph((), 30.0, (segment,), np.array([[0, 0]]), np.zeros(1))
    for tiled in (False, True):
        grid = Grid((8, 6, 4), 0.25, (0, 0), tiled)
        environment = Environment(grid, np.zeros((32, 24), dtype=bool))
        embedding = embed(graph, environment)
        # 4 steps of two cells around the 8-cell ring; 3 around the 6-cell one: components of 4 beat those of 3.
        assert embedding.n_nodes == (4 if tiled else 0)
