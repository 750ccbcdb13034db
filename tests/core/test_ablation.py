"""Ablation against the component of explicit links, and the guarantee of joint deletion."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from core.embedding.embedding import EmbeddingSettings, embed, restrict_steps
from core.embedding.footprint import FootprintSettings
from core.embedding.node_set import NodeSet
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.errors import EmbeddingError, EvaluationError
from core.evaluation.ablation import Verdict, ablate_steps, without_steps
from core.evaluation.deletion import deletable_together_steps
from core.evaluation.goals import goal_in_cells
from core.evaluation.segment_groups import Grouping, segment_groups
from core.evaluation.size import EmbeddingSize, Objective, embedding_size, mean_time_to
from core.motion.graph import MotionGraph, MotionSegment
from core.progress import finish
from tests.bench import problems

from .reference import explicit_embedding, random_problem, slow_floor

SETTINGS = EmbeddingSettings(FootprintSettings(0.05, 0.3, 0.2, 0.5))


def slow_extent(embedding, slow, gone):
    """Floor, places, nodes and links of the largest component of the explicit links between the nodes left."""
    segment = np.unravel_index(slow.nodes, slow.shape)[3]
    alive = np.zeros(np.prod(slow.shape), dtype=bool)
    alive[slow.nodes[~np.isin(segment, list(gone))]] = True
    links = slow.links[alive[slow.links[:, 0]] & alive[slow.links[:, 1]]]
    matrix = sparse.csr_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(len(alive),) * 2)
    _, label = connected_components(matrix, directed=True, connection="strong")
    size = np.bincount(label)
    looped = np.zeros(len(size), dtype=bool)
    looped[label[links[links[:, 0] == links[:, 1], 0]]] = True
    size = np.where((size > 1) | looped, size, 0)
    mask = label == label[np.argmax(size[label])] if size.max() else np.zeros(len(alive), dtype=bool)
    covered = mask.reshape(slow.shape).any(axis=3)
    free = np.count_nonzero(slow_floor(embedding.graph, embedding.environment, covered.any(axis=2)))
    n_cells = np.count_nonzero(covered.any(axis=2))
    return EmbeddingSize(
        floor=n_cells * embedding.environment.grid.cell_size**2,
        share=n_cells / max(free, 1),
        places=np.count_nonzero(covered),
        nodes=np.count_nonzero(mask),
        links=np.count_nonzero(mask[links[:, 0]] & mask[links[:, 1]]),
    )


@cache
def random_embedding(seed, tiled):
    """A random problem whose segments belong to clips of one or two."""
    graph, environment = random_problem(seed, tiled)
    rng = np.random.default_rng(seed)
    clip = np.sort(rng.integers(0, 3, len(graph.segments))).tolist()
    segments = tuple(type(s)(**{**vars(s), "clip": c}) for s, c in zip(graph.segments, clip, strict=True))
    graph = MotionGraph((), graph.frame_rate, segments, graph.links, graph.link_costs)
    return embed(graph, environment, SETTINGS)


@given(st.integers(0, 10**6), st.booleans())
def test_every_loss_equals_that_of_the_explicit_links(seed, tiled):
    embedding = random_embedding(seed, tiled)
    slow = explicit_embedding(embedding.graph, embedding.environment, SETTINGS)
    found = finish(ablate_steps(embedding))
    assert found.before == slow_extent(embedding, slow, ())
    for loss in found.losses:
        assert loss.left == slow_extent(embedding, slow, loss.group.segments), loss.group
    assert [loss.group for loss in found.losses] == [
        p for kind in Grouping for p in segment_groups(embedding.graph, kind)
    ]


@given(st.integers(0, 10**6), st.booleans())
def test_what_is_left_does_not_depend_on_where_the_search_starts(seed, tiled):
    embedding = random_embedding(seed, tiled)
    n_segments = len(embedding.graph.segments)
    rng = np.random.default_rng(seed)
    fewer = set(rng.integers(0, n_segments, 2).tolist())
    core = finish(without_steps(embedding, fewer))
    one = {min(fewer)}
    quick = finish(without_steps(embedding, one, core.nodes))
    assert quick.planes == finish(without_steps(embedding, one)).planes
    assert quick.nodes == finish(restrict_steps(embedding, quick.nodes)).nodes


def test_the_recorded_clips_are_ablated_exactly(data_folder):
    """The shortcut against the plain search, on a cropped room with enough clips to be grouped."""
    embedding = embed(problems.graph(0.12), problems.room(4.0, 4.0))
    assert embedding.n_nodes > 10_000
    found = finish(ablate_steps(embedding))
    assert len(found.losses) > 60
    for loss in found.losses:
        assert loss.left == embedding_size(finish(without_steps(embedding, loss.group.segments)))
    clips = found.ranked(Grouping.CLIP)
    assert [loss.floor for loss in clips] == sorted((loss.floor for loss in clips), reverse=True)
    for loss in found.losses:
        assert (loss.verdict is Verdict.REDUNDANT) == (loss.left.places == loss.before.places)
    columns, rows = found.table()
    assert len(rows) == len(found.losses) and all(len(row) == len(columns) for row in rows)
    for loss, sentence in zip(clips, found.describe()[1:], strict=True):
        assert loss.group.name in sentence and loss.verdict.name.lower() in sentence


def corner_room():
    """A walk of one cell and a quarter turn on the spot, in a room of 6 x 6 cells: useless without each other."""
    path = np.array([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]], dtype=float)
    turn = np.array([[0, 0, 0], [0, 0, np.pi / 4], [0, 0, np.pi / 2]])
    segments = tuple(
        MotionSegment(name, i, 0, 2, path, 2 / 30, {})
        for i, (name, path) in enumerate([("walk", path), ("turn", turn)])
    )
    links = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    grid = Grid((6, 6, 4), 0.2)
    return embed(MotionGraph((), 30.0, segments, links, np.zeros(4)), Environment(grid, np.zeros((24, 24), dtype=bool)))


def test_what_everything_needs_is_essential():
    found = finish(ablate_steps(corner_room()))
    assert found.before.floor == pytest.approx(36 * 0.2**2)
    walk, turn = found.losses[:2]
    assert (walk.verdict, turn.verdict) == (Verdict.ESSENTIAL, Verdict.ESSENTIAL)
    assert walk.left.floor == pytest.approx(0.2**2) and walk.left.nodes == 4 and turn.left.nodes == 0
    assert "97.2%" in walk.describe()
    assert turn.describe() == "Segment 'turn' is essential: without it no endless walk is left."
    assert finish(deletable_together_steps(corner_room(), 0.9)).groups == ()


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.1, 0.5, 1.0]))
def test_what_is_deleted_together_costs_no_more_than_allowed(seed, allowed):
    embedding = random_embedding(seed, False)
    found = finish(deletable_together_steps(embedding, allowed, Grouping.SEGMENT))
    gone = set()
    for part, left in zip(found.groups, found.left_after, strict=True):
        gone.update(part.segments)
        assert left == embedding_size(finish(without_steps(embedding, gone)))
    assert found.left == (found.left_after[-1] if found.left_after else found.before)
    least_floor = found.before.floor * (1 - allowed) - 1e-9
    least_places = found.before.places * (1 - min(5 * allowed, 1)) - 1e-9
    assert found.left.floor >= least_floor and found.left.places >= least_places
    if not embedding.n_nodes:
        return
    for part in segment_groups(embedding.graph, Grouping.SEGMENT):
        if not gone.issuperset(part.segments):
            more = embedding_size(finish(without_steps(embedding, gone.union(part.segments))))
            assert more.nodes == 0 or more.floor < least_floor or more.places < least_places


def test_joint_deletion_is_not_the_sum_of_single_ones(data_folder):
    """On the recorded clips, all that are deletable one by one cannot go together with nothing lost."""
    embedding = embed(problems.graph(0.12), problems.room(4.0, 4.0))
    found = finish(deletable_together_steps(embedding, 0.02))
    assert 0 < len(found.groups) < len(segment_groups(embedding.graph, Grouping.CLIP))
    assert 0 <= found.share <= 0.02 and 0 <= found.places_share <= 0.1
    losses = finish(ablate_steps(embedding, [Grouping.CLIP])).losses
    singly = {loss.group for loss in losses if loss.share <= 0.02}
    together = embedding_size(finish(without_steps(embedding, {i for part in singly for i in part.segments})))
    assert together.floor < 0.98 * found.before.floor
    said = found.describe()[0]
    assert found.groups[0].name in said
    assert "up to 2.0% of the covered floor and 10.0% of its positions and headings may be lost" in said


def test_what_matters_and_what_can_go_agree(data_folder):
    """Allowed to lose as much as makes a clip important, nobody is told to delete an important one."""
    embedding = embed(problems.graph(0.12), problems.room(4.0, 4.0))
    verdicts = {loss.group: loss.verdict for loss in finish(ablate_steps(embedding, [Grouping.CLIP])).losses}
    grave = {Verdict.ESSENTIAL, Verdict.IMPORTANT}
    for allowed in (0.0, 0.005, 0.00999):
        assert not grave & {verdicts[part] for part in finish(deletable_together_steps(embedding, allowed)).groups}
    assert {verdicts[part] for part in finish(deletable_together_steps(embedding, 0.0)).groups} <= {Verdict.REDUNDANT}
    assert grave & set(verdicts.values())


def test_a_measure_is_taken_of_everything_that_is_left(data_folder):
    embedding = embed(problems.graph(0.12), problems.room(3.0, 3.0))
    found = finish(ablate_steps(embedding, [Grouping.CLIP], Objective("number of nodes", "nodes", lambda e: e.n_nodes)))
    assert all(loss.objective == -loss.nodes for loss in found.losses)
    assert "number of nodes, rise (nodes)" in found.table()[0]


def test_the_mean_time_to_a_place_rises_when_motions_go():
    embedding = corner_room()
    door = np.zeros((6, 6), dtype=bool)
    door[0, 0] = True
    at_door = goal_in_cells(embedding, door)
    found = finish(ablate_steps(embedding, [Grouping.SEGMENT], mean_time_to(at_door, "the door")))
    assert 0 < found.before.objective < np.inf
    assert [loss.objective for loss in found.losses] == [
        -found.before.objective if loss.left.objective == 0 else np.inf for loss in found.losses
    ]
    assert "mean time to reach the door, rise (s)" in found.table()[0]
    nowhere = finish(ablate_steps(embedding, [Grouping.SEGMENT], mean_time_to(embedding.network.empty, "nothing")))
    assert [loss.objective for loss in nowhere.losses] == [0.0, 0.0]


def test_progress_rises_and_a_wrong_share_is_refused():
    embedding = random_embedding(3, False)
    fractions = [progress.fraction for progress in ablate_steps(embedding)]
    assert fractions == sorted(fractions) and all(0 <= f <= 1 for f in fractions)
    with pytest.raises(EmbeddingError, match="between 0 and 1"):
        finish(deletable_together_steps(embedding, 1.5))


def test_a_goal_of_another_network_is_refused():
    embedding = embed(*random_problem(3, False))
    with pytest.raises(EvaluationError, match="the door cannot be compared"):
        embedding_size(embedding, mean_time_to(NodeSet((0,) * (len(embedding.planes) + 1)), "the door"))
