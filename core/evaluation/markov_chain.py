"""The Markov chain of random walkers: at every node each outgoing link is taken with the same probability.

Where a walker can go on depends on where it stands and on which segments may follow, and the latter is the same for
all segments of an exit group. Walkers of one exit group at one place are therefore counted together: the flow of all of
them is one number for each place and exit group, pushed along one stencil after the other as an array over the whole
ground. No link is ever stored, however many there are. Walks of :mod:`core.playback` follow the same rule.
"""

from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.footprint import edit_profile, rotated_path
from ..environment.grid import SUBDIVISION
from ..errors import EmbeddingError
from ..progress import Progress

#: After so many steps one looks how far the flow has settled, and half of the walkers wait out that step: chains that
#: go in circles settle too, and others hardly later.
STEPS_BETWEEN_LOOKS = 5

#: Up to so many places and exit groups the flow is kept in double precision; beyond it memory and time count more.
DOUBLE_PRECISION = 2_000_000

#: Stencils' places are kept as arrays up to this many bytes, and laid out again at every step beyond it.
KEPT_BYTES = 1e9


@dataclass(frozen=True)
class StationaryFlow:
    """The stationary flow of random walkers, per step: what each does next, once it has walked for ever.

    Attributes
    ----------
    starts : (entry groups, n_headings, nx * ny) float array
        For one segment of each entry group: the probability that a step starts at the place and takes one of its links.
    residual : float
        By how much one more step changes the distribution: the sum of the absolute changes, 0 to 2.
    error : float
        About how far the distribution is from the one that it settles to: the residual, and all that would follow.
    n_steps : int
        Steps taken.
    """

    starts: np.ndarray
    residual: float
    error: float
    n_steps: int


class MarkovChain:
    """The random walkers of an embedding; its arrays are those of the embedding's network."""

    def __init__(self, embedding: Embedding):
        if not embedding.n_nodes:
            raise EmbeddingError(
                "The embedding is empty: no endless walk fits into this scene, and nobody can walk it."
            )
        network, stencils = embedding.network, embedding.unrolling.stencils
        self.embedding = embedding
        self.network = network
        self.layout = embedding.unrolling.layout
        able = list(embedding.able_starts())
        #: Stencils that any link uses, and the planes of the cells from which they lead to a node.
        self.used = np.flatnonzero([plane != 0 for plane in able])
        self._planes = [able[k] for k in self.used.tolist()]
        self.segment = stencils.segment[self.used]
        self.heading = stencils.heading[self.used]
        self.turned = stencils.destination_heading[self.used]
        self.dx, self.dy = stencils.dx[self.used], stencils.dy[self.used]
        self.entry_group = np.array(network.entry_group_of)[self.segment]
        self.exit_group = np.array(network.exit_group_of)[self.segment]

    @property
    def place_shape(self) -> tuple[int, int]:
        """(n_headings, nx * ny)"""
        return self.network.n_headings, self.layout.nx * self.layout.ny

    @property
    def dtype(self) -> type:
        """Float type of all shares and probabilities."""
        n_places = len(self.network.exit_groups) * int(np.prod(self.place_shape))
        return np.float64 if n_places <= DOUBLE_PRECISION else np.float32

    def mask(self, i: int) -> np.ndarray:
        """(nx, ny): 1 where the i-th used stencil leads to a node, 0 elsewhere."""
        return self.layout.unpack(self._planes[i]).astype(self.dtype)

    def leaving(self, flow: StationaryFlow, i: int) -> np.ndarray:
        """(nx, ny) float64: how often the i-th used stencil is taken from each cell, per step."""
        mask = self.mask(i)
        return flow.starts[self.entry_group[i], self.heading[i]].reshape(mask.shape) * mask.astype(np.float64)

    def between(self) -> np.ndarray:
        """(entry groups, exit groups): 1 where segments of the entry group may follow those of the exit group."""
        between = np.zeros((len(self.network.entry_groups), len(self.network.exit_groups)), dtype=self.dtype)
        for entry_group, exit_groups in enumerate(self.network.exit_groups_before):
            between[entry_group, exit_groups] = 1
        return between

    def out_degree(self) -> np.ndarray:
        """(exit groups, n_headings, nx * ny): links that a walker of each exit group can take from each place."""
        landing = np.zeros((len(self.network.entry_groups), *self.place_shape), dtype=self.dtype)
        for i, (entry_group, heading) in enumerate(zip(self.entry_group.tolist(), self.heading.tolist(), strict=True)):
            landing[entry_group, heading] += self.mask(i).ravel()
        return np.tensordot(self.between().T, landing, axes=1)

    def alive(self) -> np.ndarray:
        """(exit groups, n_headings, nx * ny): how many nodes of each exit group there are at each place."""
        alive = np.zeros((len(self.network.exit_groups), *self.place_shape), dtype=self.dtype)
        for index, plane in enumerate(self.embedding.planes):
            if plane:
                segment, heading = divmod(index, self.network.n_headings)
                alive[self.network.exit_group_of[segment], heading] += self.layout.unpack(plane).ravel()
        return alive

    def flow_steps(self, tolerance: float, max_steps: int) -> Generator[Progress, None, StationaryFlow]:
        """Find the stationary flow by power iteration from evenly spread walkers. Yields progress.

        Ends when the residual is below ``tolerance``, or does not fall any more because of rounding, or after
        ``max_steps``.
        """
        between, degree = self.between(), self.out_degree()
        share = np.divide(1, degree, out=np.zeros_like(degree), where=degree > 0)
        del degree
        arrived = self.alive()
        arrived /= self.embedding.n_nodes
        starts = np.empty((len(between), *self.place_shape), dtype=self.dtype)
        weighted, waiting = np.empty_like(arrived), np.empty_like(arrived)
        n_bytes = arrived.itemsize * len(self.used) * self.place_shape[1]
        kept = list(self._pushes(starts, arrived)) if n_bytes <= KEPT_BYTES else None
        rounding = 100 * float(np.finfo(self.dtype).eps)
        residual, n_steps, error = np.inf, 0, np.inf
        while residual > tolerance and n_steps < max_steps:
            n_steps += 1
            looking = n_steps % STEPS_BETWEEN_LOOKS == 0 or n_steps == max_steps
            if looking:
                waiting[:] = arrived
            np.multiply(arrived, share, out=weighted)
            np.matmul(between, weighted.reshape(len(weighted), -1), out=starts.reshape(len(starts), -1))
            arrived[:] = 0
            for source, mask, room, target in kept or self._pushes(starts, arrived):
                np.multiply(source, mask, out=room)
                np.add(target, room, out=target)
            if looking:
                np.subtract(arrived, waiting, out=weighted)
                before, residual = residual, float(np.abs(weighted, out=weighted).sum(dtype=np.float64))
                falling = (residual / before) ** (1 / STEPS_BETWEEN_LOOKS) if 0 < before < np.inf else 0.5
                error = residual / (1 - min(falling, 1 - 1e-6))
                if residual < rounding and falling > 0.99:
                    break
                done = np.log(max(residual, tolerance) / 2) / np.log(tolerance / 2)
                yield Progress(float(min(max(done, 0.0), 1.0)), "Letting walkers settle")
                arrived += waiting
                arrived /= arrived.sum(dtype=np.float64)
        return StationaryFlow(starts, residual, error, n_steps)

    def _pushes(self, starts: np.ndarray, arrived: np.ndarray) -> Iterator[tuple[np.ndarray, ...]]:
        """Yield source, mask, room for the product and target of each piece that a stencil moves as a whole."""
        room = np.empty(self.place_shape[1], dtype=self.dtype)
        columns = (self.entry_group, self.heading, self.exit_group, self.turned, self.dx, self.dy)
        for i, row in enumerate(zip(*(column.tolist() for column in columns), strict=True)):
            entry_group, heading, exit_group, turned, dx, dy = row
            for mask, source, target in self.moves(self.mask(i), dx, dy):
                yield starts[entry_group, heading, source], mask, room[: len(mask)], arrived[exit_group, turned, target]

    def moves(self, values: np.ndarray, dx: int, dy: int) -> Iterator[tuple[np.ndarray, slice, slice]]:
        """Split a move of (nx, ny) ``values`` by dx, dy cells into pieces that move as a whole.

        Each piece is a range of the cells x * ny + y: the values there, the range, and the range where they arrive.
        Around the edges of a tiled ground there is more than one piece. Elsewhere nothing may leave the ground.
        """
        nx, ny = values.shape
        if not self.layout.tiled:
            yield from _range(values.ravel(), dx * ny + dy)
            return
        around_x, around_y = (np.arange(nx) + dx) // nx, (np.arange(ny) + dy) // ny
        for a in np.unique(around_x).tolist():
            for b in np.unique(around_y).tolist():
                part = np.where(np.logical_and.outer(around_x == a, around_y == b), values, 0)
                yield from _range(part.ravel(), (dx - a * nx) * ny + dy - b * ny)

    def passed_cells(self, i: int) -> tuple[np.ndarray, np.ndarray]:
        """Cells relative to the start, (F - 1,) x and y, where the i-th used stencil is halfway between its frames."""
        k, grid = int(self.used[i]), self.embedding.environment.grid
        segment, stencils = self.embedding.graph.segments[int(self.segment[i])], self.embedding.unrolling.stencils
        path = rotated_path(segment, int(self.heading[i]) * grid.heading_step)
        path = path + edit_profile(segment)[:, None] * stencils.position_error[k]
        # As the path is checked: in samples from the corner of the start cell.
        samples = path / grid.sample_size + SUBDIVISION / 2
        cells = np.floor((samples[1:] + samples[:-1]) / 2).astype(int) // SUBDIVISION
        return cells[:, 0], cells[:, 1]


def _range(values: np.ndarray, shift: int) -> Iterator[tuple[np.ndarray, slice, slice]]:
    """The values from the first to the last that is not 0, their range and that ``shift`` farther on."""
    # What lies between the ends of two rows is 0, and may arrive anywhere.
    cells = np.flatnonzero(values)
    if len(cells):
        first, last = int(cells[0]), int(cells[-1]) + 1
        yield values[first:last], slice(first, last), slice(first + shift, last + shift)
