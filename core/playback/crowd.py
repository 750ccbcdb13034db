"""Crowds: many walkers on one ground, at the same time, that never come too close to one another.

Walkers are planned one after the other; each keeps clear of all places that those before it have reserved, frame by
frame (space-time reservation). A plan is a depth-first search through (node, frame): a walker never enters a link from
which, within the time asked for, every way ends in a conflict, so that it always has an escape. Who finds no walk asks
those that were in its way most often to plan again, around it.
"""

import contextlib
from collections import Counter
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node
from ..errors import WalkError
from ..progress import Progress
from .near_cheapest import STARTS, NearCheapest
from .reservation import Reservation, StencilPaths
from .walk import Trail, Walk, node_in_cell, refuse_bad_duration, refuse_empty, refuse_too_long
from .weighted import Memory, Weighting, probabilities, uniform

#: Nodes tried between two reports of progress.
REPORTED_NODES = 200

_ROOM_TO_START = 1.5
"""Times the distance that walkers keep, between places to start where the ground has the room."""
_PER_SPARE = 20
"""Walkers for each one more that is planned, in place of one that is shut in."""


_TURNED_BACK = 10
"""Times that a walker has turned back, from which on it no longer looks ahead at what its ways cost."""


@dataclass(frozen=True)
class CrowdSettings:
    """Settings of how a crowd is planned.

    Attributes
    ----------
    radius : float
        Metres from a walker's root to its edge; two roots keep twice as much between them at every frame.
    weighting : Weighting
        Which links a walker likes to take (:mod:`.weighted`).
    patience : int
        Nodes that one walker may try before its search is given up.
    repairs : int
        How often a walker without a way may ask others to plan again.
    """

    radius: float = 0.3
    weighting: Weighting = uniform
    patience: int = 3000
    repairs: int = 5

    def __post_init__(self):
        if not (np.isfinite(self.radius) and self.radius >= 0):
            raise WalkError(f"Walkers cannot have a radius of {self.radius} m; give zero or more.")
        if self.patience < 1 or self.repairs < 0:
            raise WalkError("A crowd needs a patience of at least one node, and zero or more repairs.")


@dataclass(frozen=True)
class Unserved:
    """A walker that got no walk: its index among the starts, and a sentence that says why."""

    walker: int
    reason: str


@dataclass(frozen=True)
class Crowd:
    """Walks that begin together at frame 0.

    Attributes
    ----------
    embedding : Embedding
    walkers : tuple of int
        For each walk, the index of its start.
    walks : tuple of Walk
        Each lasts at least as long as asked and ends with a whole segment. Wherever two are still walking, they keep
        their distance.
    unserved : tuple of Unserved
        The walkers that got none.
    n_frames : int
        Frames of the time asked for, the first and the last included: all walks last so long.
    """

    embedding: Embedding
    walkers: tuple[int, ...]
    walks: tuple[Walk, ...]
    unserved: tuple[Unserved, ...]
    n_frames: int

    @cached_property
    def places(self) -> np.ndarray:
        """(walks, n_frames, 2) metres: where each walker is at each frame of the time asked for."""
        empty = np.empty((0, self.n_frames, 2))
        return np.concatenate([empty, *(walk.root_path[None, : self.n_frames, :2] for walk in self.walks)])

    @cached_property
    def closest(self) -> float:
        """Metres between the two walkers that come closest to each other; infinite if there are no two."""
        grid = self.embedding.environment.grid
        closest = np.inf
        for i, places in enumerate(self.places[1:], 1):
            apart = self.places[:i] - places
            if grid.tiled:
                apart -= grid.size * np.rint(apart / grid.size)
            closest = min(closest, float(np.linalg.norm(apart, axis=2).min()))
        return closest


def scattered_starts(embedding: Embedding, n_walkers: int, rng: np.random.Generator, spacing: float) -> list[Node]:
    """Choose random nodes in places at least ``spacing`` metres apart.

    Raises
    ------
    WalkError
        The embedding is empty, or so many walkers find no room.
    """
    refuse_empty(embedding)
    grid = embedding.environment.grid
    floor = rng.permutation(np.argwhere(embedding.covered().any(axis=2)))
    room = np.ones(len(floor), dtype=bool)
    reader, likely, nodes = LinkReader(embedding), NearCheapest(embedding), []
    while len(nodes) < n_walkers:
        if not room.any():
            raise WalkError(
                f"Only {len(nodes)} walkers found room {wording.exact(spacing)} m apart, not {n_walkers}; use fewer "
                "Walkers, a smaller Spacing or a larger ground."
            )
        cell = floor[np.argmax(room)]
        apart = np.abs(floor - cell)
        if grid.tiled:
            apart = np.minimum(apart, grid.shape[:2] - apart)
        room &= np.hypot(*apart.T) * grid.cell_size >= max(spacing, grid.cell_size / 2)
        nodes.append(likely.best_of(reader, [node_in_cell(embedding, cell, rng) for _ in range(STARTS)]))
    return nodes


def scattered_crowd_steps(
    embedding: Embedding, n_walkers: int, duration: float, rng: np.random.Generator, settings: CrowdSettings
) -> Generator[Progress, None, Crowd]:
    """Plan a crowd from random places; raises as :func:`scattered_starts`.

    A few walkers more than asked for are planned, where there is room, so that those who are shut in are not missed.
    """
    yield Progress(0.0, "Placing walkers")
    spacing, starts = 2 * settings.radius, None
    with contextlib.suppress(WalkError):
        n_spares = 1 + n_walkers // _PER_SPARE
        starts = scattered_starts(embedding, n_walkers + n_spares, rng, _ROOM_TO_START * spacing)
    if starts is None:
        starts = scattered_starts(embedding, n_walkers, rng, spacing)
    crowd = yield from crowd_steps(embedding, starts, duration, rng, settings)
    n_missing = max(n_walkers - len(crowd.walks), 0)
    return replace(
        crowd,
        walkers=crowd.walkers[:n_walkers],
        walks=crowd.walks[:n_walkers],
        unserved=crowd.unserved[:n_missing],
    )


def crowd_steps(
    embedding: Embedding,
    starts: Sequence[Node],
    duration: float,
    rng: np.random.Generator,
    settings: CrowdSettings | None = None,
) -> Generator[Progress, None, Crowd]:
    """Plan walks of at least ``duration`` seconds from all ``starts`` that keep clear of each other at every frame.

    Those that cannot be served are left out, and named with the reason.

    Parameters
    ----------
    starts : sequence of nodes (x, y, heading, segment)

    Raises
    ------
    WalkError
        The embedding is empty, a start is no node of it, or the duration is not positive.
    """
    settings = settings or CrowdSettings()
    refuse_bad_duration(duration)
    refuse_too_long(embedding, duration, len(starts))
    refuse_empty(embedding)
    reader = LinkReader(embedding)
    astray = np.flatnonzero(~reader.are_nodes(np.array(starts, dtype=int).reshape(-1, 4)))
    if len(astray):
        raise WalkError(f"The start of walker {astray[0] + 1} is no node of the embedding; choose a covered place.")
    last_frame = int(np.ceil(duration * embedding.graph.frame_rate - 1e-6))
    planner = _Planner(reader, len(starts), last_frame, rng, settings)

    unserved, waiting = [], []
    for walker, node in enumerate(starts):
        met = planner.met(node)
        if met.any():
            other = int(np.argmax(met))
            reason = f"Walker {walker + 1} would start in the same place as walker {other + 1}."
            unserved.append(Unserved(walker, reason))
        else:
            planner.reservation.reserve(walker, planner.place(node)[None])
            waiting.append(walker)
    for walker in waiting:
        planner.reservation.release(walker)
    walks: dict[int, Walk] = {}
    repairs = Counter()
    while waiting:
        walker = waiting.pop(0)
        plan = yield from planner.plan_steps(walker, starts[walker], len(walks) / len(starts))
        if plan.walk is not None:
            walks[walker] = plan.walk
        elif repairs[walker] < settings.repairs and plan.in_the_way:
            # One more of them each time; those that were in the way most often first.
            repairs[walker] += 1
            asked = [other for other, _ in plan.in_the_way.most_common(repairs[walker])]
            for other in asked:
                planner.reservation.release(other)
                del walks[other]
            waiting = [walker, *asked, *waiting]
        else:
            unserved.append(Unserved(walker, plan.reason))
    walkers = tuple(sorted(walks))
    unserved.sort(key=lambda u: u.walker)
    return Crowd(embedding, walkers, tuple(walks[w] for w in walkers), tuple(unserved), last_frame + 1)


@dataclass(frozen=True)
class _Plan:
    """A walk, already reserved; or None, why, and how often each other walker was in the way."""

    walk: Walk | None
    reason: str
    in_the_way: Counter


class _Planner:
    """Plans one walker after the other, around all that is reserved."""

    def __init__(
        self, reader: LinkReader, n_walkers: int, last_frame: int, rng: np.random.Generator, settings: CrowdSettings
    ):
        embedding = reader.embedding
        self._reader, self._rng, self._settings, self._last_frame = reader, rng, settings, last_frame
        self._grid, self._exit_group_of = embedding.environment.grid, embedding.network.exit_group_of
        self._frame_rate = embedding.graph.frame_rate
        self._paths = StencilPaths(embedding)
        self._likely = NearCheapest(embedding, settings.weighting)
        self._hasty = self._likely.hasty()
        n_frames = last_frame + self._paths.positions.shape[1] + 1
        self.reservation = Reservation(embedding, n_walkers, n_frames, 2 * settings.radius)

    def place(self, node: Node) -> np.ndarray:
        """World x, y in metres."""
        return self._grid.positions(np.array(node[:2]))

    def met(self, start: Node) -> np.ndarray:
        """Test which walkers are too close to a place at the start."""
        place = self.place(start)
        return self.reservation.conflicts(0, place, place[None, None], 0.0)[0]

    def plan_steps(self, walker: int, start: Node, done: float) -> Generator[Progress, None, _Plan]:
        """Find a walk that meets nobody, and reserve it; ``done`` is the share of the crowd that has its walk."""
        in_the_way = Counter()
        met = self.met(start)
        if met.any():
            in_the_way.update(np.flatnonzero(met).tolist())
            return _Plan(None, f"Walker {walker + 1} has no room to start.", in_the_way)
        trail, memory = Trail(self._reader, start), Memory(self._reader)
        memory.pass_by(start)
        # ahead[i]: stencils still to try from node i of the trail, the next one last.
        ahead = [self._choices(trail, memory, in_the_way)]
        dead: set[tuple[int, int, int, int, int]] = set()
        n_tried, latest = 0, 0
        while trail.frames < self._last_frame:
            if n_tried % REPORTED_NODES == 0:
                yield Progress(done, f"Planning walker {walker + 1}")
            if ahead[-1]:
                trail.take(ahead[-1].pop())
                latest = max(latest, trail.frames)
                if self._key(trail) in dead:
                    trail.back()
                    continue
                n_tried += 1
                if n_tried > self._settings.patience:
                    return _Plan(None, self._no_way(walker, latest, given_up=True), in_the_way)
                memory.pass_by(trail.node)
                hasty = n_tried > len(trail.stencils) + _TURNED_BACK
                ahead.append(self._choices(trail, memory, in_the_way, hasty))
            else:
                # What can follow depends on the place and on the segment's children only.
                dead.add(self._key(trail))
                ahead.pop()
                if not ahead:
                    return _Plan(None, self._no_way(walker, latest, given_up=False), in_the_way)
                memory.forget(trail.node)
                trail.back()
        walk = trail.walk()
        self.reservation.reserve(walker, walk.root_path[:, :2])
        return _Plan(walk, "", in_the_way)

    def _choices(self, trail: Trail, memory: Memory, in_the_way: Counter, hasty: bool = False) -> list[int]:
        """Return the links on which nobody is met, in random order by their weights, the first to try last."""
        if trail.frames >= self._last_frame:
            return []
        crossing = memory.crossing(trail.node)
        start = self.place(trail.node)
        paths = start + self._paths.positions[crossing.stencils]
        met = self.reservation.conflicts(trail.frames + 1, start, paths, self._paths.reach)
        for other in np.flatnonzero(met.any(axis=0)).tolist():
            in_the_way[other] += int(np.count_nonzero(met[:, other]))
        # Drawn without replacement, weight by weight (Efraimidis and Spirakis 2006); links of no weight come last.
        likely = probabilities(self._hasty if hasty else self._likely, crossing)
        with np.errstate(divide="ignore"):
            order = np.argsort(-self._rng.exponential(size=len(likely)) / likely, kind="stable")
        clear = ~met.any(axis=1)
        return crossing.stencils[order[clear[order]]].tolist()

    def _key(self, trail: Trail) -> tuple[int, int, int, int, int]:
        x, y, heading, segment = trail.node
        nx, ny, _ = self._grid.shape
        return x % nx, y % ny, heading, self._exit_group_of[segment], trail.frames

    def _no_way(self, walker: int, latest: int, given_up: bool) -> str:
        """Say why a walker finds no way, if the longest that was tried ends at frame ``latest``."""
        at = wording.time(latest / self._frame_rate)
        if given_up:
            return (
                f"Walker {walker + 1} found no way in {wording.number(self._settings.patience)} tries; the farthest "
                f"of them lasted {at}. Use fewer Walkers, a smaller Spacing or another Seed."
            )
        meets = f"every way meets another walker, at the latest {at} or one step later"
        if latest == 0:
            meets = "every first step meets another walker"
        return f"Walker {walker + 1} is shut in: {meets}. Use fewer Walkers, a smaller Spacing or another Seed."
