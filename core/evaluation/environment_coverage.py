"""Environment coverage: how much of the free ground walks pass over, and in how many directions.

Reitsma & Pollard 2007, "Evaluating motion graphs for character animation": coverage by position and by position and
heading.
"""

from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding


@dataclass(frozen=True)
class EnvironmentCoverage:
    """How much of the free ground an embedding covers.

    Attributes
    ----------
    covered : (nx, ny, n_headings) bool array
        Where a walk passes.
    free : (nx, ny) bool array
        Cells at whose centre the root may stand.
    by_heading : (n_headings,) float array
        For each heading the share of the free cells, 0 to 1.
    covered_area, free_area : float
        Square metres covered in at least one heading, and free.
    position_share : float
        Share of the free cells that are covered in at least one heading, 0 to 1.
    task_share : float
        Share of the positions and headings over free cells that are covered, 0 to 1.
    full_area : float
        Square metres that are covered in every heading: there the character may come from anywhere.
    """

    covered: np.ndarray
    free: np.ndarray
    by_heading: np.ndarray
    covered_area: float
    free_area: float
    position_share: float
    task_share: float
    full_area: float

    def describe(self) -> str:
        return (
            f"Walks cover {self.covered_area:.1f} of {self.free_area:.1f} m2 of free floor "
            f"({100 * self.position_share:.1f} %), {100 * self.task_share:.1f} % of it by position and heading; "
            f"{self.full_area:.1f} m2 in every heading."
        )


def environment_coverage(embedding: Embedding) -> EnvironmentCoverage:
    """Coverage by position and by position and heading; all shares are 0 where nothing is free."""
    free = embedding.environment.free_cells()
    covered = embedding.covered()
    # A region may let a walk pass where only the cell's centre is blocked: it does not count as free floor.
    counted = covered & free[:, :, None]
    cell_area = embedding.environment.grid.cell_size**2
    n_free = max(int(np.count_nonzero(free)), 1)
    n_cells = int(np.count_nonzero(counted.any(axis=2)))
    return EnvironmentCoverage(
        covered=covered,
        free=free,
        by_heading=np.count_nonzero(counted, axis=(0, 1)) / n_free,
        covered_area=n_cells * cell_area,
        free_area=np.count_nonzero(free) * cell_area,
        position_share=n_cells / n_free,
        task_share=int(np.count_nonzero(counted)) / (n_free * covered.shape[2]),
        full_area=int(np.count_nonzero(counted.all(axis=2))) * cell_area,
    )
