"""An embedding as a plain table of nodes and links, for engines that would rather look links up than shift bits.

Little-endian numbers without a header, for n nodes and L links: (n, 4) uint16 x, y, heading and segment of each node;
(n + 1,) uint32 where each node's links begin, and the last ones end; (L,) uint32 the node that each link leads to. That
is what :func:`core.tuning.budget.table_bytes` counts, to the byte. Nodes are in order of segment, heading, x and y, the
links of a node in order of the stencils that they play.

What may be played from a cell in a heading is the same for all segments that have the same children (an exit group), so
it is looked up once for each heading: a few cells for each stencil, where the links themselves are many times as many.
"""

from collections.abc import Generator
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..errors import ExportError
from ..progress import Progress
from ..tuning.budget import table_bytes

#: Links and nodes are numbered by 32 bits, parts of a node by 16.
_MOST, _MOST_PARTS = 2**32 - 1, 2**16

#: Bytes beside the table for each node, by which the ways of one heading are reckoned.
_BYTES_BESIDE = 8

#: Part of the work that is done once the links of each plane have been counted.
_COUNTED = 0.1


def engine_table_steps(embedding: Embedding) -> Generator[Progress, None, bytearray]:
    """Make the table.

    Raises ExportError if its numbers do not fit, or making it would take more than ``embedding.settings.memory_limit``
    bytes.
    """
    size = _size(embedding)
    yield Progress(0.0, "Counting links")
    network, (nx, ny, n_headings, n_segments) = embedding.network, embedding.shape
    able = list(embedding.able_starts())
    first_node = [0, *accumulate(plane.bit_count() for plane in embedding.planes)]
    first_link = [0, *accumulate((yield from _leaving_steps(embedding, able)))]

    raw = bytearray(size)
    rows = np.frombuffer(raw, "<u2", 4 * embedding.n_nodes).reshape(-1, 4)
    numbers = np.frombuffer(raw, "<u4", offset=rows.nbytes)
    begins, after = numbers[: len(rows) + 1], numbers[len(rows) + 1 :]
    for heading in range(n_headings):
        ways = _ways_in(embedding, able, first_node, heading)
        for group, members in enumerate(network.exit_groups):
            done = (heading + group / len(network.exit_groups)) / n_headings
            yield Progress(_COUNTED + (1 - _COUNTED) * done, "Listing links")
            playable = np.zeros(n_segments, dtype=bool)
            playable[network.children[members[0]]] = True
            offered = ways.of(playable)
            per_cell = np.bincount(offered.cell, minlength=nx * ny)
            for segment in members:
                plane = segment * n_headings + heading
                if not embedding.planes[plane]:
                    continue
                standing = network.layout.unpack(embedding.planes[plane]).ravel()
                node, link = slice(*first_node[plane : plane + 2]), slice(*first_link[plane : plane + 2])
                cells = np.flatnonzero(standing)
                rows[node, 0], rows[node, 1] = np.divmod(cells, ny)
                rows[node, 2:] = heading, segment
                # Where each begins is where the one before ends; the first of all is 0 already.
                begins[node.start + 1 : node.stop + 1] = link.start + np.cumsum(per_cell[cells])
                after[link] = offered.end[standing[offered.cell]]
    return raw


def _size(embedding: Embedding) -> int:
    """Return the bytes of the table; ExportError if it must not be made."""
    n_nodes, n_links = embedding.n_nodes, embedding.n_links
    size = table_bytes(n_nodes, n_links)
    needed, limit = size + n_nodes * _BYTES_BESIDE, embedding.settings.memory_limit
    if max(n_nodes, n_links) > _MOST or max(embedding.shape) > _MOST_PARTS or needed > limit:
        raise ExportError(
            f"A table of {wording.number(n_nodes)} nodes and {wording.number(n_links)} links would take "
            f"{wording.memory(size)}; prune the embedding, or leave the table out ('Table' when exporting, "
            "'--no-table' on the command line): the planes hold the same."
        )
    return size


def _leaving_steps(embedding: Embedding, able: list[int]) -> Generator[Progress, None, list[int]]:
    """Count the links that leave the nodes of each plane."""
    planes, parents, stencils = embedding.planes, embedding.network.parents, embedding.unrolling.stencils
    n_headings, leaving = stencils.n_headings, [0] * len(planes)
    played = zip(stencils.segment.tolist(), stencils.heading.tolist(), able, strict=True)
    for stencil, (segment, heading, starts) in enumerate(played):
        if starts:
            for parent in parents[segment]:
                plane = parent * n_headings + heading
                leaving[plane] += (planes[plane] & starts).bit_count()
        yield Progress(_COUNTED * stencil / len(able), "Counting links")
    return leaving


@dataclass(frozen=True)
class _Ways:
    """Links that can be played in one heading, whatever came before, in order of cells, then stencils: (w,) arrays.

    Attributes
    ----------
    cell : int, x * ny + y
    segment : int, the one that is played
    end : uint32, number of the node that it leads to
    """

    cell: np.ndarray
    segment: np.ndarray
    end: np.ndarray

    def of(self, playable: np.ndarray) -> "_Ways":
        """Return those that play a segment of an (S,) bool."""
        kept = playable[self.segment]
        return _Ways(self.cell[kept], self.segment[kept], self.end[kept])


def _ways_in(embedding: Embedding, able: list[int], first_node: list[int], heading: int) -> _Ways:
    """Find all ways from cells in a heading to nodes, whichever segment came before."""
    stencils, layout = embedding.unrolling.stencils, embedding.unrolling.layout
    used = [k for k in np.flatnonzero(stencils.heading == heading).tolist() if able[k]]
    arrivals = (stencils.segment * stencils.n_headings + stencils.destination_heading)[used].tolist()
    shifts = layout.shift(stencils.dx[used], stencils.dy[used]).tolist()
    cell, end = [np.empty(0, dtype=np.intp)], [np.empty(0, dtype=np.uint32)]
    for k, arrival, shift in zip(used, arrivals, shifts, strict=True):
        starts = layout.flat_cells(able[k])
        ends = layout.moved(starts, shift)
        number = first_node[arrival] + np.searchsorted(layout.flat_cells(embedding.planes[arrival]), ends)
        cell.append(starts)
        end.append(number.astype(np.uint32))
    segment = np.repeat(stencils.segment[used], [len(starts) for starts in cell[1:]])
    cells = np.concatenate(cell)
    order = np.argsort(cells, kind="stable")
    return _Ways(cells[order], segment[order], np.concatenate(end)[order])
