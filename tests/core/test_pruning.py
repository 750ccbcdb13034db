"""Local, global and budgeted pruning against explicit links."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.network import StepNetwork
from core.environment.environment import Environment, EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.environment.regions import RegionMask, RegionRule
from core.errors import TuningError
from core.evaluation.size import Objective
from core.evaluation.variability import coverage_share, integrated_variability_steps
from core.progress import finish
from core.tuning.budget import BudgetSettings, Limit, prune_to_budget_steps, table_bytes
from core.tuning.distance_layers import layers_from_steps, layers_to_steps
from core.tuning.filling import FillOrder, filling_steps
from core.tuning.global_pruning import prune_global_steps
from core.tuning.local_pruning import best_nodes_steps, prune_local_steps, ranked_below, ranks_steps
from core.tuning.pruning_curve import pruning_curve_steps
from core.tuning.spanning import Places, covered_places, plan_spanning_steps, spanning_steps

from .geometry import box_triangles
from .motion_graphs import recorded_graph, sample_graph
from .reference import explicit_embedding, random_problem, slow_floor
from .studies import small_graph

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def random_embedding(seed, tiled):
    return embed(*random_problem(seed, tiled), SETTINGS)


def unpacked(embedding):
    """The same embedding, worked on heading by heading as on large grounds."""
    links, n_segments = embedding.graph.links, len(embedding.graph.segments)
    return replace(embedding, known_network=StepNetwork(embedding.unrolling, links, n_segments, packed_bytes=0))


def mask_of(embedding, nodes):
    """(nx, ny, n_headings, n_segments) bool array of a set of nodes."""
    return replace(embedding, planes=nodes.planes).node_mask()


class Explicit:
    """The nodes and links of an embedding, one by one; those between two nodes count as often as there are any."""

    def __init__(self, embedding):
        self.shape = embedding.shape
        slow = explicit_embedding(embedding.graph, embedding.environment, embedding.settings)
        self.nodes, self.links = slow.nodes, slow.links

    def largest(self, kept):
        """Node mask and number of links of the largest component of a bool mask of nodes."""
        kept = kept.ravel()
        links = self.links[kept[self.links].all(axis=1)]
        n = kept.size
        pairs = np.unique(links, axis=0)
        matrix = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
        _, label = connected_components(matrix, connection="strong")
        size = np.bincount(label, weights=kept)
        looped = np.zeros(len(size), dtype=bool)
        looped[label[pairs[pairs[:, 0] == pairs[:, 1], 0]]] = True
        size[(size == 1) & ~looped] = 0
        if size.max(initial=0) == 0:
            return np.zeros(self.shape, dtype=bool), 0
        first = np.flatnonzero(kept & (size[label] == size.max()))[0]
        mask = label == label[first]
        return mask.reshape(self.shape), int(mask[links].all(axis=1).sum())

    def ways(self, mask):
        """Segment variability of a bool mask of nodes."""
        links = self.links[mask.ravel()[self.links].all(axis=1)]
        into, out = (np.bincount(links[:, end], minlength=mask.size) for end in (1, 0))
        return (into * out).reshape(self.shape)


def slow_best(ways, mask, k):
    """At each p the k nodes of highest variability, one place after the other."""
    best = np.zeros_like(mask)
    for place in np.ndindex(mask.shape[:3]):
        there = sorted(np.flatnonzero(mask[place]).tolist(), key=lambda s: (-ways[place][s], s))
        best[place][there[:k]] = True
    return best


def is_strongly_connected(embedding):
    _, links = embedding.to_csr()
    return connected_components(links, connection="strong")[0] <= 1


# Local pruning -------------------------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.booleans(), st.booleans())
def test_local_pruning_equals_the_explicit_one(seed, tiled, packed):
    embedding = random_embedding(seed, tiled)
    embedding = embedding if packed else unpacked(embedding)
    slow = Explicit(embedding)
    mask = embedding.node_mask()
    ways = slow.ways(mask)
    for k in range(1, embedding.shape[3] + 1):
        best = slow_best(ways, mask, k)
        assert np.array_equal(mask_of(embedding, finish(best_nodes_steps(embedding, k))), best)
        nodes, n_links = slow.largest(best)
        pruned = finish(prune_local_steps(embedding, k))
        assert np.array_equal(pruned.node_mask(), nodes)
        assert pruned.n_links == n_links
        assert is_strongly_connected(pruned)


def test_random_problems_lose_nodes_and_links():
    """Guards the tests here: pruning must have something to drop, and break components apart."""
    n_smaller = n_broken = n_kept = 0
    for seed in range(40):
        embedding = random_embedding(seed, seed % 2 == 0)
        best = finish(best_nodes_steps(embedding, 1))
        pruned = finish(prune_local_steps(embedding, 1))
        n_best = int(mask_of(embedding, best).sum())
        n_smaller += n_best < embedding.n_nodes
        n_broken += pruned.n_nodes < n_best
        n_kept += 0 < pruned.n_nodes < embedding.n_nodes
    assert n_smaller > 10 and n_broken > 5 and n_kept > 5


def test_random_problems_have_places_of_equal_variability():
    """Guards the order of equal nodes."""
    n_ties = 0
    for seed in range(20):
        embedding = random_embedding(seed, False)
        ways, mask = embedding.in_degree().astype(np.int64) * embedding.out_degree(), embedding.node_mask()
        for place in np.ndindex(mask.shape[:3]):
            there = ways[place][mask[place]]
            n_ties += len(np.unique(there)) < len(there)
    assert n_ties > 10


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.booleans(), st.booleans())
# Here the largest component of some k is not the one that grows out of that of the k before.
@example(28, True, True)
@example(107, False, True)
def test_curve_equals_pruning_for_every_k(seed, tiled, packed):
    embedding = random_embedding(seed, tiled)
    embedding = embedding if packed else unpacked(embedding)
    ranks = finish(ranks_steps(embedding))
    curve = finish(pruning_curve_steps(embedding))
    largest_place = int(embedding.node_mask().sum(axis=3).max())
    assert curve.k.tolist() == list(range(1, largest_place + 1))
    for row, k in enumerate(curve.k.tolist()):
        assert ranked_below(embedding, ranks, k) == finish(best_nodes_steps(embedding, k))
        pruned = finish(prune_local_steps(embedding, k))
        assert (curve.n_nodes[row], curve.n_links[row]) == (pruned.n_nodes, pruned.n_links)
        assert curve.floor_coverage[row] == pytest.approx(coverage_share(pruned))
        covered = pruned.covered()
        free = slow_floor(embedding.graph, embedding.environment, embedding.covered().any(axis=2))
        share = covered.sum() / max(free.sum() * embedding.shape[2], 1)
        assert curve.coverage[row] == pytest.approx(share)
    if len(curve.k):
        assert curve.n_links[-1] == embedding.n_links
        for wanted in (0.0, curve.floor_coverage[-1] / 2, curve.floor_coverage[-1], 1.01):
            rows = [i for i in range(len(curve.k)) if (curve.floor_coverage[i:] >= wanted).all()]
            assert curve.smallest_k(wanted) == (curve.k[rows[0]] if rows else None)


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.booleans(), st.integers(1, 6))
def test_local_pruning_never_adds_anything(seed, tiled, k):
    embedding = random_embedding(seed, tiled)
    pruned = finish(prune_local_steps(embedding, k))
    assert not np.any(pruned.node_mask() & ~embedding.node_mask())
    assert not np.any(pruned.covered() & ~embedding.covered())
    assert pruned.n_links <= embedding.n_links
    everything = finish(prune_local_steps(embedding, embedding.shape[3]))
    assert everything.planes == embedding.planes and everything.n_links == embedding.n_links


@pytest.mark.parametrize("k", [0, -1, 1.5])
def test_local_pruning_keeps_at_least_one_segment(k):
    with pytest.raises(TuningError, match="keep at least 1"):
        finish(prune_local_steps(random_embedding(3, False), k))


def test_pruning_may_be_stopped_at_any_step():
    embedding = next(e for e in (random_embedding(seed, False) for seed in range(99)) if e.n_nodes)
    fractions = []
    finish(prune_local_steps(embedding, 1), lambda progress: fractions.append(progress.fraction))
    assert len(fractions) > 1 and fractions == sorted(fractions) and fractions[-1] <= 1
    for n in range(len(fractions)):
        steps = prune_local_steps(embedding, 1)
        for _ in range(n + 1):
            next(steps)
        steps.close()


# Global pruning ------------------------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.booleans())
def test_global_pruning_equals_the_explicit_one(seed, tiled):
    embedding = random_embedding(seed, tiled)
    slow = Explicit(embedding)
    n_segments = embedding.shape[3]
    mask, left, expected = embedding.node_mask(), list(range(n_segments)), []
    while len(left) > 1:
        sums = slow.ways(mask).sum(axis=(0, 1, 2))
        worst = min(left, key=lambda s: (sums[s], s))
        left.remove(worst)
        kept = mask.copy()
        kept[..., worst] = False
        mask, n_links = slow.largest(kept)
        expected.append((worst, int(sums[worst]), int(mask.sum()), n_links))
    found = finish(prune_global_steps(embedding, 1))
    assert [(d.segment, d.variability, d.n_nodes, d.n_links) for d in found.dropped] == expected
    assert np.array_equal(found.embedding.node_mask(), mask)
    assert sorted({*range(embedding.shape[3])} - {drop.segment for drop in found.dropped}) == list(left)
    assert all(drop.name == embedding.graph.segments[drop.segment].name for drop in found.dropped)
    half = finish(prune_global_steps(embedding, (n_segments + 1) // 2))
    assert half.dropped == found.dropped[: n_segments // 2]
    everything = finish(prune_global_steps(embedding, n_segments))
    assert everything.embedding is embedding and everything.dropped == ()


def test_global_pruning_to_a_number_of_segments_that_there_is():
    embedding = random_embedding(3, False)
    for n in (0, embedding.shape[3] + 1, 1.5):
        with pytest.raises(TuningError, match="cannot be pruned"):
            finish(prune_global_steps(embedding, n))


# Skeletons and filling -----------------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.booleans(), st.booleans(), st.sampled_from(Places))
def test_skeletons_are_strongly_connected_and_cover_what_is_wanted(seed, tiled, packed, places):
    embedding = random_embedding(seed, tiled)
    embedding = embedding if packed else unpacked(embedding)
    assume(embedding.n_nodes)
    plan = finish(plan_spanning_steps(embedding, places))
    covered = covered_places(embedding, places)
    assert np.array_equal(plan.depth >= 0, covered)
    for wanted in (covered, covered & (np.random.default_rng(seed).random(covered.shape) < 0.4)):
        nodes = mask_of(embedding, finish(spanning_steps(plan, wanted)))
        assert not np.any(nodes & ~embedding.node_mask())
        there = nodes.any(axis=3)
        there = there.any(axis=2, keepdims=True) if places is Places.CELLS else there
        assert np.all(there[wanted])
        _, links = embedding.to_csr()
        chosen = np.flatnonzero(nodes[embedding.node_mask()])
        inside = links[chosen][:, chosen]
        assert inside.nnz and connected_components(inside, connection="strong")[0] == 1


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.booleans())
def test_layers_are_distances_in_links(seed, tiled):
    embedding = random_embedding(seed, tiled)
    assume(embedding.n_nodes)
    nodes, links = embedding.to_csr()
    x, y, heading, segment = nodes[seed % len(nodes)].tolist()
    start = embedding.network.node(segment, heading, x, y)
    for steps, matrix in ((layers_from_steps, links), (layers_to_steps, links.T)):
        layers = finish(steps(embedding, start))
        distances = dijkstra(matrix.tocsr(), unweighted=True, indices=seed % len(nodes))
        assert layers.n_layers == distances.max() + 1
        for distance in range(layers.n_layers):
            found = np.argwhere(mask_of(embedding, layers.layer(distance)))
            assert np.array_equal(found, nodes[distances == distance])


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.booleans(), st.sampled_from(FillOrder))
def test_filling_takes_the_best_first(seed, tiled, order):
    embedding = random_embedding(seed, tiled)
    filling = finish(filling_steps(embedding, order))
    mask, ways = embedding.node_mask(), embedding.in_degree().astype(np.int64) * embedding.out_degree()
    assert filling.nodes(filling.n_steps) == embedding.nodes
    taken = np.zeros_like(mask)
    for n_steps in np.linspace(0, filling.n_steps, 9).astype(int).tolist():
        nodes = mask_of(embedding, filling.nodes(n_steps))
        assert not np.any(taken & ~nodes)
        taken = nodes
        if order is FillOrder.VARIABILITY and nodes.any() and (mask & ~nodes).any():
            assert ways[nodes].min() >= ways[mask & ~nodes].max()
        if order is FillOrder.PLACES:
            for place in np.argwhere(nodes.any(axis=3) & (mask & ~nodes).any(axis=3)).tolist():
                here = tuple(place)
                assert ways[here][nodes[here]].min() >= ways[here][mask[here] & ~nodes[here]].max()


# Budgets -------------------------------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(
    st.integers(0, 10**6),
    st.booleans(),
    st.sampled_from(Limit),
    st.sampled_from(Places),
    st.sampled_from([0.0, 0.1, 0.5, 1.0]),
    st.sampled_from([0.0, 0.2, 0.5, 0.9, 1.0]),
    st.sampled_from([None, *FillOrder]),
)
def test_budgets_keep_their_promises(seed, tiled, limit, places, loss, share, order):
    embedding = random_embedding(seed, tiled)
    costs = (embedding.n_nodes, embedding.n_links)
    before = embedding.n_links if limit is Limit.LINKS else table_bytes(*costs)
    wanted = BudgetSettings(limit, int(before * share), places, loss)
    found = finish(prune_to_budget_steps(embedding, wanted, order))
    result = found.embedding
    cost = result.n_links if limit is Limit.LINKS else table_bytes(result.n_nodes, result.n_links)
    assert (found.cost, found.cost_before) == (cost, before)
    assert found.met == (cost <= wanted.budget)
    kept, covered = covered_places(result, places), covered_places(embedding, places)
    assert (found.places, found.places_before) == (kept.sum(), covered.sum())
    assert found.places >= (1 - loss) * found.places_before - 1e-6
    assert found.coverage_kept >= 1 - loss - 1e-9
    assert is_strongly_connected(result) and (result.n_nodes == 0) == (result.n_links == 0)
    assert not np.any(result.node_mask() & ~embedding.node_mask())
    if share == 1.0:
        assert found.met and result is embedding
    assert ("cannot be met" in found.describe()) != found.met


def test_random_problems_meet_some_budgets_and_miss_others():
    """Guards the test above."""
    met = []
    for seed in range(40):
        embedding = random_embedding(seed, False)
        if embedding.n_nodes:
            met.append(finish(prune_to_budget_steps(embedding, BudgetSettings(budget=embedding.n_links // 3))).met)
    assert any(met) and not all(met)


def corner(graph, cell_size, n_headings):
    """A crop of a room, 4 x 3.5 m, with a pillar."""
    grid = Grid.over_rectangle((0, 0), (4, 3.5), cell_size, n_headings)
    pillar = box_triangles((1.5, 1, 0), (2.2, 1.4, 2))
    return embed(graph, build_environment(grid, pillar, settings=EnvironmentSettings(radius=0.25)))


@pytest.fixture(scope="module")
def real(data_folder):
    return corner(recorded_graph(data_folder), 0.125, 12)


@pytest.fixture(scope="module")
def sample():
    return corner(sample_graph(), 0.25, 8)


def test_recorded_motion_pruned_locally(real):
    mask, ways = real.node_mask(), real.in_degree().astype(np.int64) * real.out_degree()
    nodes, links = real.to_csr()
    n_nodes, n_links, n_places = real.n_nodes, real.n_links, 10**9
    order = np.argsort(np.argsort(-np.where(mask, ways, -1), axis=3, kind="stable"), axis=3)
    for k in (8, 3):
        best = finish(best_nodes_steps(real, k))
        assert np.array_equal(mask_of(real, best), mask & (order < k))
        pruned = finish(prune_local_steps(real, k))
        chosen = np.flatnonzero(order[tuple(nodes.T)] < k)
        inside = links[chosen][:, chosen]
        _, label = connected_components(inside, connection="strong")
        largest = np.bincount(label).argmax()
        assert np.array_equal(np.argwhere(pruned.node_mask()), nodes[chosen[label == largest]])
        covered = int(pruned.covered().sum())
        assert (pruned.n_nodes, pruned.n_links, covered) < (n_nodes, n_links, n_places)
        n_nodes, n_links, n_places = pruned.n_nodes, pruned.n_links, covered


@pytest.mark.parametrize("places", Places)
def test_a_budget_keeps_more_coverage_than_the_k_rule_with_as_many_links(sample, places):
    for k, factor in ((2, 1.0), (6, 1.5)):
        by_rule = finish(prune_local_steps(sample, k))
        wanted = BudgetSettings(budget=by_rule.n_links, places=places, coverage_loss=1.0)
        found = finish(prune_to_budget_steps(sample, wanted))
        assert found.met and found.cost <= by_rule.n_links
        assert found.places >= factor * covered_places(by_rule, places).sum()


def test_a_budget_is_used_up(sample):
    skeleton = finish(prune_to_budget_steps(sample, BudgetSettings(budget=0)))
    assert not skeleton.met and skeleton.coverage_kept == 1
    assert skeleton.cost < sample.n_links / 4
    assert "The budget of 0 links cannot be met" in skeleton.describe()
    budget = sample.n_links // 3
    for order in (None, FillOrder.VARIABILITY):
        found = finish(prune_to_budget_steps(sample, BudgetSettings(budget=budget), order))
        assert found.met and found.coverage_kept == 1 and found.cost > 0.99 * budget
        assert "keep 100% of the cells" in found.describe()
    exactly = finish(prune_to_budget_steps(sample, BudgetSettings(budget=skeleton.cost)))
    assert exactly.met and exactly.embedding.planes == skeleton.embedding.planes


def seconds_to_corner(embedding):
    """Mean shortest time from every node to the cells in the corner (0, 0), over explicit links."""
    nodes, links = embedding.to_csr()
    if not len(nodes):
        return np.inf
    goal = np.flatnonzero((nodes[:, 0] < 6) & (nodes[:, 1] < 6))
    if not len(goal):
        return np.inf
    return float(dijkstra(links.T.tocsr(), indices=goal, min_only=True).mean())


@pytest.fixture(scope="module")
def small(sample):
    """What the sample character's walk and turns make of the corner: few links, so that they can be written out."""
    return finish(prune_local_steps(sample, 3))


TIME = Objective("mean time to the corner", "s", seconds_to_corner)


def test_a_measure_is_kept_even_where_the_budget_is_not(small):
    before = seconds_to_corner(small)
    loose = BudgetSettings(budget=small.n_links // 2, objective=TIME, objective_growth=1.5)
    found = finish(prune_to_budget_steps(small, loose))
    assert found.met and found.objective_before == before
    assert found.objective == seconds_to_corner(found.embedding) <= 1.5 * before
    assert "with a mean time to the corner of" in found.describe() and " s instead of " in found.describe()
    tight = replace(loose, budget=small.n_links // 20, objective_growth=1.02)
    found = finish(prune_to_budget_steps(small, tight))
    assert not found.met and found.cost < small.n_links
    assert seconds_to_corner(found.embedding) <= 1.02 * before
    assert found.coverage_kept == 1 and is_strongly_connected(found.embedding)


def test_a_measure_that_is_not_a_number_keeps_everything(small):
    nothing = Objective("nothing", "", lambda embedding: 1.0 if embedding is small else float("nan"))
    found = finish(prune_to_budget_steps(small, BudgetSettings(budget=small.n_links // 2, objective=nothing)))
    assert found.embedding is small and not found.met


def test_empty_embeddings_stay_empty():
    grid = Grid((6, 5, 4), 0.2)
    nothing = embed(sample_graph(), Environment(grid, np.ones((24, 20), dtype=bool)))
    assert finish(prune_local_steps(nothing, 2)).n_nodes == 0
    assert (
        len(finish(pruning_curve_steps(nothing)).k) == 0
        and finish(pruning_curve_steps(nothing)).smallest_k(0.5) is None
    )
    assert finish(prune_global_steps(nothing, 1)).embedding.n_nodes == 0
    assert not finish(integrated_variability_steps(nothing)).any()
    found = finish(prune_to_budget_steps(nothing, BudgetSettings(budget=0)))
    assert found.met and found.coverage_kept == 1


@pytest.mark.parametrize(
    ("bad", "message"),
    [({"budget": -1}, "no budget"), ({"coverage_loss": 1.2}, "from 0 to 1"), ({"objective_growth": 0.9}, "1 or more")],
)
def test_bad_budgets(bad, message):
    with pytest.raises(TuningError, match=message):
        BudgetSettings(**bad)


def test_table_bytes():
    assert table_bytes(0, 0) == 4
    assert table_bytes(10, 25) == 10 * 12 + 25 * 4 + 4


@pytest.mark.parametrize("seed", range(20))
def test_what_pruning_loses_stays_part_of_the_floor(seed):
    """Where a tunnel asks for a tag, too: losing it is no gain, and the k that is said to keep a share does."""
    rng, graph, grid = np.random.default_rng(seed), small_graph(), Grid((12, 12, 8), 0.5)
    tagged = [replace(s, tags={"low": np.full(s.n_frames, rng.random() < 0.15)}) for s in graph.segments]
    tunnel = np.zeros((48, 48), dtype=bool)
    tunnel[:, 24:] = True
    environment = Environment(
        grid, np.zeros((48, 48), dtype=bool), (RegionMask("tunnel", RegionRule.REQUIRE, "low", tunnel),)
    )
    embedding = embed(replace(graph, segments=tuple(tagged)), environment)
    curve, whole = finish(pruning_curve_steps(embedding)), embedding.covered().any(axis=2).sum()
    for share in (0.5, 0.9, 0.98):
        k = curve.smallest_k(share * curve.floor_coverage[-1]) if whole else None
        if k is not None:
            assert finish(prune_local_steps(embedding, k)).covered().any(axis=2).sum() >= share * whole - 1e-6
