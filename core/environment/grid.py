"""The grid of task coordinates p = (x, y, heading) over a ground rectangle."""

from dataclasses import dataclass

import numpy as np

from .. import wording
from ..errors import SceneError

#: Obstacles and paths are resolved on SUBDIVISION x SUBDIVISION samples to a cell.
SUBDIVISION = 4

#: A tenth of a degree each: no motion tells more apart.
MOST_HEADINGS = 3600


@dataclass(frozen=True)
class Grid:
    """Cells over the ground x evenly spaced headings.

    Attributes
    ----------
    shape : (nx, ny, n_headings)
    cell_size : float
        Side of a cell in metres.
    origin : (x, y)
        Corner of cell (0, 0) with the lowest coordinates, in metres. A character at cell (i, j) stands at its centre.
    tiled : bool
        The rectangle is a torus: who leaves it on one side enters it on the other.
    """

    shape: tuple[int, int, int]
    cell_size: float
    origin: tuple[float, float] = (0.0, 0.0)
    tiled: bool = False

    def __post_init__(self):
        if len(self.shape) != 3 or any(int(n) != n or n < 1 for n in self.shape):
            raise SceneError(
                f"The grid has {self.shape} cells and headings; it needs whole numbers, at least one of each."
            )
        if self.n_headings > MOST_HEADINGS:
            raise SceneError(
                f"{wording.number(self.n_headings)} Headings are more than anybody can tell apart; use "
                f"{wording.number(MOST_HEADINGS)} or fewer."
            )
        if not (np.isfinite(self.cell_size) and self.cell_size > 0):
            raise SceneError(f"The Cell Size is {self.cell_size}; it must be a positive length.")
        if not np.isfinite(self.origin).all():
            raise SceneError("The ground's corner has a coordinate that is not a number; check the ground object.")

    @classmethod
    def over_rectangle(
        cls,
        low: tuple[float, float],
        high: tuple[float, float],
        cell_size: float,
        n_headings: int,
        tiled: bool = False,
    ) -> "Grid":
        """Return the grid over the rectangle from ``low`` to ``high`` (m), centred on it.

        Cells never reach outside the rectangle, so that a last strip narrower than a cell is left out; a tiled
        ground must be a whole number of cells wide, because its opposite sides are joined.

        >>> grid = Grid.over_rectangle((0, 0), (7.1, 8), cell_size=0.5, n_headings=24)
        >>> grid.shape, tuple(round(x, 2) for x in grid.origin)
        ((14, 16, 24), (0.05, 0.0))
        """
        extent = np.subtract(high, low)
        if not np.isfinite(extent).all() or np.any(extent <= 0):
            raise SceneError("The ground rectangle is empty; give it a width and a depth greater than zero.")
        if not (np.isfinite(cell_size) and cell_size > 0):
            raise SceneError(f"The Cell Size is {cell_size}; it must be a positive length.")
        # A cell size that came through single precision misses a whole number of cells by a hair.
        n_cells = extent / cell_size
        if not np.all(n_cells < 1e9):
            raise SceneError(
                f"The ground of {wording.exact(extent[0])} x {wording.exact(extent[1])} m has too many cells of "
                f"{wording.exact(cell_size)} m; use a larger Cell Size or a smaller ground."
            )
        whole = np.abs(n_cells - np.rint(n_cells)) <= 1e-4 + 1e-6 * n_cells
        cells = np.where(whole, np.rint(n_cells), np.floor(n_cells)).astype(int)
        if np.any(cells < 1):
            raise SceneError(
                f"The ground of {wording.exact(extent[0])} x {wording.exact(extent[1])} m is smaller than one cell "
                f"of {wording.exact(cell_size)} m; use a smaller Cell Size or a larger ground."
            )
        rest = extent - cells * cell_size
        if tiled and not whole.all():
            raise SceneError(
                f"A tiled ground must be a whole number of cells wide: {wording.exact(extent[0])} x "
                f"{wording.exact(extent[1])} m is not a multiple of {wording.exact(cell_size)} m; change Cell Size or "
                "the ground."
            )
        origin = np.asarray(low, dtype=float) + rest / 2
        return cls((int(cells[0]), int(cells[1]), int(n_headings)), float(cell_size), tuple(origin.tolist()), tiled)

    @property
    def n_headings(self) -> int:
        return self.shape[2]

    @property
    def heading_step(self) -> float:
        """Angle between neighbouring headings in radians."""
        return 2 * np.pi / self.shape[2]

    @property
    def sample_size(self) -> float:
        """Side of one sample of the obstacle masks in metres."""
        return self.cell_size / SUBDIVISION

    @property
    def size(self) -> tuple[float, float]:
        """Width and depth of the ground in metres."""
        return self.shape[0] * self.cell_size, self.shape[1] * self.cell_size

    @property
    def corners(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Lowest and highest x and y of the ground in metres."""
        (x, y), (width, depth) = self.origin, self.size
        return (x, y), (x + width, y + depth)

    def positions(self, cells: np.ndarray) -> np.ndarray:
        """(..., 2) world x, y in metres of the centres of (..., 2) cells; cells may lie outside (unwrapped tiles)."""
        return np.asarray(self.origin) + (np.asarray(cells) + 0.5) * self.cell_size

    def cells(self, positions: np.ndarray) -> np.ndarray:
        """Return (..., 2) integer cells that hold the (..., 2) world positions; may lie outside the grid."""
        return np.floor((np.asarray(positions) - self.origin) / self.cell_size).astype(int)
