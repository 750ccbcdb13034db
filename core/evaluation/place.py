"""Everything there is to know about one place on the ground."""

from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..wording import angle, counted, number, place
from .why_not import Reason, floor_reasons, place_reason


@dataclass(frozen=True)
class PlaceReport:
    """Everything there is to know about one cell.

    Attributes
    ----------
    cell : (x, y)
        Index of the cell.
    position : (x, y)
        Its centre in metres.
    variability : (n_headings,) int array
        For each heading the number of ways to pass.
    reason : str
        Why the character can, or cannot, go there; empty if the reasons are not known.
    segments : tuple of (name, ways)
        Segments that can end there, with the ways through it, in all headings together; most ways first.
    """

    cell: tuple[int, int]
    position: tuple[float, float]
    variability: np.ndarray
    reason: str
    segments: tuple[tuple[str, int], ...]

    @property
    def n_covered(self) -> int:
        """Headings in which the character can pass."""
        return int(np.count_nonzero(self.variability))

    def lines(self, n_segments: int = 4) -> list[str]:
        """The report in short lines."""
        n_headings, ways = len(self.variability), int(self.variability.sum())
        lines = [f"Cell {self.cell[0]}, {self.cell[1]} at {place(*self.position)}"]
        if self.reason:
            lines.append(self.reason)
        if ways == 0:
            return lines
        best = int(np.argmax(self.variability))
        lines.append(f"{counted(ways, 'way')} in {self.n_covered} of {counted(n_headings, 'heading')}")
        lines.append(f"Most at {angle(2 * np.pi * best / n_headings)}: {counted(int(self.variability[best]), 'way')}")
        ending = "segment ends" if len(self.segments) == 1 else "segments end"
        lines.append(f"{number(len(self.segments))} {ending} here:")
        lines += [f"  {name}: {counted(count, 'way')}" for name, count in self.segments[:n_segments]]
        if len(self.segments) > n_segments:
            lines.append(f"  and {len(self.segments) - n_segments} more")
        return lines


def place_report(embedding: Embedding, x: float, y: float, reasons: np.ndarray | None = None) -> PlaceReport | None:
    """What there is to know about the cell at x, y (m); None beside the ground.

    ``reasons`` is what ``why_not(embedding)`` gave, (nx, ny, n_headings), if anybody asked; it takes about as long as
    embedding, everything else here no time.
    """
    grid = embedding.environment.grid
    cell = grid.cells(np.array([x, y]))
    size = np.array(grid.shape[:2])
    if grid.tiled:
        cell = cell % size
    if np.any(cell < 0) or np.any(cell >= size):
        return None
    column, row = cell.tolist()
    ways = _ways_at(embedding, column, row)
    totals = ways.sum(axis=1)
    present = _present_at(embedding, column, row).any(axis=1)
    order = sorted(np.flatnonzero(present).tolist(), key=lambda s: (-totals[s], s))
    reason = ""
    if reasons is not None:
        floor = floor_reasons(reasons[column : column + 1, row : row + 1])
        reason = place_reason(Reason(int(floor[0, 0])), embedding.environment, column, row)
    position = grid.positions(cell)
    return PlaceReport(
        cell=(column, row),
        position=(float(position[0]), float(position[1])),
        variability=ways.sum(axis=0),
        reason=reason,
        segments=tuple((embedding.graph.segments[s].name, int(totals[s])) for s in order),
    )


def _present_at(embedding: Embedding, x: int, y: int) -> np.ndarray:
    """(n_segments, n_headings) bool: the nodes that stand in a cell."""
    bit = embedding.unrolling.layout.bit(x, y)
    _, _, n_headings, n_segments = embedding.shape
    here = [plane >> bit & 1 for plane in embedding.planes]
    return np.array(here, dtype=bool).reshape(n_segments, n_headings)


def _ways_at(embedding: Embedding, x: int, y: int) -> np.ndarray:
    """(n_segments, n_headings) int64: segment variability of the nodes in a cell, link by link.

    Only the stencils that start or end there are looked at: a whole map of degrees takes longer, and much memory.
    """
    nx, ny, n_headings, n_segments = embedding.shape
    layout, stencils, planes = embedding.unrolling.layout, embedding.unrolling.stencils, embedding.planes
    tiled, network = embedding.environment.grid.tiled, embedding.network
    here = layout.bit(x, y)

    def bit_after(column: int, row: int) -> int | None:
        if tiled:
            return layout.bit(column % nx, row % ny)
        return layout.bit(column, row) if 0 <= column < nx and 0 <= row < ny else None

    arriving = np.zeros((n_segments, n_headings), dtype=np.int64)
    landing = np.zeros((n_segments, n_headings), dtype=np.int64)
    rows = zip(
        stencils.segment.tolist(),
        stencils.heading.tolist(),
        stencils.destination_heading.tolist(),
        stencils.dx.tolist(),
        stencils.dy.tolist(),
        embedding.unrolling.valid,
        strict=True,
    )
    for segment, heading, turned, dx, dy, valid in rows:
        start = bit_after(x - dx, y - dy)
        if start is not None and valid >> start & 1:
            arriving[segment, turned] += sum(
                planes[parent * n_headings + heading] >> start & 1 for parent in network.parents[segment]
            )
        if valid >> here & 1:
            end = bit_after(x + dx, y + dy)
            if end is not None and planes[segment * n_headings + turned] >> end & 1:
                landing[segment, heading] += 1
    leaving = np.array([landing[children].sum(axis=0) for children in network.children])
    return arriving * leaving * _present_at(embedding, x, y)
