"""Walks along a drawn curve: near it, forward, and to its end.

The curve is laid out as a row of points. A walker that has come to point i may go on to any node near the curve whose
nearest point lies ahead, j >= i, within what its segment can travel; a link costs the squared distance between root
and curve at each of its frames, and a little for its price (:mod:`.prices`). Nodes with what they have passed,
(node, i), are worked off point by point, so that each sees all that came before it: a dynamic programme, exact as long
as no point but the first holds more nodes than the *beam* is wide; beyond that the dearest are dropped.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node
from ..embedding.node_set import NodeSet
from ..errors import WalkError
from ..progress import Progress
from .prices import LinkPrices
from .reservation import StencilPaths
from .time_to_go import rows_of
from .walk import Trail, Walk, refuse_empty

#: Frames of each link at which its distance from the curve is measured: evenly spread, the last one included.
MEASURED_FRAMES = 8

#: Standing at the start counts like so many seconds at its distance from the curve's first point.
START_SECONDS = 1.0


@dataclass(frozen=True)
class CurveSettings:
    """Settings of how a walk follows a curve.

    Attributes
    ----------
    width : float
        Metres from the curve that the root may stray to either side.
    time_weight : float
        Square metres: how much a second of the links' prices (:mod:`.prices`) costs, beside the mean square of the
        distance from the curve. The higher, the smoother the walk is, and the sooner corners are cut.
    beam : int
        Nodes kept at each point of the curve.
    heading : float, optional
        Radians: the direction to face at the end, by default any.
    """

    width: float = 0.5
    time_weight: float = 0.005
    beam: int = 300
    heading: float | None = None

    def __post_init__(self):
        if not (np.isfinite(self.width) and self.width > 0):
            raise WalkError(f"A curve cannot be followed within {self.width} m; give a positive width.")
        if not (np.isfinite(self.time_weight) and self.time_weight > 0) or self.beam < 1:
            raise WalkError("Following a curve needs a positive weight of time and a beam of at least one node.")


def walk_along_steps(
    embedding: Embedding,
    curve: np.ndarray | Sequence[Sequence[float]],
    settings: CurveSettings | None = None,
    start: Node | NodeSet | None = None,
) -> Generator[Progress, None, Walk]:
    """Find the walk along a curve that stays near to it, in mean square over time, and is smooth, and does not tarry.

    Parameters
    ----------
    curve : (n, 2) metres, world x and y of the corners of a polyline; not wrapped: on a tiled ground it may lead on
        beyond the ground
    start : node (x, y, heading, segment), or NodeSet to start from one of; by default any node near the curve's begin

    Raises
    ------
    WalkError
        The curve is no line, nobody can stand near one of its ends, or no walk follows it: the message names the place
        where the last of them fails.
    """
    settings = settings or CurveSettings()
    refuse_empty(embedding)
    reader = LinkReader(embedding)
    follower = _Follower(reader, curve_points(curve, embedding.environment.grid.cell_size / 2), settings)
    yield Progress(0.0, "Following the curve")
    return (yield from follower.steps(follower.starts(start)))


def curve_points(curve: np.ndarray | Sequence[Sequence[float]], spacing: float) -> np.ndarray:
    """Return (n, 2) points along a polyline, its ends included, evenly at most ``spacing`` metres apart along it.

    >>> curve_points([(0, 0), (1, 0), (1, 0.5)], 0.5)
    array([[0. , 0. ],
           [0.5, 0. ],
           [1. , 0. ],
           [1. , 0.5]])
    """
    corners = np.asarray(curve, dtype=float)
    if corners.ndim != 2 or corners.shape[1] < 2 or len(corners) < 2 or not np.isfinite(corners).all():
        raise WalkError("The curve needs at least two points with finite coordinates; draw a longer one.")
    corners = corners[:, :2]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    if along[-1] < spacing:
        raise WalkError(f"The curve is only {wording.length(along[-1])} long; draw a longer one.")
    at = np.linspace(0.0, along[-1], int(np.ceil(along[-1] / spacing)) + 1)
    return np.column_stack([np.interp(at, along, corners[:, axis]) for axis in (0, 1)])


@dataclass
class _Reached:
    """Nodes found at one point of the curve, their costs, and how they were reached.

    Attributes
    ----------
    nodes : (n, 4) int array, not wrapped
    cost : (n,) float array
    before : (n, 2) int array, the point and the row there that they were reached from; -1 for starts
    stencil : (n,) int array
    """

    nodes: np.ndarray
    cost: np.ndarray
    before: np.ndarray
    stencil: np.ndarray

    @classmethod
    def joined(cls, parts: Sequence["_Reached"]) -> "_Reached":
        return cls(
            *(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__dataclass_fields__),
        )

    def rows(self, chosen: np.ndarray) -> "_Reached":
        return _Reached(self.nodes[chosen], self.cost[chosen], self.before[chosen], self.stencil[chosen])


class _Follower:
    """The dynamic programme over the points of one curve."""

    def __init__(self, reader: LinkReader, points: np.ndarray, settings: CurveSettings):
        self._reader, self._points, self._settings = reader, points, settings
        self._embedding = reader.embedding
        self._grid = self._embedding.environment.grid
        paths = StencilPaths(self._embedding)
        self._n_frames = paths.n_frames
        measured = np.ceil(np.outer(self._n_frames, np.arange(1, MEASURED_FRAMES + 1) / MEASURED_FRAMES)).astype(int)
        #: (K, MEASURED_FRAMES, 2) metres from the start.
        self._paths = paths.positions[np.arange(len(measured))[:, None], measured - 1]
        self._seconds = self._n_frames / self._embedding.graph.frame_rate
        self._prices = LinkPrices(self._embedding)
        spacing = np.linalg.norm(points[1] - points[0])
        #: Points by which a link can get ahead: its longest way, and the width on both sides of a bend.
        self._ahead = int(np.ceil((paths.reach + 2 * settings.width) / spacing))

    @cached_property
    def _tube(self) -> tuple[np.ndarray, np.ndarray]:
        """Cells near the curve as a mask, and the cell that it begins with; not wrapped."""
        margin = self._settings.width + self._grid.cell_size
        low = self._grid.cells(self._points.min(axis=0) - margin)
        high = self._grid.cells(self._points.max(axis=0) + margin)
        cells = low + np.moveaxis(np.indices(high - low + 1), 0, -1)
        return KDTree(self._points).query(self._grid.positions(cells))[0] <= self._settings.width, low

    def _in_tube(self, cells: np.ndarray) -> np.ndarray:
        """Test which (n, 2) cells are near any part of the curve."""
        mask, low = self._tube
        cells = cells - low
        inside = np.all((cells >= 0) & (cells < mask.shape), axis=1)
        inside[inside] = mask[tuple(cells[inside].T)]
        return inside

    def starts(self, start: Node | NodeSet | None) -> np.ndarray:
        """Return (n, 4) nodes to start from, not wrapped, within the width of the curve's first point."""
        embedding, grid = self._embedding, self._grid
        first, width = self._points[0], self._settings.width
        if isinstance(start, tuple):
            nodes = np.array([start])
            nodes = nodes[self._reader.are_nodes(nodes)]
        else:
            nodes = self._near_first(embedding.nodes if start is None else (start & embedding.nodes))
        nodes = nodes.copy()
        if grid.tiled and len(nodes):
            # The tile that lies nearest to the curve's first point.
            size = np.array(grid.size)
            tiles = np.rint((first - grid.positions(nodes[:, :2])) / size).astype(int)
            nodes[:, :2] += tiles * grid.shape[:2]
        nodes = nodes[np.linalg.norm(grid.positions(nodes[:, :2]) - first, axis=1) <= width]
        if not len(nodes):
            raise WalkError(
                f"Nobody can start within {wording.exact(width)} m of the curve's first point at "
                f"{wording.place(first[0], first[1])}; begin the curve in a covered place, or allow more Width."
            )
        return nodes

    def _near_first(self, nodes: NodeSet) -> np.ndarray:
        """Rows of the nodes in cells near the first point; rows of all of them would be too many."""
        grid, network = self._grid, self._embedding.network
        away = grid.positions(np.moveaxis(np.indices(grid.shape[:2]), 0, -1)) - self._points[0]
        if grid.tiled:
            away = away - grid.size * np.rint(away / grid.size)
        near = network.layout.pack(np.linalg.norm(away, axis=2) <= self._settings.width + 1e-9)
        return rows_of(self._embedding, nodes.on(near))

    def steps(self, starts: np.ndarray) -> Generator[Progress, None, Walk]:
        n_points = len(self._points)
        waiting: list[list[_Reached]] = [[] for _ in range(n_points)]
        done: list[list[_Reached]] = [[] for _ in range(n_points)]
        none = np.full((len(starts), 2), -1)
        away = self._grid.positions(starts[:, :2]) - self._points[0]
        waiting[0].append(_Reached(starts, START_SECONDS * (away**2).sum(axis=1), none, none[:, 0]))
        farthest = 0
        for point in range(n_points):
            yield Progress(point / n_points, "Following the curve")
            best: dict[tuple[int, ...], float] = {}
            n_done = 0
            # Links that get no farther come back to the same point: round after round, until none is cheaper.
            while waiting[point]:
                farthest = point
                # All starts are tried: which of them face along the curve is not known yet.
                beam = max(self._settings.beam, len(starts) if point == 0 else 0)
                fresh = self._cheapest(_Reached.joined(waiting[point]), best, beam)
                waiting[point] = []
                if not len(fresh.nodes):
                    break
                done[point].append(fresh)
                rows = np.arange(n_done, n_done + len(fresh.nodes))
                n_done += len(fresh.nodes)
                if point + 1 == n_points and self._arrived(fresh.nodes).any():
                    continue
                for ahead, found in self._onward(point, fresh, rows):
                    waiting[ahead].append(found)
        return self._walk(done, farthest)

    def _cheapest(self, found: _Reached, best: dict[tuple[int, ...], float], beam: int) -> _Reached:
        """Keep the cheapest way to each node, if it is cheaper than before, and as many nodes as ``beam``.

        ``best`` remembers the costs.
        """
        n_headings, n_segments = self._embedding.shape[2:]
        nodes = found.nodes
        low = nodes[:, :2].min(axis=0)
        span = np.ptp(nodes[:, :2], axis=0) + 1
        place = np.asarray(
            np.ravel_multi_index((*(nodes[:, :2] - low).T, *nodes[:, 2:].T), (*span, n_headings, n_segments))
        )
        order = np.lexsort((found.cost, place))
        order = order[np.flatnonzero(np.diff(place[order], prepend=-1))]
        order = order[np.argsort(found.cost[order], kind="stable")][:beam]
        if len(best) >= beam:
            dearest = np.partition(np.array(list(best.values())), beam - 1)[beam - 1]
            order = order[found.cost[order] < dearest]
        kept = []
        for row in order.tolist():
            key = tuple(nodes[row].tolist())
            if found.cost[row] < best.get(key, np.inf) - 1e-12:
                best[key] = float(found.cost[row])
                kept.append(row)
        return found.rows(np.array(kept, dtype=int))

    def _onward(self, point: int, fresh: _Reached, rows: np.ndarray) -> Generator[tuple[int, _Reached], None, None]:
        """Yield all links that stay near the curve, by the point that they get to."""
        window = self._points[point : point + self._ahead + 1]
        row, stencil = self._reader.links_from(fresh.nodes)
        ends = self._reader.ends(fresh.nodes[row], stencil)
        # Most links lead away: look at their ends first, where that is cheap.
        kept = self._in_tube(ends[:, :2])
        row, stencil, ends = row[kept], stencil[kept], ends[kept]
        near, _ = KDTree(window).query(self._grid.positions(ends[:, :2]), distance_upper_bound=self._settings.width)
        kept = np.isfinite(near)
        row, stencil, ends = row[kept], stencil[kept], ends[kept]
        if not len(row):
            return
        places = self._grid.positions(fresh.nodes[row, :2])[:, None] + self._paths[stencil]
        distance, nearest = map(np.asarray, KDTree(window).query(places))
        kept = np.all(distance <= self._settings.width, axis=1)
        squares = (distance[kept] ** 2).mean(axis=1)
        row, stencil, ends, to = row[kept], stencil[kept], ends[kept], point + nearest[kept, -1]
        price = self._prices.of(fresh.nodes[row, 3], stencil) / 1000
        cost = fresh.cost[row] + squares * self._seconds[stencil] + self._settings.time_weight * price
        before = np.column_stack([np.full(len(row), point), rows[row]])
        for ahead in np.unique(to).tolist():
            here = to == ahead
            yield ahead, _Reached(ends[here], cost[here], before[here], stencil[here])

    def _arrived(self, nodes: np.ndarray) -> np.ndarray:
        """Test which nodes face as asked at the end."""
        if self._settings.heading is None:
            return np.ones(len(nodes), dtype=bool)
        off = nodes[:, 2] * self._grid.heading_step - self._settings.heading
        off = np.abs((off + np.pi) % (2 * np.pi) - np.pi)
        return off <= self._grid.heading_step / 2 + 1e-9

    def _walk(self, done: list[list[_Reached]], farthest: int) -> Walk:
        last = _Reached.joined(done[-1]) if done[-1] else None
        arrived = np.flatnonzero(self._arrived(last.nodes)) if last else np.empty(0, dtype=int)
        if last is None or not len(arrived):
            raise WalkError(self._why_not(farthest))
        joined = [_Reached.joined(parts) if parts else None for parts in done]
        row = int(arrived[np.argmin(last.cost[arrived])])
        point, stencils = len(done) - 1, []
        while True:
            reached = joined[point]
            assert reached is not None
            if reached.before[row, 0] < 0:
                break
            stencils.append(int(reached.stencil[row]))
            point, row = reached.before[row].tolist()
        trail = Trail(self._reader, tuple(reached.nodes[row].tolist()))
        for stencil in reversed(stencils):
            trail.take(stencil)
        return trail.walk()

    def _why_not(self, farthest: int) -> str:
        x, y = self._points[farthest]
        if farthest + 1 == len(self._points):
            return (
                "The curve can be followed to its end, but not so that the character faces as asked there; end the "
                "curve in that direction, or allow any."
            )
        spacing = float(np.linalg.norm(self._points[1] - self._points[0]))
        return (
            f"No walk follows the curve within {wording.exact(self._settings.width)} m: the farthest ends at "
            f"{wording.place(x, y)}, after {wording.length(farthest * spacing)} of "
            f"{wording.length((len(self._points) - 1) * spacing)}. Bend it less there, lead it around obstacles, or "
            "allow more Width."
        )
