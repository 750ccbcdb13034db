"""The metrics of an embedding against the links written out one by one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from core import wording
from core.embedding.embedding import EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintSettings, edited_path
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.errors import EvaluationError
from core.evaluation.action_coverage import action_coverage
from core.evaluation.detours import detours_steps, mean_speed
from core.evaluation.environment_coverage import environment_coverage
from core.evaluation.geodesic import Geodesics
from core.evaluation.goals import goal_in_cells
from core.evaluation.link_utility import link_utility
from core.evaluation.maneuverability import maneuverabilities_steps
from core.evaluation.path_efficiency import PathEfficiency, WalkedLengths, path_efficiency_steps
from core.evaluation.reach import time_to_reach_steps
from core.evaluation.segment_groups import Grouping, segment_groups
from core.evaluation.turn_balance import turn_balance
from core.progress import finish

from .motion_graphs import sample_graph
from .reference import random_problem, slow_floor
from .slow_motions import slower

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))
SEEDS = st.integers(0, 10**6)


def random_embedding(seed, tiled, slowness=1):
    graph, environment = random_problem(seed, tiled)
    # A tag is noted only where some frame carries it.
    segments = [replace(s, tags={t: mask for t, mask in s.tags.items() if mask.any()}) for s in graph.segments]
    return embed(slower(replace(graph, segments=tuple(segments)), slowness), environment, SETTINGS)


def room_embedding():
    grid = Grid.over_rectangle((0, 0), (4, 4), 0.25, 8)
    blocked = np.zeros((64, 64), dtype=bool)
    blocked[28:36, 10:36] = True
    return embed(sample_graph(), Environment(grid, blocked))


def all_links(embedding):
    """(L, 3): start node, end node (indices into the raveled shape) and stencil of each link; parallel ones too."""
    mask, shape = embedding.node_mask(), embedding.shape
    stencils = embedding.unrolling.stencils
    found = []
    for k, valid in enumerate(embedding.unrolling.valid):
        for x, y in embedding.unrolling.layout.cells(valid).tolist():
            segment = int(stencils.segment[k])
            end = (
                (x + stencils.dx[k]) % shape[0],
                (y + stencils.dy[k]) % shape[1],
                stencils.destination_heading[k],
                segment,
            )
            for parent in embedding.network.parents[segment]:
                start = (x, y, stencils.heading[k], parent)
                if mask[start] and mask[end]:
                    found.append((np.ravel_multi_index(start, shape), np.ravel_multi_index(end, shape), k))
    return np.array(found, dtype=np.int64).reshape(-1, 3)


@settings(max_examples=60)
@given(SEEDS, st.booleans())
def test_environment_coverage(seed, tiled):
    embedding = random_embedding(seed, tiled)
    found, covered = environment_coverage(embedding), embedding.node_mask().any(axis=3)
    free = slow_floor(embedding.graph, embedding.environment, covered.any(axis=2))
    cell = embedding.environment.grid.cell_size**2
    assert np.array_equal(found.floor, free) and free[covered.any(axis=2)].all()
    inside = np.argwhere(covered).tolist()
    places = {(x, y) for x, y, _ in inside}
    n_free = max(np.count_nonzero(free), 1)
    assert np.array_equal(found.covered, covered)
    assert found.covered_area == pytest.approx(len(places) * cell)
    assert found.position_share == pytest.approx(len(places) / n_free)
    assert found.task_share == pytest.approx(len(inside) / (n_free * covered.shape[2]))
    assert found.by_heading == pytest.approx([sum(i[2] == h for i in inside) / n_free for h in range(covered.shape[2])])
    full = [p for p in places if covered[p].all()]
    assert found.full_area == pytest.approx(len(full) * cell)
    assert "free floor" in found.describe()


@settings(max_examples=60)
@given(SEEDS, st.booleans(), st.sampled_from(Grouping))
def test_action_coverage(seed, tiled, kind):
    embedding = random_embedding(seed, tiled)
    found, links, shape = action_coverage(embedding, kind), all_links(embedding), embedding.shape
    free = slow_floor(embedding.graph, embedding.environment, embedding.covered().any(axis=2))
    assert list(found.actions) == segment_groups(embedding.graph, kind)
    for index, action in enumerate(found.actions):
        begins = np.zeros(shape[:2], dtype=bool)
        for start, end, _ in links.tolist():
            if end % shape[3] in action.segments:
                begins[np.unravel_index(start, shape)[:2]] = True
        assert np.array_equal(found.begins[index], begins)
        n_cells = np.count_nonzero(begins)
        assert found.areas[index] == pytest.approx(n_cells * embedding.environment.grid.cell_size**2)
        assert found.shares[index] == pytest.approx(n_cells / max(np.count_nonzero(free), 1))
    assert found.ranked() == sorted(range(len(found.actions)), key=lambda i: found.areas[i])
    assert found.describe()


@settings(max_examples=60)
@given(SEEDS, st.booleans())
def test_turn_balance(seed, tiled):
    embedding = random_embedding(seed, tiled)
    found, links, shape = turn_balance(embedding), all_links(embedding), embedding.shape
    turn = embedding.unrolling.stencils.turn[links[:, 2]]
    angle = np.zeros((2, *shape[:2]))
    for start, turned in zip(links[:, 0].tolist(), turn.tolist(), strict=True):
        cell = np.unravel_index(start, shape)[:2]
        angle[(int(turned < 0), *cell)] += abs(turned) * embedding.environment.grid.heading_step
    assert np.allclose(found.left, angle[0]) and np.allclose(found.right, angle[1])
    assert (found.n_left, found.n_right, found.n_straight) == ((turn > 0).sum(), (turn < 0).sum(), (turn == 0).sum())
    with np.errstate(invalid="ignore"):
        assert np.allclose(found.balance, (angle[0] - angle[1]) / angle.sum(axis=0), equal_nan=True)
    total = angle.sum(axis=(1, 2))
    assert found.total == pytest.approx((total[0] - total[1]) / total.sum() if total.any() else 0)
    assert found.describe()


def hanging(links, nodes, kept, gone=()):
    """How many of the nodes have no link to them or none from them, among the links kept, or are gone."""
    alive = np.intersect1d(np.intersect1d(nodes, links[kept, 0]), links[kept, 1])
    return len(np.union1d(np.setdiff1d(nodes, alive), np.intersect1d(nodes, gone)))


@settings(max_examples=60)
@given(SEEDS, st.booleans())
def test_link_utility(seed, tiled):
    embedding = random_embedding(seed, tiled)
    found, links, n_segments = link_utility(embedding), all_links(embedding), embedding.shape[3]
    nodes = np.flatnonzero(embedding.node_mask())
    before, after = links[:, 0] % n_segments, links[:, 1] % n_segments
    assert (found.n_links, found.n_nodes) == (len(links), len(nodes))
    for index, (a, b) in enumerate(embedding.graph.links.tolist()):
        plays = (before == a) & (after == b)
        assert found.link_uses[index] == np.count_nonzero(plays)
        assert found.link_dependents[index] == hanging(links, nodes, ~plays)
    for segment in range(n_segments):
        assert found.segment_uses[segment] == np.count_nonzero(after == segment)
        own = nodes[nodes % n_segments == segment]
        # Without its nodes the links to them and from them are gone.
        kept = (before != segment) & (after != segment)
        assert found.segment_dependents[segment] == hanging(links, nodes, kept, own)
    assert np.array_equal(found.idle_links, np.flatnonzero(found.link_uses == 0))
    assert found.describe()


@settings(max_examples=40)
@given(SEEDS, st.booleans(), st.sampled_from(Grouping))
def test_maneuverability(seed, tiled, kind):
    embedding = random_embedding(seed, tiled, 5)
    nodes, links = embedding.to_csr()
    if len(nodes) == 0:
        return
    found = finish(maneuverabilities_steps(embedding, kind))
    assert [m.action for m in found] == segment_groups(embedding.graph, kind)
    start, end = links.nonzero()
    cell = nodes[:, 0] * embedding.shape[1] + nodes[:, 1]
    for one in found:
        able = np.unique(start[np.isin(nodes[end, 3], one.action.segments)])
        if len(able) == 0:
            assert np.isinf(one.mean) and np.isinf(one.worst) and np.isnan(one.floor).all()
            assert "nowhere" in one.describe()
            continue
        seconds = np.round(dijkstra(links.T, indices=able, min_only=True) * 30) / 30
        assert (one.mean, one.worst) == (pytest.approx(seconds.mean()), pytest.approx(seconds.max()))
        assert one.at_once == pytest.approx((seconds == 0).mean())
        assert one.promptly == pytest.approx((seconds <= 1).mean())
        total = np.bincount(cell, seconds, embedding.shape[0] * embedding.shape[1])
        n_nodes = np.bincount(cell, minlength=len(total))
        floor = np.where(n_nodes > 0, total / np.maximum(n_nodes, 1), np.nan)
        assert np.allclose(one.floor.ravel(), floor, equal_nan=True)
        assert one.describe()


def quickest_between(embedding, starts, goals):
    """Seconds from the (n, 2) start cells to the (n, 2) goal cells, best headings, over written-out links."""
    nodes, links = embedding.to_csr()
    cell = nodes[:, 0] * embedding.shape[1] + nodes[:, 1]
    seconds = []
    for start, goal in zip(starts, goals, strict=True):
        there = np.flatnonzero(cell == goal[0] * embedding.shape[1] + goal[1])
        times = dijkstra(sparse.csr_array(links.T), indices=there, min_only=True)
        seconds.append(times[cell == start[0] * embedding.shape[1] + start[1]].min())
    return np.array(seconds)


def slow_walked(embedding, links, start, goal):
    """Metres of the walk that follows written-out links, the quickest and of these the shortest first."""
    shape, graph, known = embedding.shape, embedding.graph, embedding.unrolling.stencils
    frames = {}
    nodes, matrix = embedding.to_csr()
    there = np.flatnonzero((nodes[:, :2] == goal).all(axis=1))
    times = np.round(dijkstra(sparse.csr_array(matrix.T), indices=there, min_only=True) * graph.frame_rate)
    for node, time in zip(nodes, times, strict=True):
        frames[int(np.ravel_multi_index(tuple(node), shape))] = time
    here = [
        (frames[int(np.ravel_multi_index((*start, heading, segment), shape))], segment, heading)
        for segment in range(shape[3])
        for heading in range(shape[2])
        if int(np.ravel_multi_index((*start, heading, segment), shape)) in frames
    ]
    left, segment, heading = min(here)
    node, metres = int(np.ravel_multi_index((*start, heading, segment), shape)), 0.0
    while left > 0:
        ways = []
        for _, end, k in links[links[:, 0] == node].tolist():
            played = graph.segments[known.segment[k]]
            if frames[end] + played.n_frames - 1 == left:
                errors = known.position_error[k], known.heading_error[k]
                path = edited_path(played, int(known.heading[k]), embedding.environment.grid, *errors)
                ways.append((sum(np.hypot(*step) for step in np.diff(path[:, :2], axis=0)), k, end))
        length, _, node = min(ways)
        metres, left = metres + length, frames[node]
    return metres


@settings(max_examples=30)
@given(SEEDS, st.booleans())
def test_the_walked_length_is_that_of_a_quickest_walk(seed, tiled):
    embedding = random_embedding(seed, tiled)
    cells = np.argwhere(embedding.covered().any(axis=2))
    if len(cells) == 0:
        return
    goal, starts, links = cells[seed % len(cells)], cells[:: max(len(cells) // 3, 1)], all_links(embedding)
    mask = np.zeros(embedding.shape[:2], dtype=bool)
    mask[tuple(goal)] = True
    field = finish(time_to_reach_steps(embedding, goal_in_cells(embedding, mask)))
    walked = WalkedLengths(embedding).from_cells(field, starts)
    assert walked == pytest.approx([slow_walked(embedding, links, tuple(start), goal) for start in starts.tolist()])


def test_path_efficiency():
    embedding = room_embedding()
    found = finish(path_efficiency_steps(embedding, np.random.default_rng(5), n_pairs=20, n_goals=6))
    assert len(found.seconds) == 20 and found.n_goals == 6
    covered = embedding.covered().any(axis=2)
    assert covered[tuple(found.starts.T)].all() and covered[tuple(found.goals.T)].all()
    assert np.allclose(found.seconds, quickest_between(embedding, found.starts, found.goals), atol=1e-5)
    geodesics = Geodesics(embedding.environment)
    metres = [geodesics.distances(start)[0][tuple(goal)] for start, goal in zip(found.starts, found.goals, strict=True)]
    assert np.allclose(found.metres, np.minimum(metres, found.walked)) and min(metres) >= 1
    straight = np.linalg.norm((found.starts - found.goals) * embedding.environment.grid.cell_size, axis=1)
    assert np.all(found.walked >= straight - 1e-9)
    assert np.allclose(found.efficiency, found.metres / found.walked)
    assert found.efficiency.min() > 0 and found.efficiency.max() <= 1 and found.efficiency.mean() < 1
    assert found.efficiency[found.worst] == found.efficiency.min()
    assert f"{found.mean:.1%} \u00b1 {found.standard_error:.1%} (20 pairs, 6 goals)" in found.describe()
    again = finish(path_efficiency_steps(embedding, np.random.default_rng(5), n_pairs=20, n_goals=6))
    assert np.array_equal(found.starts, again.starts)


def test_pairs_that_share_a_goal_make_no_mean_surer():
    """The same pairs twice say nothing new; different goals do."""
    goals = np.array([[0, 0], [0, 0], [1, 0], [1, 0], [2, 0], [2, 0]])
    walked = np.array([1.0, 1.0, 2.0, 2.0, 4.0, 4.0])
    found = PathEfficiency(goals, goals, walked, walked, np.ones(6))
    once = PathEfficiency(goals[::2], goals[::2], walked[::2], walked[::2], np.ones(3))
    assert found.standard_error == pytest.approx(once.standard_error)
    assert once.standard_error == pytest.approx(np.std([1, 0.5, 0.25], ddof=1) / np.sqrt(3))
    assert PathEfficiency(goals[:2], goals[:2], walked[:2], walked[:2], np.ones(2)).mean_in_words == "100%"


def test_detours():
    embedding = room_embedding()
    found = finish(detours_steps(embedding, spacing=1.5, radii=(0.8, 1.7)))
    covered = embedding.covered()
    nodes, links = embedding.to_csr()
    geodesics = Geodesics(embedding.environment)
    assert 2 < len(found.goals) < 12
    values = {tuple(place): [] for place in np.argwhere(covered.any(axis=2)).tolist()}
    for goal in found.goals:
        there = np.flatnonzero((nodes[:, :2] == goal).all(axis=1))
        times = np.full(embedding.shape, np.inf)
        times[tuple(nodes.T)] = dijkstra(links.T, indices=there, min_only=True)
        quickest = times.min(axis=3)
        metres = geodesics.distances(goal)[0]
        for place, longer in values.items():
            if 0.8 <= metres[place] <= 1.7:
                seconds = quickest[place][covered[place]].mean()
                longer.append((seconds - metres[place] / found.speed, tuple(goal.tolist())))
    assert sum(len(longer) for longer in values.values()) > 50
    for place in np.ndindex(covered.shape[:2]):
        longer = values.get(place, [])
        assert found.n_near[place] == len(longer)
        if longer:
            assert found.mean[place] == pytest.approx(np.mean([seconds for seconds, _ in longer]), abs=1e-4)
            assert found.worst[place] == pytest.approx(max(longer)[0], abs=1e-4)
            assert tuple(found.worst_goal[place].tolist()) in {goal for s, goal in longer if s > max(longer)[0] - 1e-4}
        else:
            assert np.isnan(found.mean[place]) and np.isnan(found.worst[place])
            assert tuple(found.worst_goal[place]) == (-1, -1)
    assert f"{wording.time(np.nanmax(found.worst))} longer" in found.describe()


def test_what_cannot_be_measured_is_said():
    embedding = room_embedding()
    nothing = finish(restrict_steps(embedding, embedding.network.empty))
    rng = np.random.default_rng(0)
    with pytest.raises(EvaluationError, match="empty"):
        finish(maneuverabilities_steps(nothing, Grouping.CLIP))
    with pytest.raises(EvaluationError, match="No two places"):
        finish(path_efficiency_steps(nothing, rng))
    with pytest.raises(EvaluationError, match="ask for one or more"):
        finish(path_efficiency_steps(embedding, rng, n_pairs=0))
    with pytest.raises(EvaluationError, match="No place"):
        finish(detours_steps(nothing))
    with pytest.raises(EvaluationError, match="cannot be looked at"):
        finish(detours_steps(embedding, radii=(2.0, 1.0)))
    with pytest.raises(EvaluationError, match="speed"):
        finish(detours_steps(embedding, speed=0.0))
    still = [replace(s, path=np.zeros_like(s.path)) for s in embedding.graph.segments]
    with pytest.raises(EvaluationError, match="travels"):
        mean_speed(replace(embedding.graph, segments=tuple(still)))
    for metric in (environment_coverage, action_coverage, turn_balance, link_utility):
        assert metric(nothing).describe()
