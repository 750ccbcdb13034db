"""Goals as sets of nodes, against the nodes looked at one by one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.embedding.embedding import EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintSettings
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.environment.regions import RegionMask, RegionRule
from core.errors import EvaluationError
from core.evaluation.goals import facing, goal_at, goal_in_cells, goal_in_region, goal_to_begin, goal_with_tag
from core.evaluation.segment_groups import segments_of_clip, segments_with_tag
from core.progress import finish

from .motion_graphs import sample_graph
from .reference import random_problem

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def rows_of(embedding, nodes):
    found = set()
    for index, plane in enumerate(nodes.planes):
        segment, heading = divmod(index, embedding.shape[2])
        found |= {(x, y, heading, segment) for x, y in embedding.network.layout.cells(plane).tolist()}
    return found


def all_rows(embedding):
    return list(map(tuple, embedding.to_csr()[0].tolist()))


def wanted_or_refused(make, expected, embedding):
    """The goal's nodes are those expected; where there are none, it is refused."""
    if expected:
        assert rows_of(embedding, make()) == expected
    else:
        with pytest.raises(EvaluationError):
            make()


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.booleans(), st.floats(0, 0.6))
def test_goals_hold_the_nodes_that_they_should(seed, tiled, radius):
    embedding = embed(*random_problem(seed, tiled), SETTINGS)
    grid, rng, rows = embedding.environment.grid, np.random.default_rng(seed), all_rows(embedding)
    place = np.array(grid.origin) + rng.random(2) * grid.size
    cell = tuple(np.floor((place - grid.origin) / grid.cell_size).astype(int).tolist())

    def near(x, y):
        offset = np.abs(np.array(grid.origin) + (np.array([x, y]) + 0.5) * grid.cell_size - place)
        if tiled:
            offset = np.minimum(offset, np.array(grid.size) - offset)
        return np.hypot(*offset) <= radius or (x, y) == cell

    at = {row for row in rows if near(*row[:2])}
    wanted_or_refused(lambda: goal_at(embedding, tuple(place), radius), at, embedding)
    mask = rng.random(grid.shape[:2]) < 0.3
    inside = {row for row in rows if mask[row[:2]]}
    wanted_or_refused(lambda: goal_in_cells(embedding, mask), inside, embedding)
    for region in embedding.environment.regions:
        inside = {row for row in rows if region.mask[4 * row[0] + 2, 4 * row[1] + 2]}
        name = region.name
        wanted_or_refused(lambda name=name: goal_in_region(embedding, name), inside, embedding)
    for tag in ("step", "jump"):
        tagged = {s for s, segment in enumerate(embedding.graph.segments) if np.any(segment.tags.get(tag, False))}
        arrived = {row for row in rows if row[3] in tagged}
        wanted_or_refused(lambda tag=tag: goal_with_tag(embedding, tag), arrived, embedding)

    nodes, links = embedding.to_csr()
    segment = int(rng.integers(len(embedding.graph.segments)))
    start, end = links.nonzero()
    able = {rows[i] for i in start[nodes[end, 3] == segment]}
    wanted_or_refused(lambda: goal_to_begin(embedding, [segment]), able, embedding)

    heading, tolerance = float(rng.uniform(-10, 10)), float(rng.uniform(0, 2))
    off = [abs(np.angle(np.exp(1j * (h * grid.heading_step - heading)))) for h in range(grid.n_headings)]
    turned = {row for row in rows if off[row[2]] <= tolerance or off[row[2]] == min(off)}
    wanted_or_refused(lambda: facing(embedding, embedding.nodes, heading, tolerance), turned, embedding)


def sample_embedding(**changes):
    grid = Grid.over_rectangle((0, 0), (4, 4), 0.25, 12)
    blocked = np.zeros((64, 64), dtype=bool)
    blocked[28:36, 28:36] = True
    return embed(sample_graph(), Environment(grid, blocked, **changes))


def test_empty_goals_name_the_remedy():
    corner = np.zeros((64, 64), dtype=bool)
    corner[:3, :3] = True
    pillar = np.zeros((64, 64), dtype=bool)
    pillar[29:35, 29:35] = True
    sliver = np.zeros((64, 64), dtype=bool)
    sliver[5, 5] = True
    regions = [
        RegionMask(name, RegionRule.FORBID, "no such tag", mask)
        for name, mask in (("corner", corner), ("pillar", pillar), ("sliver", sliver))
    ]
    embedding = sample_embedding(regions=tuple(regions))
    assert embedding.n_nodes > 0
    with pytest.raises(EvaluationError, match="off the ground; move it"):
        goal_at(embedding, (-1.0, 2.0))
    with pytest.raises(EvaluationError, match=r"something stands there\. The nearest place that can be is 0"):
        goal_at(embedding, (2.0, 2.0))
    with pytest.raises(EvaluationError, match="is no place"):
        goal_at(embedding, (np.nan, 2.0))
    with pytest.raises(EvaluationError, match="'pillar' cannot be reached: obstacles fill it"):
        goal_in_region(embedding, "pillar")
    with pytest.raises(EvaluationError, match="'sliver' cannot be reached: it holds no cell"):
        goal_in_region(embedding, "sliver")
    with pytest.raises(EvaluationError, match=r"no region 'door'.*'corner', 'pillar', 'sliver'"):
        goal_in_region(embedding, "door")
    with pytest.raises(EvaluationError, match="no direction"):
        facing(embedding, embedding.nodes, np.inf)
    with pytest.raises(EvaluationError, match=r"carries the tag 'fly' \(tags: .*; mark frames"):
        goal_with_tag(embedding, "fly")
    with pytest.raises(EvaluationError, match="from the clip 'ballet'"):
        segments_of_clip(embedding.graph, "ballet")
    with pytest.raises(EvaluationError, match="the grid needs"):
        goal_in_cells(embedding, np.zeros((3, 3), dtype=bool))
    nothing = finish(restrict_steps(embedding, embedding.network.empty))
    for ask in (lambda: goal_at(nothing, (1.0, 1.0)), lambda: goal_to_begin(nothing, [0])):
        with pytest.raises(EvaluationError, match="The embedding is empty"):
            ask()
    without = embedding.nodes.where(lambda i: i >= embedding.shape[2])
    with pytest.raises(EvaluationError, match="No walk of the embedding plays a somersault"):
        goal_to_begin(finish(restrict_steps(embedding, without)), [0], "a somersault")


def test_segments_of_clips_and_tags_are_those_of_the_graph():
    graph = sample_graph()
    for clip in graph.clips:
        expected = tuple(i for i, segment in enumerate(graph.segments) if graph.clips[segment.clip] is clip)
        if expected:
            assert segments_of_clip(graph, clip.name) == expected
    tagged = replace(graph.segments[1], tags={"wave": np.ones(graph.segments[1].n_frames, dtype=bool)})
    graph = replace(graph, segments=(graph.segments[0], tagged, *graph.segments[2:]))
    assert segments_with_tag(graph, "wave") == (1,)
