"""Report on one place on the ground."""

from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader
from ..wording import angle, counted, number, place
from .why_not import Reason, floor_reasons, place_reason


@dataclass(frozen=True)
class PlaceReport:
    """The numbers of one cell.

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
        """Return the report in short lines."""
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
    """Report on the cell at x, y (m); None beside the ground.

    ``reasons`` is what :func:`.why_not.why_not_steps` gave, (nx, ny, n_headings), if anybody asked; it takes about as
    long as embedding, everything else here no time.
    """
    grid, (nx, ny, n_headings, n_segments) = embedding.environment.grid, embedding.shape
    cell = grid.cells(np.array([x, y]))
    if grid.tiled:
        cell = cell % (nx, ny)
    if np.any(cell < 0) or np.any(cell >= (nx, ny)):
        return None
    column, row = cell.tolist()
    segment, heading = np.divmod(np.arange(n_segments * n_headings), n_headings)
    nodes = np.column_stack([np.broadcast_to(cell, (len(segment), 2)), heading, segment])
    links = LinkReader(embedding)
    nodes = nodes[links.are_nodes(nodes)]
    ways = np.zeros((n_segments, n_headings), dtype=np.int64)
    ways[nodes[:, 3], nodes[:, 2]] = links.variability(nodes)
    totals = ways.sum(axis=1)
    order = sorted(np.unique(nodes[:, 3]).tolist(), key=lambda s: (-totals[s], s))
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
