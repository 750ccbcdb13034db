"""Directed walks: exact least times, by Dijkstra over explicit links; of all quickest walks the one edited least."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.embedding.link_reader import LinkReader
from core.environment.environment import build_environment
from core.environment.grid import Grid
from core.errors import WalkError
from core.evaluation.goals import goal_at
from core.evaluation.why_not import Reason, why_not_steps
from core.playback.destination import destination, reason_at
from core.playback.directed import walk_through_steps
from core.playback.prices import HEADING_LEVER, LinkPrices, PriceSettings, link_edits
from core.playback.time_to_go import rows_of
from core.playback.walk import random_node
from core.progress import finish
from tests.bench import problems

from .explicit_walks import assert_links, explicit_links, some_nodes
from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def number_of(nodes):
    """Row of each node in the list of ``to_csr``."""
    return {tuple(node): row for row, node in enumerate(nodes.tolist())}


@given(st.integers(0, 10**6), st.booleans())
def test_shortest_walks_take_the_time_that_dijkstra_says(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 1)
    rng = np.random.default_rng(seed)
    nodes, links = embedding.to_csr()
    goal, start = rng.permutation(len(nodes))[:2]
    expected = dijkstra(links, indices=start)[goal]
    walk = finish(walk_through_steps(embedding, tuple(nodes[start].tolist()), [some_nodes(embedding, nodes[[goal]])]))
    assert_links(walk)
    assert walk.duration == pytest.approx(expected)
    assert tuple(walk.states[0]) == tuple(nodes[start])
    end = walk.states[-1].copy()
    end[:2] %= embedding.shape[:2]
    assert tuple(end) == tuple(nodes[goal])
    # No place is passed twice, and in the middle of the way the rest of it is the quickest, too.
    middle = tuple(walk.states[len(walk) // 2].tolist())
    middle = (middle[0] % embedding.shape[0], middle[1] % embedding.shape[1], *middle[2:])
    if middle != tuple(nodes[goal]):
        rest = finish(walk_through_steps(embedding, middle, [some_nodes(embedding, nodes[[goal]])]))
        assert rest.duration == pytest.approx(walk.duration - walk.node_frames[len(walk) // 2] / 30)


@given(st.integers(0, 10**6), st.booleans(), st.integers(1, 3))
def test_waypoints_are_passed_in_the_least_time_of_the_whole(seed, tiled, n_goals):
    """Layer after layer, from the last goal to the first: the definition, over explicit times between all nodes."""
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(1 < embedding.n_nodes < 1500)
    rng = np.random.default_rng(seed)
    nodes, links = embedding.to_csr()
    apart = np.rint(dijkstra(links) * 30)
    goals = [rng.permutation(len(nodes))[: rng.integers(1, 6)] for _ in range(n_goals)]
    left = np.zeros(len(nodes))
    for goal in reversed(goals):
        left = (apart[:, goal] + left[goal]).min(axis=1)
    starts = rng.permutation(len(nodes))[: rng.integers(1, 4)]
    assume(left[starts].min() > 0)
    given_starts = some_nodes(embedding, nodes[starts])
    walk = finish(walk_through_steps(embedding, given_starts, [some_nodes(embedding, nodes[goal]) for goal in goals]))
    assert_links(walk)
    assert walk.node_frames[-1] == left[starts].min()
    # It stands at a node of every goal, in order.
    number = number_of(nodes)
    states = LinkReader(embedding).wrapped(walk.states)
    passed = [number[tuple(state)] for state in states.tolist()]
    assert passed[0] in starts
    at = 0
    for goal in goals:
        while passed[at] not in goal:
            at += 1
    # Limits: exactly this time is enough.
    goals = [some_nodes(embedding, nodes[goal]) for goal in goals]
    again = finish(walk_through_steps(embedding, given_starts, goals, limit=walk.duration))
    assert np.array_equal(again.states, walk.states)
    if walk.node_frames[-1] > 1:
        with pytest.raises(WalkError, match="within"):
            finish(walk_through_steps(embedding, given_starts, goals, limit=walk.duration - 1 / 30))


@given(st.integers(0, 10**6), st.booleans())
def test_of_all_quickest_walks_the_root_is_edited_least(seed, tiled):
    """Dijkstra over time first and edits second: one frame counts far more than all edits together."""
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(1 < embedding.n_nodes < 2000)
    rng = np.random.default_rng(seed)
    reader = LinkReader(embedding)
    nodes, _ = embedding.to_csr()
    number = number_of(nodes)
    rows, stencils = reader.links_from(nodes)
    ends = reader.wrapped(reader.ends(nodes[rows], stencils))
    edits = link_edits(embedding)
    frames = np.array([s.n_frames - 1 for s in embedding.graph.segments])[ends[:, 3]]
    goal, start = rng.permutation(len(nodes))[:2].tolist()
    least = {start: (0, 0.0)}
    out = [[] for _ in nodes]
    for row, end, link_frames, stencil in zip(rows.tolist(), ends.tolist(), frames.tolist(), stencils, strict=True):
        out[row].append((number[tuple(end)], link_frames, float(edits[stencil])))
    waiting = {start}
    while waiting:
        node = min(waiting, key=least.__getitem__)
        waiting.remove(node)
        for end, link_frames, edit in out[node]:
            found = (least[node][0] + link_frames, least[node][1] + edit)
            if end not in least or found < least[end]:
                least[end] = found
                waiting.add(end)
    walk = finish(walk_through_steps(embedding, tuple(nodes[start].tolist()), [some_nodes(embedding, nodes[[goal]])]))
    assert (walk.node_frames[-1], edits[walk.stencils].sum()) == pytest.approx(least[goal], abs=1e-9)


def test_edits_are_those_of_the_paths():
    embedding = embed(*random_problem(1, True), SETTINGS)
    stencils = embedding.unrolling.stencils
    k = len(stencils) // 2
    expected = np.sqrt((stencils.position_error[k] ** 2).sum() + (HEADING_LEVER * stencils.heading_error[k]) ** 2)
    assert link_edits(embedding)[k] == pytest.approx(expected)


@pytest.fixture(scope="module")
def room():
    return embed(sample_graph(), problems.room())


def disc(embedding, centre, radius):
    """All nodes within a radius of a place."""
    grid = embedding.environment.grid
    cells = np.stack(np.meshgrid(*map(np.arange, grid.shape[:2]), indexing="ij"), axis=-1)
    near = embedding.unrolling.layout.pack(np.linalg.norm(grid.positions(cells) - centre, axis=2) <= radius)
    return embedding.nodes.on(near)


def test_a_way_across_a_real_room(room):
    start, corners = disc(room, (1, 1), 0.2), [(6, 7), (6, 1), (1, 7)]
    goals = [disc(room, corner, 0.3) for corner in corners]
    walk = finish(walk_through_steps(room, start, goals))
    assert_links(walk)
    places = walk.root_path[walk.node_frames, :2]
    for corner in corners:
        assert np.linalg.norm(places - corner, axis=1).min() <= 0.3
    # No quicker than running straight, and no slower than leg by leg without looking ahead.
    speed = max(np.linalg.norm(s.path[-1, :2]) / s.duration for s in room.graph.segments) * 1.1
    straight = sum(np.linalg.norm(np.subtract(a, b)) for a, b in pairwise([(1, 1), *corners])) - 0.3 * 6
    leg, total = start, 0.0
    for goal in goals:
        if not np.any([leg == goal]) and not (isinstance(leg, tuple) and leg in goal_set(room, goal)):
            way = finish(walk_through_steps(room, leg, [goal]))
            total += way.duration
            leg = tuple(way.states[-1].tolist())
    assert straight / speed <= walk.duration <= total + 1e-6


def goal_set(embedding, goal):
    return set(map(tuple, rows_of(embedding, goal).tolist()))


def test_the_rows_of_a_set_are_its_nodes():
    embedding = embed(*random_problem(1, True), SETTINGS)
    assert rows_of(embedding, embedding.nodes).shape == (embedding.n_nodes, 4)
    assert goal_set(embedding, embedding.nodes) == set(map(tuple, np.argwhere(embedding.node_mask()).tolist()))


def test_impossible_walks_say_why(room):
    node = tuple(np.argwhere(room.node_mask())[0].tolist())
    nowhere = room.network.empty
    with pytest.raises(WalkError, match="stands at the goal already"):
        finish(walk_through_steps(room, node, [room.nodes]))
    with pytest.raises(WalkError, match="stands at the goal;"):
        finish(walk_through_steps(room, node, [nowhere]))
    with pytest.raises(WalkError, match="stands at goal 2"):
        finish(walk_through_steps(room, node, [room.nodes, nowhere]))
    with pytest.raises(WalkError, match="start is no node"):
        finish(walk_through_steps(room, nowhere, [room.nodes]))
    with pytest.raises(WalkError, match="nowhere to go"):
        finish(walk_through_steps(room, node, []))
    with pytest.raises(WalkError, match="positive time"):
        finish(walk_through_steps(room, node, [room.nodes], limit=0.0))
    with pytest.raises(WalkError, match=r"within 1 s.*Allow more time"):
        finish(walk_through_steps(room, disc(room, (1, 1), 0.2), [disc(room, (6, 7), 0.3)], limit=1.0))


def test_destinations_say_why_nobody_gets_there(room):
    goal = goal_set(room, destination(room, (6.0, 7.0), 0.3, heading=0.0, tolerance=0.3))
    assert goal
    grid = room.environment.grid
    for x, y, heading, _ in goal:
        assert np.linalg.norm(grid.positions([x, y]) - [6.0, 7.0]) <= 0.3 + grid.cell_size
        assert abs((heading * grid.heading_step + np.pi) % (2 * np.pi) - np.pi) <= 0.3 + 1e-6
    with pytest.raises(WalkError, match="off the ground"):
        destination(room, (70.0, 7.0))
    reasons, free = finish(why_not_steps(room)), room.environment.free_cells()
    blocked = grid.positions(np.argwhere(~free)[0])
    assert reason_at(room, blocked) is Reason.BLOCKED
    with pytest.raises(WalkError, match="An obstacle is closer than the character's radius"):
        destination(room, blocked)
    for cell in np.argwhere(free & ~room.covered().any(axis=2))[:3]:
        assert reason_at(room, grid.positions(cell)) in reasons[tuple(cell)]
        with pytest.raises(WalkError, match="nearest place that can be"):
            destination(room, grid.positions(cell))


@given(st.integers(0, 10**6), st.booleans(), st.sampled_from([0.3, 0.5, 1.0]))
@settings(max_examples=25, deadline=None)
def test_a_smoother_walk_is_the_cheapest_of_the_explicit_links_within_its_time(seed, tiled, smoothness):
    """All ways that take so much longer than the quickest one at the most, frame by frame, over single links."""
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 1)
    rng, reader = np.random.default_rng(seed), LinkReader(embedding)
    start, goal = (tuple(row) for row in reader.wrapped(np.array([random_node(embedding, rng) for _ in "ab"])).tolist())
    assume(start != goal)
    goals = [some_nodes(embedding, np.array([goal]))]
    quickest = finish(walk_through_steps(embedding, start, goals))
    assume(len(quickest) <= 4)
    weight = smoothness / max(1 - smoothness, 0.05)
    prices, longest = (
        LinkPrices(embedding, PriceSettings().times(weight)),
        int(quickest.node_frames[-1] * (1 + smoothness)),
    )
    links = cache(lambda node: explicit_links(embedding, node))

    def price(node, stencil):
        return int(prices.of(np.array([node[3]]), np.array([stencil]))[0])

    reached: dict[tuple[int, tuple[int, ...]], float] = {(0, start): 0}
    least = np.inf
    while reached:
        spent, node = min(reached)
        so_far = reached.pop((spent, node))
        for stencil, end in links(node):
            then, total = spent + embedding.graph.segments[end[3]].n_frames - 1, so_far + price(node, stencil)
            if end == goal and then <= longest:
                least = min(least, total)
            elif then < longest:
                reached[then, end] = min(reached.get((then, end), np.inf), total)
    walk = finish(walk_through_steps(embedding, start, goals, smoothness=smoothness))
    assert_links(walk)
    assert quickest.node_frames[-1] <= walk.node_frames[-1] <= longest
    states = reader.wrapped(walk.states)
    assert tuple(states[0]) == start and tuple(states[-1]) == goal
    assert sum(price(tuple(a), k) for a, k in zip(states[:-1].tolist(), walk.stencils.tolist(), strict=True)) == least


def test_smoother_walks_past_several_places_keep_within_their_time():
    embedding = embed(sample_graph(), build_environment(Grid.over_rectangle((0, 0), (5, 5), 0.25, 12), []))
    rng, prices, waits = np.random.default_rng(2), LinkPrices(embedding), []
    for _ in range(6):
        start, *places = (random_node(embedding, rng) for _ in range(4))
        goals = [goal_at(embedding, embedding.environment.grid.positions(np.array(p[:2])), 0.3) for p in places]
        found = [finish(walk_through_steps(embedding, start, goals, smoothness=s)) for s in (0.0, 0.5, 1.0)]
        for walk, s in zip(found, (0.0, 0.5, 1.0), strict=True):
            assert_links(walk)
            assert walk.node_frames[-1] <= (1 + s) * found[0].node_frames[-1]
            # They come by the places in their order.
            at = 0
            for place in places:
                away = np.linalg.norm(
                    embedding.environment.grid.positions(walk.states[at:, :2])
                    - embedding.environment.grid.positions(np.array(place[:2])),
                    axis=1,
                )
                at += int(np.flatnonzero(away <= 0.3 + 1e-9)[0])
        waits.append([prices.of(walk.states[:-1, 3], walk.stencils).sum() - 1000 * walk.duration for walk in found])
    means = np.mean(waits, axis=0)
    assert means[1] < 0.7 * means[0] and means[2] < means[1]
    with pytest.raises(WalkError, match="between 0 and 1"):
        finish(walk_through_steps(embedding, start, goals, smoothness=2.0))
