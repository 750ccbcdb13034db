"""Directed walks: the quickest way through some goals, exactly."""

import math
from collections.abc import Generator, Sequence

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node
from ..embedding.network import Nodes, intersection
from ..errors import WalkError
from ..evaluation.reach import merged_frames_steps
from ..progress import Progress, portion
from .time_to_go import NEVER, TimeToGo, quickest_trail_steps
from .walk import NOT_A_START, Trail, Walk, refuse_empty


def walk_through_steps(
    embedding: Embedding, start: Node | Nodes, goals: Sequence[Nodes], limit: float | None = None
) -> Generator[Progress, None, Walk]:
    """The quickest walk that stands at a node of each goal, one goal after the other.

    The least time of the whole, not of each leg: where and how a goal is passed depends on all that follow. One node
    may pass several goals that follow one another. Among walks that take the same time, the root is edited least
    (:func:`.time_to_go.link_edits`, summed over the walk).

    Parameters
    ----------
    start : node (x, y, heading, segment), or Nodes to start from the best of
    goals : sequence of Nodes
        Sets of ``embedding.network``; what of them is not in the embedding does not count.
    limit : float, optional
        Seconds that the walk may last at most.

    Raises
    ------
    WalkError
        The start or a goal has no node in the embedding, no walk is quick enough, or the start passes all goals.
    EmbeddingError
        The times would take more memory than the embedding's settings allow.
    """
    refuse_empty(embedding)
    reader = LinkReader(embedding)
    starts = start_nodes(reader, start)
    time_to_go = yield from portion(time_to_go_steps(embedding, goals, last_frame(embedding, limit)), 0.0, 0.8)
    trail = yield from portion(quickest_within_steps(reader, time_to_go, starts, limit), 0.8, 1.0)
    if not trail.stencils:
        raise WalkError("The character stands at the goal already; choose another goal, or another start.")
    return trail.walk()


def quickest_within_steps(
    reader: LinkReader, time_to_go: TimeToGo, starts: np.ndarray, limit: float | None
) -> Generator[Progress, None, Trail]:
    """The quickest trail from (n, 4) starts along a time_to_go; WalkError if it takes longer than ``limit`` seconds."""
    least = int(time_to_go.frames_at(0, starts).min())
    last = last_frame(reader.embedding, limit)
    if limit is not None and last is not None and least > last:
        # Rounded up: less than that is too little.
        seconds = math.ceil(100 * least / reader.embedding.graph.frame_rate) / 100
        takes = "" if least >= NEVER else f"; the quickest takes {wording.exact(seconds)} s"
        raise WalkError(f"No walk gets there within {wording.exact(limit)} s{takes}. Allow more time.")
    return (yield from quickest_trail_steps(reader, time_to_go, starts))


def start_nodes(reader: LinkReader, start: Node | Nodes) -> np.ndarray:
    """(n, 4) nodes of the embedding to start from; WalkError if there are none."""
    if isinstance(start, tuple):
        nodes = np.array([start])
        nodes = nodes[reader.are_nodes(nodes)]
    else:
        nodes = rows_of(reader.embedding, start)
    if not len(nodes):
        raise WalkError(NOT_A_START)
    return nodes


def rows_of(embedding: Embedding, nodes: Nodes) -> np.ndarray:
    """(n, 4) x, y, heading, segment of the nodes of a set that are in the embedding; by segment, heading, x, y."""
    network, n_headings = embedding.network, embedding.shape[2]
    kept = intersection(nodes, embedding.nodes)
    rows = [np.empty((0, 4), dtype=int)]
    for index, plane in enumerate(plane for bundle in kept for plane in network.planes(bundle)):
        if plane:
            cells = embedding.unrolling.layout.cells(plane)
            segment, heading = divmod(index, n_headings)
            rows.append(np.column_stack([cells, np.broadcast_to([heading, segment], cells.shape)]))
    return np.concatenate(rows)


def time_to_go_steps(
    embedding: Embedding, goals: Sequence[Nodes], last: int | None = None
) -> Generator[Progress, None, TimeToGo]:
    """The time_to_go through goals in their order; ways of more than ``last`` frames count as none.

    The times to the last goal come first; those to each goal before it begin, at every node of the goal, with what is
    left from there.
    """
    if not goals:
        raise WalkError("There is nowhere to go; give at least one goal.")
    goals = [intersection(goal, embedding.nodes) for goal in goals]
    for number, goal in enumerate(goals, 1):
        if not any(goal):
            which = f"goal {number}" if len(goals) > 1 else "the goal"
            raise WalkError(f"No walk of the embedding ever stands at {which}; choose a place inside the covered area.")
    network = embedding.network
    nothing = network.nodes(np.empty((0, 2), dtype=int))
    tables: list[np.ndarray] = []
    for index in range(len(goals) - 1, -1, -1):
        done = len(tables) / len(goals)
        if not tables:
            steps = merged_frames_steps(embedding, goals[index], last)
        else:
            rest = TimeToGo(embedding, goals[index + 1 :], tables)
            rows = rows_of(embedding, goals[index])
            left = rest.frames_at(0, rows)
            able = left <= (NEVER - 1 if last is None else last)
            steps = merged_frames_steps(embedding, nothing, last, (rows[able], left[able]))
        table = yield from portion(steps, done, done + 1 / len(goals))
        tables.insert(0, table)
    return TimeToGo(embedding, goals, tables)


def last_frame(embedding: Embedding, limit: float | None) -> int | None:
    """The last frame within ``limit`` seconds; None for no limit."""
    if limit is None or limit == np.inf:
        return None
    if not limit > 0:
        raise WalkError(f"A walk cannot last {limit} s at most; give a positive time.")
    return int(np.floor(limit * embedding.graph.frame_rate + 1e-3))
