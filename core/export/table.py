"""An embedding as a plain table of nodes and links, for engines that would rather look links up than shift bits.

Little-endian numbers without a header, for n nodes and L links: (n, 4) uint16 x, y, heading and segment of each node;
(n + 1,) uint32 where each node's links begin, and the last ones end; (L,) uint32 the node that each link leads to. That
is what :func:`core.tuning.budget.table_bytes` counts, to the byte. Nodes are in order of segment, heading, x and y, the
links of a node in order of the stencils that they play.
"""

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader
from ..errors import ExportError
from ..tuning.budget import table_bytes

#: Nodes whose links are looked up together: what that takes does not count beside a table that matters.
_NODES_AT_ONCE = 5_000

#: Links and nodes are numbered by 32 bits, parts of a node by 16.
_MOST, _MOST_PARTS = 2**32 - 1, 2**16

#: Bytes beside the table for each node: its state's number, by which links find it.
_BYTES_BESIDE = 8


def engine_table(embedding: Embedding) -> bytearray:
    """The table.

    Raises ExportError if its numbers do not fit, or making it would take more than ``embedding.settings.memory_limit``
    bytes.
    """
    nx, ny, n_headings, _ = embedding.shape
    n_nodes, n_links = embedding.n_nodes, embedding.n_links
    size = table_bytes(n_nodes, n_links)
    needed, limit = size + n_nodes * _BYTES_BESIDE, embedding.settings.memory_limit
    if max(n_nodes, n_links) > _MOST or max(embedding.shape) > _MOST_PARTS or needed > limit:
        raise ExportError(
            f"A table of {wording.number(n_nodes)} nodes and {wording.number(n_links)} links would take "
            f"{wording.memory(size)}; prune the embedding, or leave the table out ('Table' when exporting, "
            "'--no-table' on the command line): the planes hold the same."
        )
    raw = bytearray(size)
    rows = np.frombuffer(raw, "<u2", 4 * n_nodes).reshape(n_nodes, 4)
    numbers = np.frombuffer(raw, "<u4", offset=rows.nbytes)
    begins, after = numbers[: n_nodes + 1], numbers[n_nodes + 1 :]
    states, reader, end = _states(embedding), LinkReader(embedding), 0
    for first in range(0, n_nodes, _NODES_AT_ONCE):
        place, cell = np.divmod(states[first : first + _NODES_AT_ONCE], nx * ny)
        nodes = np.column_stack([*np.divmod(cell, ny), place % n_headings, place // n_headings])
        rows[first : first + len(nodes)] = nodes
        row, stencil = reader.links_from(nodes)
        x, y, heading, segment = reader.wrapped(reader.ends(nodes[row], stencil)).T
        there = ((segment * n_headings + heading) * nx + x) * ny + y
        after[end : end + len(row)] = np.searchsorted(states, there)
        begins[first + 1 : first + 1 + len(nodes)] = end + np.cumsum(np.bincount(row, minlength=len(nodes)))
        end += len(row)
    return raw


def _states(embedding: Embedding) -> np.ndarray:
    """(n,) int: numbers of all states that are nodes, ascending."""
    layout, n_cells = embedding.unrolling.layout, embedding.shape[0] * embedding.shape[1]
    states, end = np.empty(embedding.n_nodes, dtype=np.int64), 0
    for place, plane in enumerate(embedding.planes):
        if plane:
            cells = layout.flat_cells(plane)
            states[end : end + len(cells)] = cells + place * n_cells
            end += len(cells)
    return states
