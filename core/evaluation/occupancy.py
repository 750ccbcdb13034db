"""Occupancy: the share of the time that random walkers spend in each place (the stationary distribution)."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from .. import wording
from ..embedding.embedding import Embedding
from ..environment.environment import Environment
from ..errors import EmbeddingError
from ..progress import Progress, portion
from .markov_chain import MarkovChain, StationaryFlow


@dataclass(frozen=True)
class Occupancy:
    """Shares of the time that walkers spend in each place.

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
        absolute differences of the shares.
    n_steps : int
        Steps of the iteration.
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
            f"These shares are exact but for {wording.share(self.error)} of the time, after "
            f"{wording.counted(self.n_steps, 'step')}.",
        ]


def occupancy_steps(
    embedding: Embedding, tolerance: float = 1e-5, max_steps: int = 5000
) -> Generator[Progress, None, Occupancy]:
    """Find where random walkers spend their time in the long run, if each outgoing link is as likely as the others.

    Power iteration of the stationary distribution over all nodes, each weighted by the duration of the links taken
    there. Ends when one more step would move less than ``tolerance`` of the walkers, or after ``max_steps`` steps: the
    result holds its ``residual``. Walkers wait now and then, so that chains that go in circles settle too.

    Raises
    ------
    EmbeddingError
        The embedding is empty, or the tolerance is not positive.
    """
    if not (tolerance > 0 and max_steps > 0):
        raise EmbeddingError(f"A tolerance of {tolerance} after {max_steps} steps cannot be met; make both positive.")
    chain = MarkovChain(embedding)
    flow = yield from portion(chain.flow_steps(tolerance, max_steps), 0.0, 0.9)
    yield Progress(0.9, "Following paths")
    floor, segments = _along_paths(chain, flow)
    grid = embedding.environment.grid
    x, y = grid.positions(np.array(np.unravel_index(np.argmax(floor), floor.shape))).tolist()
    shares = floor / floor.sum(), segments / segments.sum()
    return Occupancy(*shares, grid.cell_size**2, (x, y), flow.residual, flow.error, flow.n_steps)


def _along_paths(chain: MarkovChain, flow: StationaryFlow) -> tuple[np.ndarray, np.ndarray]:
    """Time in each cell and time of each segment, in frames per step."""
    nx, ny = chain.layout.nx, chain.layout.ny
    floor, segments = np.zeros(nx * ny), np.zeros(chain.embedding.shape[3])
    for i, segment in enumerate(chain.segment.tolist()):
        leaving = chain.leaving(flow, i)
        x, y = chain.passed_cells(i)
        segments[segment] += leaving.sum() * len(x)
        passed, n_frames = np.unique(np.column_stack([x, y]), axis=0, return_counts=True)
        for (dx, dy), n in zip(passed.tolist(), n_frames.tolist(), strict=True):
            for moving, _, target in chain.moves(leaving, dx, dy):
                floor[target] += n * moving
    return free_ground(chain.embedding.environment, floor.reshape(nx, ny)), segments


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
