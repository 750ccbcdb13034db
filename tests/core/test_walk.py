"""Walks: every step is a link of the embedding, and the way is clear in exact geometry."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings, edited_path
from core.embedding.link_reader import LinkReader
from core.environment.environment import EnvironmentSettings, build_environment
from core.environment.grid import Grid
from core.environment.regions import Region, RegionRule
from core.errors import WalkError
from core.playback.walk import WalkSettings, nearest_node, random_walk_steps
from core.progress import finish

from .geometry import box_triangles
from .motion_graphs import recorded_graph, sample_graph
from .reference import explicit_embedding, random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


@given(st.integers(0, 10**6), st.booleans())
def test_every_step_is_a_link_and_every_link_can_be_taken(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    slow = explicit_embedding(embedding.graph, embedding.environment, SETTINGS)
    links = set(map(tuple, slow.links.tolist()))
    walk = finish(random_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(10.0)))
    states = walk.states.copy()
    states[:, :2] %= embedding.shape[:2]
    index = np.ravel_multi_index(states.T, embedding.shape).tolist()
    assert all(pair in links for pair in pairwise(index))

    reader, degree = LinkReader(embedding), embedding.out_degree()
    for node in np.argwhere(embedding.node_mask())[:200].tolist():
        assert len(reader.stencils_from(tuple(node))) == degree[tuple(node)]


@given(st.integers(0, 10**6), st.booleans())
def test_the_root_passes_through_every_grid_element(seed, tiled):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    assume(embedding.n_nodes > 0)
    walk = finish(random_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(5.0)))
    grid = embedding.environment.grid
    at_seams = walk.root_path[walk.node_frames]
    assert np.allclose(at_seams[:, :2], grid.positions(walk.states[:, :2]), atol=1e-9)
    turned = (at_seams[:, 2] - walk.states[:, 2] * grid.heading_step) / (2 * np.pi)
    assert np.allclose(turned, np.rint(turned), atol=1e-9)
    assert walk.duration == pytest.approx(walk.node_frames[-1] / embedding.graph.frame_rate)
    assert walk.duration >= 5.0 - 1e-6
    # No jump anywhere, on a tiled ground neither: steps are as long as those of the clips, plus their edits.
    longest = max(np.linalg.norm(np.diff(s.path[:, :2], axis=0), axis=1).max() for s in embedding.graph.segments)
    edit = np.linalg.norm(embedding.unrolling.stencils.position_error, axis=1).max()
    assert np.linalg.norm(np.diff(walk.root_path[:, :2], axis=0), axis=1).max() <= longest + edit + 1e-9


def test_walks_are_repeatable_and_differ_by_seed():
    embedding = embed(*random_problem(1, True), SETTINGS)
    walks = [
        finish(random_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(20.0))).states
        for seed in (1, 1, 2)
    ]
    assert np.array_equal(walks[0], walks[1])
    assert not np.array_equal(walks[0], walks[2])


# Oriented boxes: centre, half sizes, angle. The last is the step that only "step" frames may cross.
PILLARS = [((2.0, 2.0), (0.2, 0.25), 0.3), ((5.0, 3.0), (0.15, 0.15), 0.8), ((3.2, 6.0), (0.5, 0.15), -0.4)]
STEP = ((3.5, 4.3), (3.5, 0.06), 0.0)
RADIUS, MARGIN = 0.25, 0.12


def box_distance(points, box):
    """(P,) exact distance of points to an oriented box; negative inside."""
    centre, half, angle = box
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    away = np.abs((points - centre) @ turn) - half
    return np.linalg.norm(np.maximum(away, 0), axis=1) + np.minimum(away.max(axis=1), 0)


def box_mesh(box, height):
    centre, half, angle = box
    triangles = box_triangles((-half[0], -half[1], 0), (half[0], half[1], height))
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return triangles @ turn.T + [*centre, 0]


@pytest.fixture(scope="module", params=["sample", "recorded"])
def room(request):
    """A 7 x 8 m room with pillars, for both repertoires."""
    graph = sample_graph() if request.param == "sample" else recorded_graph(request.getfixturevalue("data_folder"))
    regions = []
    if request.param == "sample":
        regions.append(Region("Step", RegionRule.REQUIRE, "step", box_mesh(STEP, 0.2), MARGIN))
    environment = build_environment(
        Grid.over_rectangle((0, 0), (7, 8), 0.125, 24),
        np.concatenate([box_mesh(pillar, 2.2) for pillar in PILLARS]),
        regions,
        EnvironmentSettings(radius=RADIUS),
    )
    return embed(graph, environment)


def test_100_000_steps_without_a_dead_end_or_a_collision(room):
    frame_rate = room.graph.frame_rate
    rng = np.random.default_rng(5)
    steps, crossed = 0, 0
    # In both rooms together.
    while steps < 50_000:
        walk = finish(random_walk_steps(room, rng, WalkSettings(2000.0)))
        steps += len(walk)
        path = walk.root_path[:, :2]
        between = np.concatenate([path, (path[1:] + path[:-1]) / 2])
        for pillar in PILLARS:
            assert box_distance(between, pillar).min() >= RADIUS - 1e-9
        assert np.all((between > 0) & (between < [7, 8]))
        if room.environment.regions:
            tagged = np.zeros(len(path), dtype=bool)
            for i, segment in enumerate(walk.segments):
                tags = room.graph.segments[segment].tags
                if "step" in tags:
                    tagged[walk.node_frames[i] : walk.node_frames[i + 1] + 1] |= tags["step"]
            assert box_distance(path[~tagged], STEP).min() >= MARGIN - 1e-9
            crossed += np.count_nonzero(np.diff(np.sign(path[:, 1] - STEP[0][1])))
        assert walk.duration * frame_rate == len(path) - 1
    if room.environment.regions:
        assert crossed > 20, "the walks never stepped over the step"


def random_steps(embedding, rng, n):
    """About n random links of an embedding: yields (stencil, (m, 2) start cells) for every stencil in use."""
    network, unrolling = embedding.network, embedding.unrolling
    stencils, n_headings = unrolling.stencils, unrolling.stencils.n_headings
    share = n / len(stencils)
    for k, valid in enumerate(unrolling.valid):
        segment, heading, turned = (
            int(a[k]) for a in (stencils.segment, stencils.heading, stencils.destination_heading)
        )
        standing = np.zeros(embedding.shape[:2], dtype=bool)
        for parent in network.parents[segment]:
            standing |= unrolling.layout.unpack(embedding.planes[parent * n_headings + heading])
        there = unrolling.layout.unpack(embedding.planes[segment * n_headings + turned])
        cells = np.argwhere(standing & unrolling.layout.unpack(valid))
        end = cells + [stencils.dx[k], stencils.dy[k]]
        cells = cells[there[end[:, 0], end[:, 1]]]
        if len(cells):
            yield k, cells[rng.integers(len(cells), size=int(np.ceil(share)))]


def distance_of_steps(starts, path, box):
    """How close a path comes to a box from any of the starts (m), or infinite if farther than twice the radius."""
    reach = np.linalg.norm(path, axis=1).max(initial=0.0)
    near = starts[box_distance(starts, box) < reach + 2 * RADIUS]
    return box_distance((near[:, None] + path).reshape(-1, 2), box).min(initial=np.inf)


def test_a_million_steps_keep_their_distance_in_exact_geometry(room):
    """Every frame of every edited path, and the middle between frames, in plane geometry without any grid."""
    stencils, grid, segments = room.unrolling.stencils, room.environment.grid, room.graph.segments
    n_steps, closest, closest_untagged = 0, np.inf, np.inf
    for k, cells in random_steps(room, np.random.default_rng(9), 6e5):
        segment = segments[stencils.segment[k]]
        path = edited_path(
            segment, int(stencils.heading[k]), grid, stencils.position_error[k], stencils.heading_error[k]
        )[:, :2]
        path, starts = np.concatenate([path, (path[1:] + path[:-1]) / 2]), grid.positions(cells)
        assert np.all(starts.min(axis=0) + path.min(axis=0) >= 0)
        assert np.all(starts.max(axis=0) + path.max(axis=0) <= [7, 8])
        closest = min(closest, *(distance_of_steps(starts, path, pillar) for pillar in PILLARS))
        if room.environment.regions:
            tagged = segment.tags.get("step", np.zeros(segment.n_frames, dtype=bool))
            both = np.concatenate([tagged, tagged[1:] & tagged[:-1]])
            closest_untagged = min(closest_untagged, distance_of_steps(starts, path[~both], STEP))
        n_steps += len(cells)
    # In both rooms together.
    assert n_steps >= 500_000
    assert RADIUS - 1e-9 <= closest < RADIUS + 2 * grid.sample_size, "too close, or so careful that space is wasted"
    assert closest_untagged >= MARGIN - 1e-9


def test_nearest_node_is_near(room):
    node = nearest_node(room, (2.0, 2.0), np.random.default_rng(0))
    assert room.node_mask()[node]
    where = room.environment.grid.positions(node[:2])
    assert RADIUS <= box_distance(where[None], PILLARS[0])[0] < RADIUS + 0.3


def test_impossible_walks_say_why(room):
    rng = np.random.default_rng(0)
    with pytest.raises(WalkError, match="positive duration"):
        finish(random_walk_steps(room, rng, WalkSettings(0.0)))
    outside = tuple(np.argwhere(~room.node_mask())[0].tolist())
    with pytest.raises(WalkError, match="no node of the embedding"):
        finish(random_walk_steps(room, rng, WalkSettings(5.0, start=outside)))
    empty = embed(*random_problem(next(s for s in range(99) if not embed(*random_problem(s, False)).n_nodes), False))
    with pytest.raises(WalkError, match="empty"):
        finish(random_walk_steps(empty, rng, WalkSettings(5.0)))
