"""Performances: walk to where an action can be played at a place, and play it there."""

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node
from ..embedding.node_set import NodeSet
from ..errors import WalkError
from ..motion.graph import MotionGraph
from ..progress import Progress, portion
from .directed import last_frame, start_nodes, trail_steps
from .prices import link_edits
from .reservation import StencilPaths
from .time_to_go import time_to_go_steps
from .walk import Trail, Walk, refuse_empty


@dataclass(frozen=True)
class Performance:
    """A walk to an action and through it.

    Attributes
    ----------
    walk : Walk
    first : int
        Index of the first link that plays the action; all links from there on do.
    place : (2,) float array
        World x, y of the root in the middle of the action (m).
    """

    walk: Walk
    first: int
    place: np.ndarray


@dataclass(frozen=True)
class _Action:
    """Segments to play one after the other; the middle of the action is a frame of one of them."""

    segments: tuple[int, ...]
    middle: int
    frame: int


@dataclass(frozen=True)
class _Playable:
    """An action, the nodes where it can begin, and the links by which it is played.

    ``able`` holds, for each segment of the action and each of its stencils, the plane of starts from which the rest
    of the action can be played to its end.
    """

    action: _Action
    beginnings: NodeSet
    able: tuple[dict[int, int], ...]


def perform_steps(
    embedding: Embedding,
    start: Node | NodeSet,
    segments: Iterable[int],
    position: Sequence[float],
    radius: float,
    tag: str | None = None,
    limit: float | None = None,
    smoothness: float = 0.0,
) -> Generator[Progress, None, Performance]:
    """Find the quickest walk to where an action can begin so that its middle comes to lie near a place; and the action.

    Parameters
    ----------
    start : node (x, y, heading, segment), or NodeSet to start from the best of
    segments : indices
        Those of the action, for example :func:`..evaluation.goals.segments_of_clip`. Segments that follow one another
        in a clip are played one after the other, all of them; of several such runs, the one that can begin first.
    position : x, y in metres
    radius : float
        Metres from the position to the root at the middle of the action, at most.
    tag : str, optional
        The middle of the action is that of its frames with this tag; by default of all its frames.
    limit : float, optional
        Seconds until the action begins, at most.
    smoothness : float
        0 to 1: of the way there, see :func:`.directed.trail_steps`.

    Raises
    ------
    WalkError
        The action cannot be played there, or not in time, or the start is no node of the embedding.
    """
    refuse_empty(embedding)
    if not (np.isfinite(position).all() and radius >= 0):
        raise WalkError("The place of the action is not a number, or its radius is negative; choose another one.")
    reader = LinkReader(embedding)
    starts = start_nodes(reader, start)
    near = _Nearness(embedding, np.asarray(position, dtype=float)[:2], radius)
    playable = []
    for number, action in enumerate(actions := _actions(embedding.graph, segments, tag)):
        yield Progress(0.1 * number / len(actions), "Looking for room")
        playable.append(_playable(embedding, action, near))
    goal = embedding.network.empty
    for found in playable:
        goal = goal | found.beginnings
    if not goal:
        raise WalkError(
            f"The action cannot be played within {wording.exact(radius)} m of "
            f"{wording.place(position[0], position[1])}: it does not fit there, or no walk leads to it and away from "
            "it. Choose a larger Within or another place."
        )
    time_to_go = yield from portion(time_to_go_steps(embedding, [goal], last_frame(embedding, limit)), 0.1, 0.9)
    trail = yield from portion(trail_steps(reader, time_to_go, starts, limit, smoothness), 0.9, 1.0)
    first = len(trail.stencils)
    ways = [(found.action, way) for found in playable if (way := _cheapest_way(reader, found, trail.node))]
    action, (_, stencils) = min(ways, key=lambda way: way[1][0])
    for stencil in stencils:
        trail.take(stencil)
    walk = trail.walk()
    return Performance(walk, first, walk.root_path[walk.node_frames[first + action.middle] + action.frame, :2])


def continued(walk: Walk, further: Walk) -> Walk:
    """Join two walks; the second starts at the node where the first ends, whichever tile it was planned in."""
    reader = LinkReader(walk.embedding)
    ends = reader.wrapped(np.stack([walk.states[-1], further.states[0]]))
    if not np.array_equal(*ends):
        raise WalkError("The second walk does not start where the first one ends; plan it from there.")
    trail = Trail(reader, tuple(walk.states[-1].tolist()))
    for stencil in further.stencils.tolist():
        trail.take(stencil)
    states = np.concatenate([walk.states, np.array(trail.states)[1:].reshape(-1, 4)])
    return Walk(walk.embedding, states, np.concatenate([walk.stencils, further.stencils]))


def _actions(graph: MotionGraph, segments: Iterable[int], tag: str | None) -> list[_Action]:
    """List the runs of segments that follow one another in their clips."""
    chosen = sorted(set(segments), key=lambda s: (graph.segments[s].clip, graph.segments[s].first))
    if not chosen:
        raise WalkError("The action has no segment in the motion graph; choose another action.")
    linked = set(map(tuple, graph.links.tolist()))
    runs: list[list[int]] = []
    for index in chosen:
        segment, before = graph.segments[index], graph.segments[runs[-1][-1]] if runs else None
        follows = before is not None and before.clip == segment.clip and before.last == segment.first
        if follows and (runs[-1][-1], index) in linked:
            runs[-1].append(index)
        else:
            runs.append([index])
    return [_action(graph, run, tag) for run in runs]


def _action(graph: MotionGraph, run: list[int], tag: str | None) -> _Action:
    frames = [(i, frame) for i, index in enumerate(run) for frame in range(graph.segments[index].n_frames)]
    if tag is not None:
        tagged = [(i, frame) for i, frame in frames if tag in (t := graph.segments[run[i]].tags) and t[tag][frame]]
        frames = tagged or frames
    middle, frame = frames[len(frames) // 2]
    return _Action(tuple(run), middle, frame)


def _cheapest_way(reader: LinkReader, playable: _Playable, node: Node) -> tuple[float, list[int]] | None:
    """Return edit and links of the action from a node with the least edit; None if it cannot begin there."""
    nx, ny = reader.embedding.shape[:2]
    layout, edits = reader.embedding.unrolling.layout, link_edits(reader.embedding)
    ways: dict[Node, tuple[float, list[int]]] = {node: (0.0, [])}
    for able in playable.able:
        onward: dict[Node, tuple[float, list[int]]] = {}
        for here, (edit, stencils) in ways.items():
            bit = layout.bit(here[0] % nx, here[1] % ny)
            for k in reader.stencils_from(here).tolist():
                if able.get(k, 0) >> bit & 1:
                    there, total = reader.follow(here, k), edit + float(edits[k])
                    if there not in onward or total < onward[there][0]:
                        onward[there] = (total, [*stencils, k])
        ways = onward
    return min(ways.values(), key=lambda way: way[0], default=None)


def _playable(embedding: Embedding, action: _Action, near: "_Nearness") -> _Playable:
    """Go backwards through an action: from where each of its segments leads to where the next one can start."""
    network, n_headings = embedding.network, embedding.shape[2]
    layout, stencils, valid = network.layout, embedding.unrolling.stencils, embedding.unrolling.valid
    # Where the character may stand before the next segment; at the end, wherever the embedding goes on.
    allowed = [layout.ground] * n_headings
    able: list[dict[int, int]] = []
    for i, segment in reversed(list(enumerate(action.segments))):
        ends = embedding.planes[segment * n_headings : (segment + 1) * n_headings]
        extended = [layout.extend(plane & free) for plane, free in zip(ends, allowed, strict=True)]
        allowed, of_stencils = [0] * n_headings, {}
        for k in np.flatnonzero(stencils.segment == segment).tolist():
            there = extended[int(stencils.destination_heading[k])]
            shift = int(layout.shift(stencils.dx[k], stencils.dy[k]))
            plane = valid[k] & (there >> shift if shift >= 0 else there << -shift)
            if plane and i == action.middle:
                plane &= near.starts(k, action.frame)
            if plane:
                of_stencils[k] = plane
                allowed[int(stencils.heading[k])] |= plane
        able.insert(0, of_stencils)
    parents = network.parents[action.segments[0]]
    standing = [
        plane & allowed[index % n_headings] if index // n_headings in parents else 0
        for index, plane in enumerate(embedding.planes)
    ]
    return _Playable(action, NodeSet(tuple(standing)), tuple(able))


class _Nearness:
    """The starts from which links pass within a radius of a place."""

    def __init__(self, embedding: Embedding, position: np.ndarray, radius: float):
        self._embedding, self._radius = embedding, radius
        grid = embedding.environment.grid
        #: (nx, ny, 2) metres from the position to each cell.
        self._offsets = grid.positions(np.moveaxis(np.indices(grid.shape[:2]), 0, -1)) - position
        self._paths = StencilPaths(embedding)

    def starts(self, stencil: int, frame: int) -> int:
        """Return the plane of starts from which a frame of a stencil lies within the radius."""
        grid = self._embedding.environment.grid
        away = self._offsets + (self._paths.positions[stencil, frame - 1] if frame else 0.0)
        if grid.tiled:
            away = away - grid.size * np.rint(away / grid.size)
        return self._embedding.unrolling.layout.pack(np.linalg.norm(away, axis=2) <= self._radius)
