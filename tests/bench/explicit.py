"""The obvious way to embed a motion graph: every link stored, SciPy's strong components on top.

The reference that the bit-planes are measured against. Vectorised over start cells, so that it is as fast as plain
NumPy and SciPy make it.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from core.embedding.embedding import EmbeddingSettings
from core.embedding.stencil import build_stencils
from core.embedding.sweep import swept_samples, tag_classes
from core.environment.environment import Environment
from core.environment.grid import SUBDIVISION
from core.motion.graph import MotionGraph


def embed_explicitly(
    graph: MotionGraph, environment: Environment, settings: EmbeddingSettings | None = None
) -> tuple[int, int]:
    """Nodes and links of the embedding, by writing out all one-step links. Not for tiled grounds."""
    settings = settings or EmbeddingSettings()
    grid = environment.grid
    nx, ny, n_headings = grid.shape
    n_segments = len(graph.segments)
    stencils = build_stencils(graph.segments, grid, settings.footprint)
    classes, frame_classes = tag_classes(graph.segments, environment.tags)
    parents = [graph.links[graph.links[:, 1] == s, 0] for s in range(n_segments)]
    margin = 2 + int(max(np.abs(stencils.dx).max(), np.abs(stencils.dy).max(), _reach(graph, grid)))
    free = [np.pad(environment.free_samples(tags), margin * SUBDIVISION) for tags in classes]
    xs, ys = np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij")
    before, after = [], []
    for s in range(n_segments):
        chosen = np.flatnonzero(stencils.segment == s)
        swept = swept_samples(stencils, chosen, graph.segments, frame_classes, grid)
        rows = np.unique(np.stack([swept.stencil, swept.tag_class, swept.x, swept.y]), axis=1)
        bounds = np.searchsorted(rows[0], np.append(chosen, chosen[-1] + 1))
        for k, low, high in zip(chosen, bounds, bounds[1:], strict=False):
            ok = np.ones((nx, ny), dtype=bool)
            for _, c, u, v in rows[:, low:high].T:
                u, v = u + margin * SUBDIVISION, v + margin * SUBDIVISION
                ok &= free[c][u : u + nx * SUBDIVISION : SUBDIVISION, v : v + ny * SUBDIVISION : SUBDIVISION]
            x, y = xs[ok], ys[ok]
            heading, turned = stencils.heading[k], stencils.destination_heading[k]
            start = ((x * ny + y) * n_headings + heading) * n_segments
            end = (((x + stencils.dx[k]) * ny + y + stencils.dy[k]) * n_headings + turned) * n_segments + s
            before.append((start[None] + parents[s][:, None]).ravel())
            after.append(np.tile(end, len(parents[s])))
    before, after = np.concatenate(before), np.concatenate(after)
    n = nx * ny * n_headings * n_segments
    matrix = sparse.csr_array((np.ones(len(before), dtype=bool), (before, after)), shape=(n, n))
    _, label = connected_components(matrix, directed=True, connection="strong")
    inside = label == np.argmax(np.bincount(label))
    return int(inside.sum()), int(np.count_nonzero(inside[before] & inside[after]))


def _reach(graph: MotionGraph, grid) -> int:
    """Cells by which any path strays from its start."""
    return int(np.ceil(max(np.linalg.norm(s.path[:, :2], axis=1).max() for s in graph.segments) / grid.cell_size)) + 2
