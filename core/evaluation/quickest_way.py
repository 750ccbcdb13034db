"""The ground that quickest walks cover: how far the character walks when it takes the quickest way to a goal."""

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.footprint import edited_path
from ..embedding.link_reader import LinkReader
from .reach import NEVER, ReachField


class WalkedLengths:
    """Lengths of the quickest walks of an embedding, to the goals of any of its fields of times to reach."""

    def __init__(self, embedding: Embedding):
        self._embedding, self._reader = embedding, LinkReader(embedding)
        self._metres = np.full(len(embedding.unrolling.stencils), np.nan)

    def from_cells(self, field: ReachField, cells: np.ndarray) -> np.ndarray:
        """(n,) metres of a quickest walk from each of (n, 2) cells, in whatever heading is best; infinite if none.

        Of several links that are as quick the walk takes the shortest, and of these the first stencil: others that
        arrive as early may be a little longer or shorter.
        """
        nodes = np.array([self._quickest_node(field, cell) for cell in np.asarray(cells).tolist()], dtype=int)
        metres = np.zeros(len(nodes))
        left = field.frames_at(nodes)
        metres[left == NEVER] = np.inf
        on = np.flatnonzero((left > 0) & (left != NEVER))
        while len(on):
            rows, stencils = self._reader.links_from(nodes[on])
            ends = self._reader.wrapped(self._reader.ends(nodes[on][rows], stencils))
            quick = field.on_quickest_way(nodes[on][rows], ends)
            rows, stencils, ends = rows[quick], stencils[quick], ends[quick]
            lengths = self._lengths(stencils)
            order = np.lexsort((stencils, lengths, rows))
            # Every node with a time has a quickest link: as many are chosen as there are rows.
            chosen = order[np.flatnonzero(np.diff(rows[order], prepend=-1))]
            metres[on] += lengths[chosen]
            nodes[on] = ends[chosen]
            on = on[field.frames_at(nodes[on]) > 0]
        return metres

    def _quickest_node(self, field: ReachField, cell: list[int]) -> tuple[int, int, int, int]:
        """The node of a cell with the least time; the one of the lowest segment and heading if there are several."""
        _, _, n_headings, n_segments = self._embedding.shape
        segment, heading = np.divmod(np.arange(n_segments * n_headings), n_headings)
        here = np.column_stack([np.broadcast_to(cell, (len(segment), 2)), heading, segment])
        best = int(np.argmin(field.frames_at(here)))
        return cell[0], cell[1], int(heading[best]), int(segment[best])

    def _lengths(self, stencils: np.ndarray) -> np.ndarray:
        """(n,) metres of the edited paths of stencils, each measured once."""
        known, of = self._embedding.unrolling.stencils, self._embedding.graph.segments
        for k in np.unique(stencils[np.isnan(self._metres[stencils])]).tolist():
            path = edited_path(
                of[known.segment[k]],
                int(known.heading[k]),
                self._embedding.environment.grid,
                known.position_error[k],
                known.heading_error[k],
            )
            self._metres[k] = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum()
        return self._metres[stencils]
