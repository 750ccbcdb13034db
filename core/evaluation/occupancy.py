"""Occupancy: where random walkers spend their time, exactly (the stationary distribution) and by simulation."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from .. import wording
from ..embedding.embedding import Embedding
from ..environment.environment import Environment
from ..errors import EmbeddingError
from ..progress import Progress, finish, portion
from .walkers import Flow, Walkers

#: Bools that are looked up together while walkers choose their next links.
LOOKED_UP = 4_000_000


@dataclass(frozen=True)
class Occupancy:
    """Where walkers spend their time.

    Attributes
    ----------
    floor : (nx, ny) float array
        Share of the time spent in each cell; sums to 1. The time between two frames counts where the root is halfway,
        or, where that is in a corner of a cell at whose centre nobody can stand, in the nearest cell that is free.
    segments : (n_segments,) float array
        Share of the time that each segment is played.
    cell_area : float
        Square metres.
    hot_spot : (x, y)
        World position (m) of the cell with the greatest share.
    residual, error : float
        By how much one more step would change the distribution, and about how far it is from the exact one: sums of
        absolute differences of the shares. Not a number for simulated walks.
    n_steps : int
        Steps of the iteration, or links walked.
    """

    floor: np.ndarray
    segments: np.ndarray
    cell_area: float
    hot_spot: tuple[float, float]
    residual: float
    error: float
    n_steps: int

    @property
    def density(self) -> np.ndarray:
        """(nx, ny) share of the time per square metre."""
        return self.floor / self.cell_area

    @property
    def visited_area(self) -> float:
        """Square metres on which any time is spent."""
        return np.count_nonzero(self.floor) * self.cell_area

    @property
    def effective_area(self) -> float:
        """Square metres that walkers would use evenly to be as spread out: exp(entropy of the shares) cells."""
        shares = self.floor[self.floor > 0]
        return float(np.exp(-np.sum(shares * np.log(shares)))) * self.cell_area

    @property
    def half_time_share(self) -> float:
        """The smallest share of the visited floor that holds half of the time; 0.5 if all is used alike."""
        shares = np.sort(self.floor[self.floor > 0])[::-1]
        held = np.cumsum(shares)
        n_whole = int(np.searchsorted(held, 0.5 * held[-1]))
        rest = 0.5 * held[-1] - (held[n_whole - 1] if n_whole else 0.0)
        return float((n_whole + rest / shares[n_whole]) / len(shares))

    def describe(self) -> list[str]:
        """Sentences for a report."""
        times = float(self.floor.max()) / self.cell_area * self.visited_area
        used, visited = wording.area(self.effective_area), wording.area(self.visited_area)
        return [
            f"Half of the time is spent on {wording.share(self.half_time_share)} of the floor that walkers pass.",
            f"They are spread out as if they used {used} of {visited} evenly.",
            f"The busiest place is at {wording.place(*self.hot_spot)}: {wording.amount(times)} times the mean.",
            *self._exactness(),
        ]

    def _exactness(self) -> list[str]:
        """How far the shares may be off, unless they were simulated."""
        if not np.isfinite(self.error):
            return []
        off = wording.share(self.error)
        return [f"These shares are exact but for {off} of the time, after {wording.counted(self.n_steps, 'step')}."]


def occupancy(embedding: Embedding, tolerance: float = 1e-5, max_steps: int = 5000) -> Occupancy:
    """Where random walkers that take each outgoing link with the same probability spend their time in the long run.

    Power iteration of the stationary distribution over all nodes, each weighted by the duration of the links taken
    there. Ends when one more step would move less than ``tolerance`` of the walkers, or after ``max_steps`` steps: the
    result tells its ``residual``. Walkers wait now and then, so that chains that go in circles settle too.

    Raises
    ------
    EmbeddingError
        The embedding is empty, or the tolerance is not positive.
    """
    return finish(occupancy_steps(embedding, tolerance, max_steps))


def occupancy_steps(
    embedding: Embedding, tolerance: float = 1e-5, max_steps: int = 5000
) -> Generator[Progress, None, Occupancy]:
    """As :func:`occupancy`, as a generator that yields progress."""
    if not (tolerance > 0 and max_steps > 0):
        raise EmbeddingError(f"A tolerance of {tolerance} after {max_steps} steps cannot be met; make both positive.")
    walkers = Walkers(embedding)
    flow = yield from portion(walkers.flow_steps(tolerance, max_steps), 0.0, 0.9)
    yield Progress(0.9, "Following paths")
    floor, segments = _along_paths(walkers, flow)
    return _occupancy(embedding, floor, segments, flow.residual, flow.error, flow.n_steps)


def visits(embedding: Embedding, tolerance: float = 1e-5, max_steps: int = 5000) -> np.ndarray:
    """(nx, ny, n_headings, n_segments) float64: the stationary distribution of the walkers' nodes, step by step.

    The share of all steps that end at each node, however long they last. For small grounds: eight bytes for each.
    """
    walkers = Walkers(embedding)
    flow = finish(walkers.flow_steps(tolerance, max_steps))
    nx, ny, n_headings, n_segments = embedding.shape
    shares = np.zeros((n_segments, n_headings, nx * ny))
    for i, (segment, turned) in enumerate(zip(walkers.segment.tolist(), walkers.turned.tolist(), strict=True)):
        for leaving, _, target in walkers.moves(_leaving(walkers, flow, i), int(walkers.dx[i]), int(walkers.dy[i])):
            shares[segment, turned, target] += leaving
    return (shares / shares.sum()).reshape(n_segments, n_headings, nx, ny).transpose(2, 3, 1, 0)


def _leaving(walkers: Walkers, flow: Flow, i: int) -> np.ndarray:
    """(nx, ny) float64: how often the i-th used stencil is taken from each cell, per step."""
    mask = walkers.mask(i)
    return flow.starts[walkers.fork[i], walkers.heading[i]].reshape(mask.shape) * mask.astype(np.float64)


def _along_paths(walkers: Walkers, flow: Flow) -> tuple[np.ndarray, np.ndarray]:
    """Time in each cell and time of each segment, in frames per step."""
    nx, ny = walkers.layout.nx, walkers.layout.ny
    floor, segments = np.zeros(nx * ny), np.zeros(walkers.embedding.shape[3])
    for i, segment in enumerate(walkers.segment.tolist()):
        leaving = _leaving(walkers, flow, i)
        x, y = walkers.passed_cells(i)
        segments[segment] += leaving.sum() * len(x)
        passed, n_frames = np.unique(np.column_stack([x, y]), axis=0, return_counts=True)
        for (dx, dy), n in zip(passed.tolist(), n_frames.tolist(), strict=True):
            for moving, _, target in walkers.moves(leaving, dx, dy):
                floor[target] += n * moving
    return free_ground(walkers.embedding.environment, floor.reshape(nx, ny)), segments


def free_ground(environment: Environment, floor: np.ndarray) -> np.ndarray:
    """(..., nx, ny) time in each cell, with that of cells whose centre is blocked given to the nearest free cell."""
    free, tiled = environment.free_cells(), environment.grid.tiled
    if free.all() or not free.any():
        return floor
    nx, ny = free.shape
    repeated = np.tile(free, (3, 3)) if tiled else free
    x, y = np.asarray(ndimage.distance_transform_edt(~repeated, return_distances=False, return_indices=True))
    if tiled:
        x, y = x[nx : 2 * nx, ny : 2 * ny] % nx, y[nx : 2 * nx, ny : 2 * ny] % ny
    into = (x * ny + y).ravel()
    return np.stack([np.bincount(into, time, nx * ny) for time in floor.reshape(-1, nx * ny)]).reshape(floor.shape)


def _occupancy(
    embedding: Embedding, floor: np.ndarray, segments: np.ndarray, residual: float, error: float, n_steps: int
) -> Occupancy:
    grid = embedding.environment.grid
    busiest = np.array(np.unravel_index(np.argmax(floor), floor.shape))
    x, y = grid.positions(busiest).tolist()
    return Occupancy(
        floor / floor.sum(), segments / segments.sum(), grid.cell_size**2, (x, y), residual, error, n_steps
    )


@dataclass(frozen=True)
class SimulatedOccupancy:
    """Where simulated walkers spent their time.

    Attributes
    ----------
    occupancy : Occupancy
        Of all walkers together.
    deviation : (nx, ny) float array
        Standard error of each cell's share, from how much groups of walkers differ.
    n_walkers : int
    duration : float
        Seconds that each walker was watched.
    """

    occupancy: Occupancy
    deviation: np.ndarray
    n_walkers: int
    duration: float


def simulated_occupancy(
    embedding: Embedding,
    rng: np.random.Generator,
    n_walkers: int = 1000,
    duration: float = 60.0,
    settling: float = 30.0,
    n_groups: int = 20,
) -> SimulatedOccupancy:
    """Where random walkers spend ``duration`` seconds, after ``settling`` seconds from a random node each.

    They all walk at once, as arrays. Groups of walkers tell how far chance goes: ``n_groups`` of them, two at least.

    Raises
    ------
    EmbeddingError
        The embedding is empty, there are fewer walkers than groups, or a duration is not positive.
    """
    return finish(simulated_occupancy_steps(embedding, rng, n_walkers, duration, settling, n_groups))


def simulated_occupancy_steps(
    embedding: Embedding,
    rng: np.random.Generator,
    n_walkers: int = 1000,
    duration: float = 60.0,
    settling: float = 30.0,
    n_groups: int = 20,
) -> Generator[Progress, None, SimulatedOccupancy]:
    """As :func:`simulated_occupancy`, as a generator that yields progress."""
    if not 2 <= n_groups <= n_walkers:
        raise EmbeddingError(
            f"{n_walkers} walkers do not make {n_groups} groups; use at least two groups, of one walker each or more."
        )
    if not (np.isfinite(duration) and duration > 0 and settling >= 0):
        raise EmbeddingError(f"Walks of {duration} s after {settling} s cannot be watched; give positive durations.")
    walkers = Walkers(embedding)
    choice = _Choices(walkers)
    nx, ny = walkers.layout.nx, walkers.layout.ny
    rate, graph = embedding.graph.frame_rate, embedding.graph
    first, last = round(settling * rate), round(settling * rate) + max(round(duration * rate), 1)

    x, y, heading, merge = choice.random_nodes(n_walkers, rng)
    clock, group = np.zeros(n_walkers, dtype=int), np.arange(n_walkers) % n_groups
    floor, segments, n_links = np.zeros((n_groups, nx * ny)), np.zeros(len(graph.segments)), 0
    while len(clock):
        yield Progress(float(clock.min()) / last, "Walking")
        taken = choice.take(x, y, heading, merge, rng)
        n_links += len(taken)
        frames = clock[:, None] + np.arange(1, choice.passed_x.shape[1] + 1)
        counts = choice.played[taken] & (frames > first) & (frames <= last)
        cell = (x[:, None] + choice.passed_x[taken]) % nx * ny + (y[:, None] + choice.passed_y[taken]) % ny
        index = (group[:, None] * (nx * ny) + cell)[counts]
        floor += np.bincount(index, minlength=floor.size).reshape(floor.shape)
        segments += np.bincount(walkers.segment[taken], counts.sum(axis=1), minlength=len(segments))
        clock = clock + choice.played[taken].sum(axis=1)
        x, y = (x + walkers.dx[taken]) % nx, (y + walkers.dy[taken]) % ny
        heading, merge = walkers.turned[taken], walkers.merge[taken]
        on = clock < last
        x, y, heading, merge, clock, group = (a[on] for a in (x, y, heading, merge, clock, group))
    floor = free_ground(embedding.environment, floor.reshape(n_groups, nx, ny))
    found = _occupancy(embedding, floor.sum(axis=0), segments, np.nan, np.nan, n_links)
    shares = floor / floor.sum(axis=(1, 2), keepdims=True)
    deviation = shares.std(axis=0, ddof=1) / np.sqrt(n_groups)
    return SimulatedOccupancy(found, deviation, n_walkers, (last - first) / rate)


class _Choices:
    """What walkers can do next, as arrays to look up for many of them at once."""

    def __init__(self, walkers: Walkers):
        n_used, (n_headings, n_cells) = len(walkers.used), walkers.place_shape
        self._walkers = walkers
        self._able = np.zeros((n_used + 1, n_cells), dtype=bool)
        passed = []
        for i in range(n_used):
            self._able[i] = walkers.mask(i).ravel()
            passed.append(walkers.passed_cells(i))
        longest = max(len(x) for x, _ in passed)
        #: (used stencils, longest) cells on the way, and whether they are still on it.
        self.passed_x, self.passed_y = (np.zeros((n_used, longest), dtype=int) for _ in range(2))
        self.played = np.zeros((n_used, longest), dtype=bool)
        for i, (x, y) in enumerate(passed):
            self.passed_x[i, : len(x)], self.passed_y[i, : len(y)], self.played[i, : len(x)] = x, y, True
        # options[merge * n_headings + heading]: stencils of the children, filled up with one that never leads anywhere.
        follows = walkers.between().T[:, walkers.fork] > 0
        options = [np.flatnonzero(row & (walkers.heading == h)) for row in follows for h in range(n_headings)]
        self._options = np.full((len(options), max(len(o) for o in options)), n_used)
        for i, found in enumerate(options):
            self._options[i, : len(found)] = found

    def take(self, x: np.ndarray, y: np.ndarray, heading: np.ndarray, merge: np.ndarray, rng) -> np.ndarray:
        """(n,) used stencil that each walker takes: of those that lead to a node, each with the same probability."""
        at_once = max(LOOKED_UP // self._options.shape[1], 1)
        n_headings, ny = self._walkers.place_shape[0], self._walkers.layout.ny
        taken = []
        for start in range(0, len(x), at_once):
            chunk = slice(start, start + at_once)
            options = self._options[merge[chunk] * n_headings + heading[chunk]]
            able = self._able[options, (x[chunk] * ny + y[chunk])[:, None]].cumsum(axis=1, dtype=np.int32)
            nth = rng.integers(able[:, -1])
            taken.append(options[np.arange(len(options)), np.argmax(able > nth[:, None], axis=1)])
        return np.concatenate(taken)

    def random_nodes(self, n: int, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
        """x, y, heading and merge of n nodes, each with the same probability."""
        alive = self._walkers.alive()
        place = np.searchsorted(
            np.cumsum(alive, dtype=np.float64), rng.integers(alive.sum(dtype=np.float64), size=n), "right"
        )
        merge, heading, cell = np.unravel_index(place, alive.shape)
        return cell // self._walkers.layout.ny, cell % self._walkers.layout.ny, heading, merge
