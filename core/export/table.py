"""An embedding as a plain table of nodes and links, for engines that would rather look links up than shift bits.

Little-endian numbers without a header, for n nodes and L links: (n, 4) uint16 x, y, heading and segment of each node;
(n + 1,) uint32 where each node's links begin, and the last ones end; (L,) uint32 the node that each link leads to. That
is what :func:`core.tuning.budget.table_bytes` counts, to the byte. Nodes are in order of segment, heading, x and y, the
links of a node in order of the stencils that they play.
"""

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader
from ..errors import ExportError
from ..tuning.budget import table_bytes

#: Nodes whose links are looked up together.
_NODES_AT_ONCE = 50_000

#: Links and nodes are numbered by 32 bits, parts of a node by 16.
_MOST, _MOST_PARTS = 2**32 - 1, 2**16


def engine_table(embedding: Embedding) -> bytes:
    """The table; ExportError if its numbers do not fit, or it would take too much memory."""
    nx, ny, n_headings, _ = embedding.shape
    size = table_bytes(embedding.n_nodes, embedding.n_links)
    if size > _MOST or max(embedding.shape) > _MOST_PARTS:
        raise ExportError(
            f"A table of {embedding.n_nodes:,} nodes and {embedding.n_links:,} links would take {size / 1e9:.1f} GB; "
            "prune the embedding, or leave the table out: the planes hold the same."
        )
    unpack = embedding.unrolling.layout.unpack
    # Numbers of all states that are nodes, ascending.
    states = [np.flatnonzero(unpack(plane)) + place * nx * ny for place, plane in enumerate(embedding.planes) if plane]
    state = np.concatenate([np.empty(0, dtype=np.int64), *states])
    place, cell = np.divmod(state, nx * ny)
    nodes = np.column_stack([*np.divmod(cell, ny), place % n_headings, place // n_headings])
    reader = LinkReader(embedding)
    counts, ends = np.zeros(len(nodes) + 1, dtype=np.int64), []
    for first in range(0, len(nodes), _NODES_AT_ONCE):
        some = nodes[first : first + _NODES_AT_ONCE]
        row, stencil = reader.links_from(some)
        counts[first + 1 : first + 1 + len(some)] = np.bincount(row, minlength=len(some))
        x, y, heading, segment = reader.wrapped(reader.ends(some[row], stencil)).T
        there = ((segment * n_headings + heading) * nx + x) * ny + y
        ends.append(np.searchsorted(state, there).astype("<u4"))
    parts = [nodes.astype("<u2"), np.cumsum(counts).astype("<u4"), *ends]
    return b"".join(part.tobytes() for part in parts)
