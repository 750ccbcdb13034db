"""The embedding written out: every link explicit, every path walked sample by sample, SciPy's strong components.

Slow and obvious on purpose. The fast embedding must agree with it to the last node and link.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from core.embedding.embedding import EmbeddingSettings
from core.embedding.footprint import edit_profile, footprints, rotated_path
from core.environment.environment import Environment
from core.environment.grid import SUBDIVISION, Grid
from core.environment.regions import RegionMask, RegionRule
from core.motion.graph import MotionGraph, MotionSegment


@dataclass
class ExplicitEmbedding:
    """Node indices into (nx, ny, n_headings, n_segments), raveled in C order, and the links between them."""

    shape: tuple
    nodes: np.ndarray
    links: np.ndarray
    all_links: np.ndarray

    def node_mask(self):
        mask = np.zeros(np.prod(self.shape), dtype=bool)
        mask[self.nodes] = True
        return mask.reshape(self.shape)

    def in_degree(self):
        return np.bincount(self.links[:, 1], minlength=np.prod(self.shape)).reshape(self.shape)

    def out_degree(self):
        return np.bincount(self.links[:, 0], minlength=np.prod(self.shape)).reshape(self.shape)


def point_free(environment, tags, sample):
    """Whether a frame with ``tags`` may be played at a sample, given as two integers."""
    x, y = sample
    width, depth = environment.blocked.shape
    if environment.grid.tiled:
        x, y = x % width, y % depth
    elif not (0 <= x < width and 0 <= y < depth):
        return False
    if environment.blocked[x, y]:
        return False
    for region in environment.regions:
        if region.rule is RegionRule.REQUIRE and region.tag not in tags and region.mask[x, y]:
            return False
        if region.rule is RegionRule.FORBID and region.tag in tags and region.mask[x, y]:
            return False
    for tag in tags:
        confining = [r for r in environment.regions if r.rule is RegionRule.CONFINE and r.tag == tag]
        if confining and not any(r.mask[x, y] for r in confining):
            return False
    return True


def samples_of_piece(a, b):
    """The samples that the straight line from a to b (in samples) passes through."""
    cuts = {0.0, 1.0}
    for axis in (0, 1):
        low, high = np.floor(min(a[axis], b[axis])), np.floor(max(a[axis], b[axis]))
        for line in range(int(high - low)):
            # In this order of operations, because paths start on a corner of samples: rounding decides there.
            cuts.add((low - a[axis] + 1 + line) / (b[axis] - a[axis]))
    cuts = sorted(cuts)
    return {
        tuple(int(np.floor(a[axis] + (t0 + t1) / 2 * (b[axis] - a[axis]))) for axis in (0, 1))
        for t0, t1 in pairwise(cuts)
    }


def path_samples(segment, heading, dx, dy, position_error, grid):
    """(tags, sample relative to the start cell) for everything that an edited path passes through."""
    middle = SUBDIVISION / 2
    path = rotated_path(segment, heading * grid.heading_step) + edit_profile(segment)[:, None] * position_error
    points = path / grid.sample_size + middle
    points[-1] = dx * SUBDIVISION + middle, dy * SUBDIVISION + middle
    tags = [frozenset(t for t in segment.tags if segment.tags[t][f]) for f in range(segment.n_frames)]
    found = {(tags[0], tuple(np.floor(points[0]).astype(int).tolist()))}
    found.add((tags[-1], tuple(np.floor(points[-1]).astype(int).tolist())))
    for f in range(segment.n_frames - 1):
        for sample in samples_of_piece(points[f], points[f + 1]):
            found.add((tags[f], sample))
            found.add((tags[f + 1], sample))
    return found


def explicit_embedding(graph: MotionGraph, environment: Environment, settings: EmbeddingSettings):
    grid = environment.grid
    nx, ny, n_headings = grid.shape
    shape = (nx, ny, n_headings, len(graph.segments))
    parents = [graph.links[graph.links[:, 1] == s, 0].tolist() for s in range(len(graph.segments))]
    links = []
    for s, segment in enumerate(graph.segments):
        targets = footprints(segment, grid, settings.footprint)
        for i in range(len(targets.dx)):
            heading, dx, dy, turn = (int(a[i]) for a in (targets.heading, targets.dx, targets.dy, targets.turn))
            way = path_samples(segment, heading, dx, dy, targets.position_error[i], grid)
            for x, y in np.ndindex(nx, ny):
                u, v = x * SUBDIVISION, y * SUBDIVISION
                if all(point_free(environment, tags, (u + du, v + dv)) for tags, (du, dv) in way):
                    end = np.ravel_multi_index(((x + dx) % nx, (y + dy) % ny, (heading + turn) % n_headings, s), shape)
                    for parent in parents[s]:
                        links.append((np.ravel_multi_index((x, y, heading, parent), shape), end))
    links = np.array(links, dtype=np.int64).reshape(-1, 2)
    n = int(np.prod(shape))
    matrix = sparse.csr_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(n, n))
    _, label = connected_components(matrix, directed=True, connection="strong")
    size = np.bincount(label)
    looped = np.zeros(len(size), dtype=bool)
    looped[label[links[links[:, 0] == links[:, 1], 0]]] = True
    size = np.where((size > 1) | looped, size, 0)
    if size.max() == 0:
        nodes = np.empty(0, dtype=np.int64)
    else:
        # argmax of the sizes in order of each node: the first node that lies in a largest component.
        nodes = np.flatnonzero(label == label[np.argmax(size[label])])
    inside = np.zeros(n, dtype=bool)
    inside[nodes] = True
    kept = links[inside[links[:, 0]] & inside[links[:, 1]]]
    return ExplicitEmbedding(shape, nodes, kept, links)


def random_problem(seed, tiled):
    """A small motion graph and environment, with obstacles, regions and tags: (graph, environment)."""
    rng = np.random.default_rng(seed)
    nx, ny = rng.integers(2, 8, 2).tolist()
    n_headings = int(rng.choice([1, 2, 3, 4, 8]))
    cell = float(rng.uniform(0.1, 0.3))
    grid = Grid((nx, ny, n_headings), cell, tuple(rng.uniform(-2, 2, 2).tolist()), tiled)
    n_segments = int(rng.integers(1, 6))
    segments = []
    for s in range(n_segments):
        n_frames = int(rng.integers(2, 8))
        steps = rng.normal(0, 0.4, (n_frames - 1, 2)) * cell + [rng.uniform(0, 0.8) * cell, 0]
        if rng.random() < 0.15:
            steps *= 0.01
        path = np.zeros((n_frames, 3))
        path[1:, :2] = np.cumsum(steps, axis=0)
        path[:, 2] = np.linspace(0, rng.uniform(-np.pi, np.pi), n_frames)
        tags = {t: rng.random(n_frames) < rng.uniform(0, 1) for t in ("step", "jump") if rng.random() < 0.5}
        segments.append(MotionSegment(f"s{s}", 0, 0, n_frames - 1, path, (n_frames - 1) / 30, tags))
    links = np.argwhere(rng.random((n_segments, n_segments)) < rng.uniform(0.2, 0.9))
    if len(links) == 0:
        links = np.array([[0, 0]])
    graph = MotionGraph((), 30.0, tuple(segments), links, np.zeros(len(links)))
    size = (nx * SUBDIVISION, ny * SUBDIVISION)
    blocked = np.kron(rng.random((nx * 2, ny * 2)) < rng.choice([0.0, 0.1, 0.3]), np.ones((2, 2))).astype(bool)
    regions = []
    for rule in RegionRule:
        if rng.random() < 0.4:
            mask = np.zeros(size, dtype=bool)
            x, y = rng.integers(0, size)
            mask[x : x + rng.integers(1, size[0] + 1), y : y + rng.integers(1, size[1] + 1)] = True
            regions.append(RegionMask(rule.name, rule, str(rng.choice(["step", "jump"])), mask))
    return graph, Environment(grid, blocked, tuple(regions))


def slow_floor(graph, environment, covered):
    """(nx, ny) bool: the cells that coverage is a share of, one by one; ``covered`` are those with a node."""
    tags = {
        frozenset(t for t in environment.tags if t in segment.tags and segment.tags[t][frame])
        for segment in graph.segments
        for frame in range(segment.n_frames)
    }
    bare = Environment(environment.grid, environment.blocked)
    floor = np.zeros(environment.grid.shape[:2], dtype=bool)
    for x, y in np.ndindex(floor.shape):
        centre = (4 * x + 2, 4 * y + 2)
        required = any(r.rule is RegionRule.REQUIRE and r.mask[centre] for r in environment.regions)
        ruled = required or not any(point_free(environment, t, centre) for t in tags)
        floor[x, y] = point_free(bare, frozenset(), centre) and (not ruled or covered[x, y])
    return floor
