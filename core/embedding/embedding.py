"""The embedding: the motion graph unrolled into the grid and reduced to its largest strongly connected component."""

import os
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from .. import wording
from ..archive import archive_to_bytes, save_archive
from ..environment.environment import Environment
from ..environment.grid import Grid
from ..errors import EmbeddingError
from ..motion.graph import MotionGraph
from ..progress import Progress, finish, portion
from .arrays import EMBEDDING_FORMAT, EmbeddingFields, fields_to_arrays
from .closure import reached_from_steps, reaching_steps
from .component import largest_component_steps
from .network import StepNetwork
from .node_set import NodeSet
from .settings import EmbeddingSettings
from .stencil import build_stencils, fewest_stencils
from .sweep import sweep_steps
from .unroll import Unrolling, unroll_steps
from .warm_start import warm_start


@dataclass(frozen=True)
class Embedding:
    """Nodes (p, c): the character stands at p = (x, y, heading), having arrived by segment c.

    Attributes
    ----------
    graph : MotionGraph
    environment : Environment
    settings : EmbeddingSettings
    unrolling : Unrolling
        All one-step links, inside the component or not.
    planes : tuple of int
        The nodes: for each segment and heading (index segment * n_headings + heading) a bit-plane over the cells.
    second_bound : int or None
        No other strongly connected component has more nodes, of all that was unrolled; None where that is not known,
        as of an embedding that was pruned.
    known_network : StepNetwork or None
        That of ``unrolling``, if it has been made already.
    """

    graph: MotionGraph
    environment: Environment
    settings: EmbeddingSettings
    unrolling: Unrolling
    planes: tuple[int, ...]
    second_bound: int | None = field(default=None, compare=False)
    known_network: StepNetwork | None = field(default=None, compare=False, repr=False)

    @property
    def fields(self) -> EmbeddingFields:
        """Everything that the embedding consists of, in the order in which it is put together."""
        return self.graph, self.environment, self.settings, self.unrolling, self.planes, self.second_bound

    def save(self, path: str | os.PathLike) -> None:
        """Write everything to an .npz file, for :func:`.archive.load_embedding`; EmbeddingError if it fails."""
        save_archive(path, archive_to_bytes(EMBEDDING_FORMAT, *fields_to_arrays(*self.fields)), EMBEDDING_FORMAT)

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """(nx, ny, n_headings, n_segments)"""
        return (*self.environment.grid.shape, len(self.graph.segments))

    @cached_property
    def network(self) -> StepNetwork:
        """The one-step links as moves of planes."""
        return self.known_network or StepNetwork(self.unrolling, self.graph.links, len(self.graph.segments))

    @cached_property
    def nodes(self) -> NodeSet:
        """The nodes as a set of the network."""
        return NodeSet(self.planes)

    @cached_property
    def n_nodes(self) -> int:
        return len(self.nodes)

    @cached_property
    def n_links(self) -> int:
        return self.network.count_links(self.nodes)

    def covered(self) -> np.ndarray:
        """Return (nx, ny, n_headings) bool: True where any segment's node stands at p."""
        nx, ny, n_headings, n_segments = self.shape
        covered = np.empty((nx, ny, n_headings), dtype=bool)
        for heading in range(n_headings):
            shared = 0
            for segment in range(n_segments):
                shared |= self.planes[segment * n_headings + heading]
            covered[:, :, heading] = self.unrolling.layout.unpack(shared)
        return covered

    def able_starts(self) -> Iterator[int]:
        """Yield, for each stencil, the plane of start cells from which it leads to a node of the embedding."""
        layout, stencils = self.unrolling.layout, self.unrolling.stencils
        arrivals = (stencils.segment * stencils.n_headings + stencils.destination_heading).tolist()
        shifts = layout.shift(stencils.dx, stencils.dy).tolist()
        extended = [layout.extend(plane) for plane in self.planes]
        for arrival, shift, valid in zip(arrivals, shifts, self.unrolling.valid, strict=True):
            there = extended[arrival]
            yield valid & (there >> shift if shift >= 0 else there << -shift)

    def node_mask(self) -> np.ndarray:
        """Return (nx, ny, n_headings, n_segments) bool: True where (p, c) is a node of the embedding."""
        return self._by_plane_to_grid(self._mask_by_plane)

    def in_degree(self) -> np.ndarray:
        """Return (nx, ny, n_headings, n_segments) int32: links that end at each node; 0 where there is none."""
        return self._by_plane_to_grid(self._in_degree_by_plane)

    def out_degree(self) -> np.ndarray:
        """Return (nx, ny, n_headings, n_segments) int32: links that start at each node; 0 where there is none."""
        return self._by_plane_to_grid(self._out_degree_by_plane)

    def _by_plane_to_grid(self, by_plane: np.ndarray) -> np.ndarray:
        nx, ny, n_headings, n_segments = self.shape
        return by_plane.reshape(n_segments, n_headings, nx, ny).transpose(2, 3, 1, 0)

    @cached_property
    def _mask_by_plane(self) -> np.ndarray:
        """(planes, nx, ny) bool"""
        unpack = self.unrolling.layout.unpack
        return np.stack([unpack(plane) for plane in self.planes])

    def _over_links(self, matrix: np.ndarray, by_plane: np.ndarray) -> np.ndarray:
        """Return (S, S) ``matrix`` applied to the segments of (planes, nx, ny) counts, for every p at once.

        Counts stay far below 2**24, so that float32 is exact.
        """
        n_segments = len(self.graph.segments)
        product = matrix.astype(np.float32) @ by_plane.reshape(n_segments, -1).astype(np.float32)
        return product.astype(np.int32).reshape(by_plane.shape)

    @cached_property
    def _adjacency(self) -> np.ndarray:
        """(S, S) bool: [a, b] where b may follow a."""
        adjacency = np.zeros((len(self.graph.segments),) * 2, dtype=bool)
        adjacency[self.graph.links[:, 0], self.graph.links[:, 1]] = True
        return adjacency

    @cached_property
    def _in_degree_by_plane(self) -> np.ndarray:
        layout, stencils = self.unrolling.layout, self.unrolling.stencils
        from_parents = self._over_links(self._adjacency.T, self._mask_by_plane)
        degree = np.zeros(from_parents.shape, dtype=np.int32)
        starts, arrivals = self._stencil_planes
        for k, valid in enumerate(self.unrolling.valid):
            if valid:
                moving = from_parents[starts[k]] * layout.unpack(valid)
                _add_shifted(degree[arrivals[k]], moving, stencils.dx[k], stencils.dy[k], layout.tiled)
        return degree * self._mask_by_plane

    @cached_property
    def _out_degree_by_plane(self) -> np.ndarray:
        landing = np.zeros(self._mask_by_plane.shape, dtype=np.int32)
        starts, _ = self._stencil_planes
        for start, able in zip(starts.tolist(), self.able_starts(), strict=True):
            if able:
                landing[start] += self.unrolling.layout.unpack(able)
        return self._over_links(self._adjacency, landing) * self._mask_by_plane

    @property
    def _stencil_planes(self) -> tuple[np.ndarray, np.ndarray]:
        """(K,) plane that each stencil starts from and arrives in."""
        stencils = self.unrolling.stencils
        first = stencils.segment * stencils.n_headings
        return first + stencils.heading, first + stencils.destination_heading

    def to_csr(self) -> tuple[np.ndarray, sparse.csr_array]:
        """Write out all nodes and links, for other programs and for small problems.

        Returns
        -------
        nodes : (N, 4) int array of x, y, heading, segment, in that order
        links : (N, N) sparse array; [i, j] is the duration in seconds of the segment played from node i to node j,
            also where several links join the two
        """
        mask = self.node_mask()
        nodes = np.argwhere(mask)
        number = np.full(mask.shape, -1, dtype=np.int64)
        number[mask] = np.arange(len(nodes))
        stencils, layout = self.unrolling.stencils, self.unrolling.layout
        turned = stencils.destination_heading
        size = np.array(self.shape[:2])
        ends, data = [np.empty((2, 0), dtype=np.int64)], [np.empty(0)]
        for k, valid in enumerate(self.unrolling.valid):
            cells = layout.cells(valid)
            landing = (cells + [stencils.dx[k], stencils.dy[k]]) % size
            segment, heading = stencils.segment[k], stencils.heading[k]
            end = number[landing[:, 0], landing[:, 1], turned[k], segment]
            for parent in self.network.parents[segment]:
                start = number[cells[:, 0], cells[:, 1], heading, parent]
                kept = (start >= 0) & (end >= 0)
                ends.append(np.stack([start[kept], end[kept]]))
                data.append(np.full(np.count_nonzero(kept), self.graph.segments[segment].duration))
        # Two stencils may join the same nodes around a tiled ground, with the same segment: one entry for both.
        pairs, first = np.unique(np.concatenate(ends, axis=1), axis=1, return_index=True)
        return nodes, sparse.csr_array((np.concatenate(data)[first], tuple(pairs)), shape=(len(nodes), len(nodes)))


def _add_shifted(target: np.ndarray, source: np.ndarray, dx: int, dy: int, tiled: bool) -> None:
    """Add ``source`` moved by (dx, dy) cells to ``target``, both (nx, ny); around the edges where tiled.

    Where not tiled, what would leave the ground is zero already.
    """
    if tiled:
        target += np.roll(source, (dx, dy), axis=(0, 1))
        return
    nx, ny = target.shape
    x, y = slice(max(dx, 0), min(nx + dx, nx)), slice(max(dy, 0), min(ny + dy, ny))
    from_x, from_y = slice(max(-dx, 0), min(nx - dx, nx)), slice(max(-dy, 0), min(ny - dy, ny))
    target[x, y] += source[from_x, from_y]


def embed_steps(
    graph: MotionGraph,
    environment: Environment,
    settings: EmbeddingSettings | None = None,
    previous: Embedding | None = None,
) -> Generator[Progress, None, Embedding]:
    """Embed as :func:`embed` does. Yields progress; may be closed at any moment."""
    settings = settings or EmbeddingSettings()
    if not graph.segments:
        raise EmbeddingError("The motion graph has no segments; build it from clips that connect.")
    links = np.asarray(graph.links)
    if links.ndim != 2 or links.shape[1] != 2 or np.any((links < 0) | (links >= len(graph.segments))):
        raise EmbeddingError("The links of the motion graph do not join two of its segments each; build it again.")
    if previous is not None and _same_sweep(previous, graph, environment, settings):
        sweep = previous.unrolling.sweep
    else:
        previous = None
        yield Progress(0.0, "Laying out stencils")
        # Before they are laid out, which alone would take as much if the limits of edits are far too wide.
        fewest = fewest_stencils(graph.segments, environment.grid, settings.footprint)
        _refuse_if_too_large(graph, environment.grid, fewest, settings.memory_limit)
        stencils = build_stencils(graph.segments, environment.grid, settings.footprint)
        _refuse_if_too_large(graph, environment.grid, len(stencils), settings.memory_limit)
        steps = sweep_steps(graph.segments, stencils, environment.grid, environment.tags)
        sweep = yield from portion(steps, 0.0, 0.3)
    unrolling = yield from portion(unroll_steps(sweep, environment), 0.3, 0.5)
    known = None if previous is None else previous.second_bound
    if previous is not None and known is not None and unrolling.valid == previous.unrolling.valid:
        return Embedding(graph, environment, settings, unrolling, previous.planes, known)
    network = StepNetwork(unrolling, graph.links, len(graph.segments))
    if previous is None or known is None:
        before = None
    else:
        valid = previous.unrolling.valid
        before = warm_start(network, valid, unrolling.valid, previous.nodes, known)
    found = yield from portion(largest_component_steps(network, start=before), 0.5, 1.0)
    return Embedding(graph, environment, settings, unrolling, found.nodes.planes, found.second_bound, network)


def embed(
    graph: MotionGraph,
    environment: Environment,
    settings: EmbeddingSettings | None = None,
    previous: Embedding | None = None,
) -> Embedding:
    """Unroll the motion graph into the environment and keep the largest strongly connected component (paper, sect. 3).

    The embedding may be empty (``n_nodes`` 0): then no endless walk fits into the scene.

    Parameters
    ----------
    previous : Embedding, optional
        An embedding of the same graph, made before something in the scene moved. What it shares with the new one is
        not computed again; the result is the same as without it, to the bit.

    Raises
    ------
    EmbeddingError
        The graph has no segments, or the planes would take more than ``settings.memory_limit`` bytes.

    Examples
    --------
    A step of one metre that may follow itself, on a ground of four metres that is joined to its other side:

    >>> from core.motion.graph import MotionSegment
    >>> path = np.linspace([0, 0, 0], [1, 0, 0], 31)
    >>> step = MotionSegment("step", clip=0, first=0, last=30, path=path, duration=1.0, tags={})
    >>> graph = MotionGraph((), 30.0, (step,), links=np.array([[0, 0]]), link_costs=np.zeros(1))
    >>> ground = Environment(Grid((4, 1, 4), 1.0, tiled=True), np.zeros((16, 4), dtype=bool))
    >>> embedding = embed(graph, ground)
    >>> embedding.n_nodes, embedding.n_links, embedding.covered()[:, 0, 0].tolist()
    (4, 4, [True, True, True, True])
    """
    return finish(embed_steps(graph, environment, settings, previous))


def with_nodes(embedding: Embedding, nodes: NodeSet) -> Embedding:
    """Return the embedding with other ``nodes`` of its network, which must be strongly connected (not checked)."""
    return replace(embedding, planes=nodes.planes, second_bound=None, known_network=embedding.network)


def restrict_steps(
    embedding: Embedding, nodes: NodeSet, core: NodeSet | None = None
) -> Generator[Progress, None, Embedding]:
    """Return what is left of an embedding when only these of its nodes may be used: the largest strongly connected
    component. Yields progress.

    The graph, the environment and the one-step links stay the same; whatever prunes an embedding ends here.
    ``core`` may be a strongly connected part of ``nodes``: it makes the search faster, and leaves the result as it is.
    """
    network, nodes = embedding.network, nodes & embedding.nodes
    if core:
        reached = yield from portion(reached_from_steps(network, core, nodes), 0.0, 0.3)
        component = yield from portion(reaching_steps(network, core, reached), 0.3, 0.6)
        # Any other component lies wholly in one of the two rests.
        if len(component) > max(len(reached - component), len(nodes - reached)):
            return with_nodes(embedding, component)
    kept = yield from portion(largest_component_steps(network, within=nodes), 0.6 if core else 0.0, 1.0)
    return with_nodes(embedding, kept.nodes)


def _same_sweep(previous: Embedding, graph: MotionGraph, environment: Environment, settings: EmbeddingSettings) -> bool:
    """Test whether only obstacles and the places of regions can differ from those of ``previous``."""
    return (
        previous.graph is graph
        and previous.environment.grid == environment.grid
        and previous.environment.tags == environment.tags
        and previous.settings == settings
    )


def needed_bytes(graph: MotionGraph, grid: Grid, n_stencils: float) -> float:
    """Estimate the memory that embedding takes at its peak, before it starts: never less, and rarely twice as much.

    One plane for each stencil, and six sets of nodes while the component is sought. Padding is as wide as the longest
    way from a start; Python keeps 30 bits in every 32. A stencil itself takes some 200 bytes while it is laid out and
    swept, which is what counts where footprints are wide and the ground is small.
    """
    nx, ny, n_headings = grid.shape
    reach = int(max(np.abs(s.path[:, :2]).max() for s in graph.segments) * np.sqrt(2) / grid.cell_size) + 2
    bits = (nx + 2 * reach) * (ny + 2 * reach) if grid.tiled else nx * (ny + reach)
    n_planes = n_stencils + 6 * len(graph.segments) * n_headings
    return n_planes * (bits / 8 * 32 / 30 + 40) + 200 * n_stencils


def _refuse_if_too_large(graph: MotionGraph, grid: Grid, n_stencils: float, limit: float) -> None:
    needed = needed_bytes(graph, grid, n_stencils)
    if needed > limit:
        nx, ny, n_headings = grid.shape
        raise EmbeddingError(
            f"The grid of {nx} x {ny} cells and {n_headings} headings would need about {wording.memory(needed)} for "
            f"{len(graph.segments)} segments, more than the limit of {wording.memory(limit)}; use a larger Cell Size, "
            "fewer Headings, a smaller ground or less Position Edit and Heading Edit, or embed it in parcels: "
            "--command wayfarer evaluate --parcels METRES --out FOLDER."
        )
