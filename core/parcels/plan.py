"""Parcels: how a ground is cut, and what neighbours send each other."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product

import numpy as np

from .. import wording
from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION, Grid
from ..environment.regions import RegionMask
from ..errors import EmbeddingError


@dataclass(frozen=True)
class Parcel:
    """The cells (x0 ... x0 + nx - 1, y0 ... y0 + ny - 1) of the ground."""

    x0: int
    y0: int
    nx: int
    ny: int


@dataclass(frozen=True)
class Neighbour:
    """Another parcel (or, around a tiled ground, the same) whose halo this one reaches into.

    Attributes
    ----------
    index : int
    dx, dy : int
        A cell at (x, y) of this parcel's frame is at (x + dx, y + dy) in that of the neighbour.
    """

    index: int
    dx: int
    dy: int


@dataclass(frozen=True)
class ParcelPlan:
    """A ground in parcels.

    All parcels share one frame of cells, large enough for the largest with its halo: their own cells begin at
    (halo_x, halo_y).

    Attributes
    ----------
    grid : Grid
        The whole ground.
    halo_x, halo_y : int
        Cells that the longest one-step path goes away from its start.
    parcels : tuple of Parcel
    """

    grid: Grid
    halo_x: int
    halo_y: int
    parcels: tuple[Parcel, ...]

    @cached_property
    def frame(self) -> Grid:
        """The grid of every parcel with its halo; its origin is not that of any parcel."""
        nx, ny = max(p.nx for p in self.parcels), max(p.ny for p in self.parcels)
        shape = (nx + 2 * self.halo_x, ny + 2 * self.halo_y, self.grid.n_headings)
        return Grid(shape, self.grid.cell_size)

    def own_cells(self, index: int) -> np.ndarray:
        """Return (frame nx, frame ny) bool: the cells that belong to a parcel."""
        parcel, own = self.parcels[index], np.zeros(self.frame.shape[:2], dtype=bool)
        own[self.halo_x : self.halo_x + parcel.nx, self.halo_y : self.halo_y + parcel.ny] = True
        return own

    @cached_property
    def neighbours(self) -> tuple[tuple[Neighbour, ...], ...]:
        """For each parcel, those that see some of its cells in their halo, and whose cells it sees in its own."""
        nx, ny, _ = self.grid.shape
        wraps = (-1, 0, 1) if self.grid.tiled else (0,)
        found: list[tuple[Neighbour, ...]] = []
        for index, parcel in enumerate(self.parcels):
            of_parcel = []
            for other, (wrap_x, wrap_y) in product(range(len(self.parcels)), product(wraps, wraps)):
                if other == index and wrap_x == wrap_y == 0:
                    continue
                there = self.parcels[other]
                dx, dy = parcel.x0 - there.x0 + wrap_x * nx, parcel.y0 - there.y0 + wrap_y * ny
                if (
                    -parcel.nx - self.halo_x < dx < there.nx + self.halo_x
                    and -parcel.ny - self.halo_y < dy < there.ny + self.halo_y
                ):
                    of_parcel.append(Neighbour(other, dx, dy))
            found.append(tuple(of_parcel))
        return tuple(found)

    def crop(self, environment: Environment, index: int, margin: int = 1) -> Environment:
        """Cut out what a parcel sees of the ground: its frame, or with ``margin`` 2 one with halos twice as wide.

        Beyond a ground that is not tiled everything is blocked.
        """
        parcel, (nx, ny, n_headings) = self.parcels[index], self.frame.shape
        grow_x, grow_y = (margin - 1) * self.halo_x, (margin - 1) * self.halo_y
        grid = Grid((nx + 2 * grow_x, ny + 2 * grow_y, n_headings), self.grid.cell_size)
        x = (parcel.x0 - self.halo_x - grow_x) * SUBDIVISION + np.arange(grid.shape[0] * SUBDIVISION)
        y = (parcel.y0 - self.halo_y - grow_y) * SUBDIVISION + np.arange(grid.shape[1] * SUBDIVISION)

        def cut(mask: np.ndarray, outside: bool) -> np.ndarray:
            if self.grid.tiled:
                return mask[np.ix_(x % mask.shape[0], y % mask.shape[1])]
            inside_x, inside_y = (x >= 0) & (x < mask.shape[0]), (y >= 0) & (y < mask.shape[1])
            part = np.full((len(x), len(y)), outside)
            part[np.ix_(inside_x, inside_y)] = mask[np.ix_(x[inside_x], y[inside_y])]
            return part

        regions = tuple(RegionMask(r.name, r.rule, r.tag, cut(r.mask, False)) for r in environment.regions)
        return Environment(grid, cut(environment.blocked, True), regions)


def plan_parcels(grid: Grid, halo_x: int, halo_y: int, cells: int) -> ParcelPlan:
    """Cut a ground into parcels of about ``cells`` x ``cells`` cells, evenly.

    Raises EmbeddingError if the parcels would be narrower than the halo: more than their nearest neighbours would have
    to send them something.
    """
    if cells < max(halo_x, halo_y, 1):
        raise EmbeddingError(
            f"Parcels of {wording.exact(cells * grid.cell_size)} m are shorter than the longest step of "
            f"{wording.exact(max(halo_x, halo_y) * grid.cell_size)} m; use larger ones (--parcels METRES)."
        )
    cuts = []
    for n in grid.shape[:2]:
        edges = np.linspace(0, n, max(n // cells, 1) + 1).round().astype(int)
        cuts.append([(int(a), int(b - a)) for a, b in pairwise(edges)])
    parcels = tuple(Parcel(x0, y0, nx, ny) for x0, nx in cuts[0] for y0, ny in cuts[1])
    return ParcelPlan(grid, halo_x, halo_y, parcels)
