"""Space-time reservation: the places that walkers have reserved on the ground, frame by frame."""

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.footprint import edit_profile, rotated_path

#: Metres kept beyond what is asked, for rounding.
ROUNDING = 1e-9


class StencilPaths:
    """The root at every frame of every stencil's edited path, relative to the start.

    Attributes
    ----------
    positions : (K, F, 2) float array
        Metres at frames 1 to F; not a number after the stencil's last frame.
    n_frames : (K,) int array
        Frames from the start of each stencil to its end.
    """

    def __init__(self, embedding: Embedding):
        stencils, segments = embedding.unrolling.stencils, embedding.graph.segments
        angles = np.arange(stencils.n_headings) * embedding.environment.grid.heading_step
        lengths = np.array([segment.n_frames - 1 for segment in segments])
        self.n_frames = lengths[stencils.segment]
        self.positions = np.full((len(stencils), lengths.max(), 2), np.nan)
        for index, segment in enumerate(segments):
            chosen = np.flatnonzero(stencils.segment == index)
            paths = rotated_path(segment, angles)[stencils.heading[chosen]]
            paths = paths + edit_profile(segment)[:, None] * stencils.position_error[chosen][:, None]
            self.positions[chosen, : lengths[index]] = paths[:, 1:]
        self.reach = float(np.nanmax(np.linalg.norm(self.positions, axis=2)))


class Reservation:
    """The places of ``n_walkers`` walkers over ``n_frames`` frames; all free to begin with.

    Parameters
    ----------
    distance : float
        Metres that any two walkers keep between them, around the edges of a tiled ground too.
    """

    def __init__(self, embedding: Embedding, n_walkers: int, n_frames: int, distance: float):
        grid = embedding.environment.grid
        self._size = np.array(grid.size) if grid.tiled else None
        self._distance = distance + ROUNDING
        self._places = np.full((n_walkers, n_frames, 2), np.nan)

    def reserve(self, walker: int, places: np.ndarray) -> None:
        """Reserve (F, 2) places from frame 0 on, instead of what ``walker`` had before."""
        self.release(walker)
        self._places[walker, : len(places)] = places

    def release(self, walker: int) -> None:
        self._places[walker] = np.nan

    def conflicts(self, frame: int, start: np.ndarray, paths: np.ndarray, reach: float) -> np.ndarray:
        """Test which of (L, F, 2) paths come too close to whom: (L, n_walkers) bool.

        The first place of each path is that of ``frame``; no place is farther than ``reach`` from ``start``.
        """
        conflicts = np.zeros((len(paths), len(self._places)), dtype=bool)
        theirs = self._places[:, frame : frame + paths.shape[1]]
        # Few walkers are near: the others need no comparison with every path. Comparing with NaN is false.
        near = np.flatnonzero((self._squares(theirs - start) < (reach + self._distance) ** 2).any(axis=1))
        if len(near):
            paths = paths[:, : theirs.shape[1]]
            apart = self._squares(paths[:, None] - theirs[near])
            conflicts[:, near] = (apart < self._distance**2).any(axis=2)
        return conflicts

    def _squares(self, apart: np.ndarray) -> np.ndarray:
        if self._size is not None:
            apart = apart - self._size * np.rint(apart / self._size)
        return np.einsum("...i,...i->...", apart, apart)
