"""Random walkers one by one: simulated, many at once as arrays, and their stationary distribution by nodes."""

from dataclasses import dataclass

import numpy as np

from core.embedding.embedding import Embedding
from core.evaluation.markov_chain import MarkovChain
from core.evaluation.occupancy import free_ground
from core.progress import finish

#: Bools that are looked up together while walkers choose their next links.
LOOKED_UP = 4_000_000


@dataclass(frozen=True)
class SimulatedOccupancy:
    """Time that simulated walkers spent in each place.

    Attributes
    ----------
    floor : (nx, ny) float array
        Share of the time spent in each cell, of all walkers together; sums to 1.
    segments : (n_segments,) float array
        Share of the time that each segment was played.
    deviation : (nx, ny) float array
        Standard error of each cell's share, from how much groups of walkers differ.
    n_links : int
        Links walked.
    """

    floor: np.ndarray
    segments: np.ndarray
    deviation: np.ndarray
    n_links: int


def simulated_occupancy(
    embedding: Embedding,
    rng: np.random.Generator,
    n_walkers: int,
    duration: float,
    settling: float,
    n_groups: int = 20,
) -> SimulatedOccupancy:
    """Watch random walkers for ``duration`` seconds, after ``settling`` seconds from a random node each."""
    walkers = MarkovChain(embedding)
    choice = _Choices(walkers)
    nx, ny = walkers.layout.nx, walkers.layout.ny
    rate = embedding.graph.frame_rate
    first, last = round(settling * rate), round((settling + duration) * rate)

    x, y, heading, exit_group = choice.random_nodes(n_walkers, rng)
    clock, group = np.zeros(n_walkers, dtype=int), np.arange(n_walkers) % n_groups
    floor, segments, n_links = np.zeros((n_groups, nx * ny)), np.zeros(len(embedding.graph.segments)), 0
    while len(clock):
        taken = choice.take(x, y, heading, exit_group, rng)
        n_links += len(taken)
        frames = clock[:, None] + np.arange(1, choice.passed_x.shape[1] + 1)
        counts = choice.played[taken] & (frames > first) & (frames <= last)
        cell = (x[:, None] + choice.passed_x[taken]) % nx * ny + (y[:, None] + choice.passed_y[taken]) % ny
        index = (group[:, None] * (nx * ny) + cell)[counts]
        floor += np.bincount(index, minlength=floor.size).reshape(floor.shape)
        segments += np.bincount(walkers.segment[taken], counts.sum(axis=1), minlength=len(segments))
        clock = clock + choice.played[taken].sum(axis=1)
        x, y = (x + walkers.dx[taken]) % nx, (y + walkers.dy[taken]) % ny
        heading, exit_group = walkers.turned[taken], walkers.exit_group[taken]
        on = clock < last
        x, y, heading, exit_group, clock, group = (a[on] for a in (x, y, heading, exit_group, clock, group))
    floor = free_ground(embedding.environment, floor.reshape(n_groups, nx, ny))
    total, shares = floor.sum(axis=0), floor / floor.sum(axis=(1, 2), keepdims=True)
    deviation = shares.std(axis=0, ddof=1) / np.sqrt(n_groups)
    return SimulatedOccupancy(total / total.sum(), segments / segments.sum(), deviation, n_links)


def visits(embedding: Embedding, tolerance: float = 1e-5, max_steps: int = 5000) -> np.ndarray:
    """(nx, ny, n_headings, n_segments) float64: the stationary distribution of the walkers' nodes, step by step.

    The share of all steps that end at each node, however long they last. For small grounds: eight bytes for each.
    """
    walkers = MarkovChain(embedding)
    flow = finish(walkers.flow_steps(tolerance, max_steps))
    nx, ny, n_headings, n_segments = embedding.shape
    shares = np.zeros((n_segments, n_headings, nx * ny))
    for i, (segment, turned) in enumerate(zip(walkers.segment.tolist(), walkers.turned.tolist(), strict=True)):
        for leaving, _, target in walkers.moves(walkers.leaving(flow, i), int(walkers.dx[i]), int(walkers.dy[i])):
            shares[segment, turned, target] += leaving
    return (shares / shares.sum()).reshape(n_segments, n_headings, nx, ny).transpose(2, 3, 1, 0)


class _Choices:
    """What walkers can do next, as arrays to look up for many of them at once."""

    def __init__(self, walkers: MarkovChain):
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
        # Stencils of the children by exit group and heading, filled up with one that never leads anywhere.
        follows = walkers.between().T[:, walkers.entry_group] > 0
        options = [np.flatnonzero(row & (walkers.heading == h)) for row in follows for h in range(n_headings)]
        self._options = np.full((len(options), max(len(o) for o in options)), n_used)
        for i, found in enumerate(options):
            self._options[i, : len(found)] = found

    def take(self, x: np.ndarray, y: np.ndarray, heading: np.ndarray, exit_group: np.ndarray, rng) -> np.ndarray:
        """(n,) used stencil that each walker takes: of those that lead to a node, each with the same probability."""
        at_once = max(LOOKED_UP // self._options.shape[1], 1)
        n_headings, ny = self._walkers.place_shape[0], self._walkers.layout.ny
        taken = []
        for start in range(0, len(x), at_once):
            chunk = slice(start, start + at_once)
            options = self._options[exit_group[chunk] * n_headings + heading[chunk]]
            able = self._able[options, (x[chunk] * ny + y[chunk])[:, None]].cumsum(axis=1, dtype=np.int32)
            nth = rng.integers(able[:, -1])
            taken.append(options[np.arange(len(options)), np.argmax(able > nth[:, None], axis=1)])
        return np.concatenate(taken)

    def random_nodes(self, n: int, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
        """x, y, heading and exit group of n nodes, each with the same probability."""
        alive = self._walkers.alive()
        place = np.searchsorted(
            np.cumsum(alive, dtype=np.float64), rng.integers(alive.sum(dtype=np.float64), size=n), "right"
        )
        exit_group, heading, cell = np.unravel_index(place, alive.shape)
        return cell // self._walkers.layout.ny, cell % self._walkers.layout.ny, heading, exit_group
