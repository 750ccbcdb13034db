"""Environment coverage: how much of the free ground walks pass over, and in how many directions.

Reitsma & Pollard 2007, "Evaluating motion graphs for character animation": coverage by position and by position and
heading.
"""

from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from .floor import floor_cells


@dataclass(frozen=True)
class EnvironmentCoverage:
    """The part of the free ground that an embedding covers.

    Attributes
    ----------
    covered : (nx, ny, n_headings) bool array
        Where a walk passes.
    floor : (nx, ny) bool array
        Cells that count, see :func:`.floor.floor_cells`; all that is covered is among them.
    by_heading : (n_headings,) float array
        For each heading the share of the floor, 0 to 1.
    covered_area, free_area : float
        Square metres covered in at least one heading, and of the whole floor.
    position_share : float
        Share of the floor's cells that are covered in at least one heading, 0 to 1.
    task_share : float
        Share of the positions and headings over the floor that are covered, 0 to 1.
    full_area : float
        Square metres that are covered in every heading: there the character may come from anywhere.
    """

    covered: np.ndarray
    floor: np.ndarray
    by_heading: np.ndarray
    covered_area: float
    free_area: float
    position_share: float
    task_share: float
    full_area: float

    def describe(self) -> str:
        return (
            f"Walks cover {wording.area(self.covered_area)} of {wording.area(self.free_area)} of free floor "
            f"({wording.share(self.position_share)}), {wording.share(self.task_share)} of it by position and heading; "
            f"{wording.area(self.full_area)} in every heading."
        )


def environment_coverage(embedding: Embedding) -> EnvironmentCoverage:
    """Measure coverage by position and by position and heading; all shares are 0 where nothing is free."""
    floor = floor_cells(embedding)
    # A path ends free, at a cell's centre: whatever is covered lies on the floor.
    covered = embedding.covered()
    cell_area = embedding.environment.grid.cell_size**2
    n_free = max(int(np.count_nonzero(floor)), 1)
    n_cells = int(np.count_nonzero(covered.any(axis=2)))
    return EnvironmentCoverage(
        covered=covered,
        floor=floor,
        by_heading=np.count_nonzero(covered, axis=(0, 1)) / n_free,
        covered_area=n_cells * cell_area,
        free_area=np.count_nonzero(floor) * cell_area,
        position_share=n_cells / n_free,
        task_share=int(np.count_nonzero(covered)) / (n_free * covered.shape[2]),
        full_area=int(np.count_nonzero(covered.all(axis=2))) * cell_area,
    )
