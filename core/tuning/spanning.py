"""A small spanning subgraph of an embedding: few nodes, strongly connected, that still pass through every place.

From one central node a tree of shortest ways leads to a node at every place, and from each of these a shortest way
leads back, along ways that are in use already where there are any. Whatever holds the subgraph covers all its places:
this is what budgeted pruning builds on.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..evaluation.degrees import Degrees
from ..evaluation.variability import variability_counts, variability_steps
from ..progress import Progress, portion
from .distance_layers import DistanceLayers, layers_from_steps, layers_to_steps
from .local_pruning import best_at_each_place


class Places(Enum):
    """The two kinds of places that can be covered."""

    CELLS = "Cells"
    """A cell (x, y), in any heading."""
    ELEMENTS = "Cells and Headings"
    """A grid element (x, y, heading)."""


def covered_places(embedding: Embedding, places: Places) -> np.ndarray:
    """(nx, ny, n) bool: the places that an embedding covers; n is 1 for cells and n_headings for elements."""
    covered = embedding.covered()
    return covered.any(axis=2, keepdims=True) if places is Places.CELLS else covered


@dataclass(frozen=True)
class SpanningPlan:
    """Distances from which spanning subgraphs of an embedding are made.

    Attributes
    ----------
    embedding : Embedding
    places : Places
    outward, homeward : DistanceLayers
        Nodes by their distance from the central node, and to it.
    depth : (nx, ny, n) int array
        Least distance from the central node to a node at each place; -1 where there is none.
    """

    embedding: Embedding
    places: Places
    outward: DistanceLayers
    homeward: DistanceLayers
    depth: np.ndarray


def plan_spanning_steps(embedding: Embedding, places: Places) -> Generator[Progress, None, SpanningPlan]:
    """Measure an embedding, which must not be empty, from its central node. Yields progress."""
    center = yield from portion(_central_node_steps(embedding), 0.0, 0.1)
    outward = yield from portion(layers_from_steps(embedding, center), 0.1, 0.5)
    homeward = yield from portion(layers_to_steps(embedding, center), 0.5, 0.9)
    layout = embedding.unrolling.layout
    depth = np.full((*embedding.shape[:2], _n_kinds(embedding, places)), -1)
    for distance in range(outward.n_layers):
        yield Progress(0.9 + 0.1 * distance / outward.n_layers, "Measuring distances")
        here = _by_kind(outward.layer(distance).planes, depth.shape[2], embedding)
        for kind, plane in enumerate(here):
            if plane:
                fresh = layout.unpack(plane) & (depth[:, :, kind] < 0)
                depth[:, :, kind][fresh] = distance
    return SpanningPlan(embedding, places, outward, homeward, depth)


def spanning_steps(plan: SpanningPlan, wanted: np.ndarray) -> Generator[Progress, None, NodeSet]:
    """A strongly connected set of few nodes that covers the ``wanted`` places, (nx, ny, n) bool. Yields progress.

    It always holds the central node and a cycle through it, even if that leads to no wanted place.
    """
    embedding, layout = plan.embedding, plan.embedding.unrolling.layout
    n_kinds = wanted.shape[2]
    waiting = [layout.pack(wanted[:, :, kind]) for kind in range(n_kinds)]
    n_rounds = plan.outward.n_layers + plan.homeward.n_layers
    tree = [0] * len(embedding.planes)
    needed = list(tree)
    for distance in range(plan.outward.n_layers - 1, -1, -1):
        yield Progress((plan.outward.n_layers - distance) / n_rounds, "Laying ways")
        layer = plan.outward.layer(distance).planes
        if distance == 0:
            needed = list(layer)
        for kind, plane in enumerate(_by_kind(needed, n_kinds, embedding)):
            waiting[kind] &= ~plane
        # Places that no node nearer to the centre can cover are covered here.
        due = [
            waiting[kind] & layout.pack(plan.depth[:, :, kind] == distance) if waiting[kind] else 0
            for kind in range(n_kinds)
        ]
        if any(due):
            _cover(needed, layer, due, embedding)
            for kind in range(n_kinds):
                waiting[kind] &= ~due[kind]
        _add(tree, needed)
        if distance:
            needed = _sources(embedding, needed, plan.outward.layer(distance - 1).planes)
    kept = list(tree)
    if sum(plane.bit_count() for plane in kept) == 1:
        _add(kept, _step_of_shortest_cycle(plan))
    for distance in range(plan.homeward.n_layers - 1, 0, -1):
        yield Progress(1 - distance / n_rounds, "Laying ways")
        layer = plan.homeward.layer(distance).planes
        nearer = plan.homeward.layer(distance - 1).planes
        _lead_on(embedding, [k & p for k, p in zip(kept, layer, strict=True)], nearer, kept)
    return NodeSet(tuple(kept))


def _step_of_shortest_cycle(plan: SpanningPlan) -> list[int]:
    """Planes of one node that a link leads to from the central one, and from which the way back is shortest."""
    network = plan.embedding.network
    next_nodes = network.image(plan.outward.layer(0))
    for distance in range(plan.homeward.n_layers):
        planes = (next_nodes & plan.homeward.layer(distance)).planes
        for index, plane in enumerate(planes):
            if plane:
                return [plane & -plane if i == index else 0 for i in range(len(planes))]
    raise AssertionError("the node of a strongly connected component lies on a cycle")


def _central_node_steps(embedding: Embedding) -> Generator[Progress, None, NodeSet]:
    """The node of highest segment variability at the place of highest variability: most ways meet there."""
    network = embedding.network
    ways = yield from variability_steps(embedding)
    x, y, heading = (int(i) for i in np.unravel_index(np.argmax(ways), ways.shape))
    packing = network.packing
    block, place = divmod(heading, packing.headings)
    values = variability_counts(embedding, Degrees(embedding), block)
    here = [0] * packing.headings
    here[place] = 1 << int(embedding.unrolling.layout.bit(x, y))
    block_here = packing.pack(here)[0]
    members = [nodes & block_here for nodes in packing.pack(embedding.planes)[block :: packing.n_blocks]]
    best = best_at_each_place(values, members, 1)
    return network.node(next(s for s, plane in enumerate(best) if plane), heading, x, y)


def _n_kinds(embedding: Embedding, places: Places) -> int:
    return 1 if places is Places.CELLS else embedding.shape[2]


def _by_kind(planes: Sequence[int], n_kinds: int, embedding: Embedding) -> list[int]:
    """The places at which planes have a node: one plane, or one for each heading."""
    shared = [0] * n_kinds
    for index, plane in enumerate(planes):
        shared[index % embedding.shape[2] % n_kinds] |= plane
    return shared


def _cover(needed: list[int], layer: Sequence[int], due: list[int], embedding: Embedding) -> None:
    """Add one node of a layer to ``needed`` at each place that is due."""
    left = list(due)
    for index, plane in enumerate(layer):
        kind = index % embedding.shape[2] % len(left)
        taken = plane & left[kind]
        if taken:
            needed[index] |= taken
            left[kind] ^= taken


def _add(planes: list[int], more: Sequence[int]) -> None:
    for index, plane in enumerate(more):
        planes[index] |= plane


def _sources(embedding: Embedding, targets: list[int], candidates: Sequence[int]) -> list[int]:
    """Few of the ``candidates`` (planes), from which links lead to each of the ``targets``."""
    network, layout = embedding.network, embedding.unrolling.layout
    n_headings = network.n_headings
    chosen = [0] * len(candidates)
    for index, plane in enumerate(targets):
        if not plane:
            continue
        segment = index // n_headings
        moves = [(heading, *move) for heading, moves in network.entering[index] for move in moves]
        unserved = plane
        # Those that are chosen for others already serve first.
        for pool in (chosen, candidates):
            for heading, shift, valid in moves:
                if not unserved:
                    break
                there = layout.extend(unserved)
                starts = valid & (there >> shift if shift >= 0 else there << -shift)
                for parent in network.parents[segment]:
                    taken = starts & pool[parent * n_headings + heading]
                    if taken:
                        starts ^= taken
                        chosen[parent * n_headings + heading] |= taken
                        served = layout.fold(taken << shift if shift >= 0 else taken >> -shift)
                        unserved &= ~served
                    if not starts:
                        break
    return chosen


def _lead_on(embedding: Embedding, leaving: list[int], nearer: Sequence[int], kept: list[int]) -> None:
    """Add to ``kept`` few of the ``nearer`` nodes, so that a link leads from each of ``leaving`` to one of them."""
    network, layout = embedding.network, embedding.unrolling.layout
    n_headings = network.n_headings
    for preferred in (True, False):
        for index, leaving_by in enumerate(network.leaving):
            segment, heading = divmod(index, n_headings)
            for turned, shift, valid in ((turned, *move) for turned, moves in leaving_by for move in moves):
                arrival = segment * n_headings + turned
                pool = nearer[arrival] & kept[arrival] if preferred else nearer[arrival]
                if not pool:
                    continue
                there = layout.extend(pool)
                able = valid & (there >> shift if shift >= 0 else there << -shift)
                if not able:
                    continue
                for parent in network.parents[segment]:
                    taken = able & leaving[parent * n_headings + heading]
                    if taken:
                        leaving[parent * n_headings + heading] ^= taken
                        if not preferred:
                            kept[arrival] |= layout.fold(taken << shift if shift >= 0 else taken >> -shift)
