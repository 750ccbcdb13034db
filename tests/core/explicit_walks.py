"""Walks beside the embedding written out: is every step one of its links?"""

from functools import cache

import numpy as np

from core.embedding.embedding import Embedding
from core.embedding.node_set import NodeSet
from core.motion.body_size import relative_size
from core.playback.prices import PriceSettings
from core.playback.walk import Walk


def some_nodes(embedding: Embedding, rows: np.ndarray) -> NodeSet:
    """The set of (n, 4) nodes x, y, heading, segment."""
    _, ny, n_headings, _ = embedding.shape
    return embedding.network.nodes(
        np.column_stack([rows[:, 3] * n_headings + rows[:, 2], rows[:, 0] * ny + rows[:, 1]])
    )


def assert_links(walk: Walk) -> None:
    """Every step of the walk is a link of its embedding: bit by bit, from the planes themselves."""
    embedding = walk.embedding
    layout, stencils = embedding.unrolling.layout, embedding.unrolling.stencils
    nx, ny, n_headings, _ = embedding.shape
    linked = set(map(tuple, embedding.graph.links.tolist()))

    def is_set(plane: int, x: int, y: int) -> bool:
        if not embedding.environment.grid.tiled:
            assert 0 <= x < nx and 0 <= y < ny
        return bool(layout.unpack(plane)[x % nx, y % ny])

    assert len(walk.states) == len(walk.stencils) + 1
    for (x, y, heading, segment), (x2, y2, heading2, segment2), k in zip(
        walk.states[:-1].tolist(), walk.states[1:].tolist(), walk.stencils.tolist(), strict=True
    ):
        assert (segment, segment2) in linked
        assert (stencils.segment[k], stencils.heading[k]) == (segment2, heading)
        assert (stencils.dx[k], stencils.dy[k]) == (x2 - x, y2 - y)
        assert stencils.destination_heading[k] == heading2
        assert is_set(embedding.unrolling.valid[k], x, y)
        assert is_set(embedding.planes[segment * n_headings + heading], x, y)
        assert is_set(embedding.planes[segment2 * n_headings + heading2], x2, y2)


def explicit_links(embedding: Embedding, node: tuple[int, ...]) -> list[tuple[int, tuple[int, ...]]]:
    """All (stencil, end) of links from a node on the ground, one stencil after the other; ends are on the ground."""
    layout, stencils = embedding.unrolling.layout, embedding.unrolling.stencils
    (nx, ny, n_headings, _), tiled = embedding.shape, embedding.environment.grid.tiled
    x, y, heading, segment = node
    after = {int(b) for a, b in embedding.graph.links.tolist() if a == segment}
    found = []
    for k in range(len(stencils)):
        if stencils.heading[k] != heading or int(stencils.segment[k]) not in after:
            continue
        x2, y2 = x + int(stencils.dx[k]), y + int(stencils.dy[k])
        if not tiled and not (0 <= x2 < nx and 0 <= y2 < ny):
            continue
        end = x2 % nx, y2 % ny, int(stencils.destination_heading[k]), int(stencils.segment[k])
        plane = embedding.planes[end[3] * n_headings + end[2]]
        if layout.unpack(embedding.unrolling.valid[k])[x, y] and layout.unpack(plane)[end[0], end[1]]:
            found.append((k, end))
    return found


def explicit_price(embedding: Embedding, before: int, stencil: int, settings: PriceSettings) -> int:
    """Milliseconds of one link, by a stencil after a segment: every term by itself."""
    graph, stencils = embedding.graph, embedding.unrolling.stencils
    a, b = graph.segments[before], graph.segments[int(stencils.segment[stencil])]
    size = relative_size(graph.clips[0].skeleton) if graph.clips else 1.0
    path, rate = b.path, graph.frame_rate
    half, idle = max(round(0.25 * rate), 1), 0
    for frame in range(b.n_frames):
        low, high = max(frame - half, 0), min(frame + half, len(path) - 1)
        idle += np.hypot(*(path[high, :2] - path[low, :2])) * rate < 0.45 * size * max(high - low, 1)

    def beyond(turn, seconds):
        return max(abs(turn) * min(2.0 / seconds, 1.0) - settings.free_turn, 0.0)

    playing = b.duration + settings.idle * idle / b.n_frames * b.duration
    playing += settings.back * beyond(b.path[-1, 2], b.duration)
    metres = sum(np.hypot(*step) for step in np.diff(b.path[:, :2], axis=0)) / size
    moved, turned = np.hypot(*stencils.position_error[stencil]), stencils.heading_error[stencil]
    share = moved / size / max(metres, 0.5) / settings.noticeable_bend
    edit = settings.edit * np.hypot(moved, 0.5 * turned) / size + settings.bend * share**2
    pairs = {
        (int(first), int(second)): cost for (first, second), cost in zip(graph.links, graph.link_costs, strict=True)
    }
    joining = settings.cost * pairs[before, int(stencils.segment[stencil])]
    joining += settings.back * beyond(a.path[-1, 2] + b.path[-1, 2], a.duration + b.duration)
    joining += settings.again * (before == int(stencils.segment[stencil]))
    return sum(int(np.rint(1000 * part)) for part in (playing, edit, joining))


def explicit_least_price(price, links, start, is_goal, most: int, look_ahead: int) -> float:
    """The least price of ways of 1 to ``most`` links that end where they first come to the goal, and then go on.

    They only come by nodes that are nearer to the goal than the start is, by the fewest links. ``links(node)`` lists
    (stencil, end), ``price(node, stencil)`` is that of a link. Infinite if there is no such way.
    """

    @cache
    def arrives(node, n_links) -> bool:
        """Whether the goal can be come to by at most so many links, and at least one."""
        return n_links > 0 and any(is_goal(end) or arrives(end, n_links - 1) for _, end in links(node))

    fewest = next(n for n in range(1, most + 1) if arrives(start, n))

    def onwards(node, n_links) -> float:
        if n_links == 0:
            return 0
        return min((price(node, k) + onwards(end, n_links - 1) for k, end in links(node)), default=np.inf)

    least, reached = np.inf, {start: 0}
    for _ in range(most):
        further: dict = {}
        for node, so_far in reached.items():
            for k, end in links(node):
                total = so_far + price(node, k)
                if is_goal(end):
                    least = min(least, total + onwards(end, look_ahead))
                elif arrives(end, fewest - 1):
                    further[end] = min(further.get(end, np.inf), total)
        reached = further
    return least
