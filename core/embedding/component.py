"""The largest strongly connected component of an unrolled motion graph.

The search is forward-backward on bit-planes (Fleischer, Hendrickson and Pinar 2000), without storing a link: everything
that a pivot reaches, and what of that reaches the pivot, is the pivot's component; every other component lies wholly in
one of the two rests, which are searched only while they hold at least as many nodes as the best component found. With a
well chosen pivot the first component is the largest, and the rests are too small to look at.

Nodes that lie on no cycle would make useless pivots, and large rests: most of them are trimmed away beforehand, pass by
pass over all segments (McLendon, Hendrickson, Plimpton and Rauchwerger 2005).

Where motion is scarce there may be thousands of small components instead, and a pivot for each would take for ever.
A rest with few enough links is therefore written out and left to SciPy, at once if it is small, and otherwise after
some pivots.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..progress import Progress, portion
from .closure import reached_from_steps, reaching_steps
from .network import StepNetwork
from .node_set import NodeSet
from .warm_start import WarmStart

#: A rest with at most this many links is written out: some 100 MB at the most.
EXPLICIT_LINKS = 4_000_000

#: So many pivots are tried before more than a share of these links is written out: a closure is faster than they are.
PATIENT_PIVOTS, AT_ONCE = 3, 1 / 40

#: Nodes are trimmed again while that takes away more than this share of them: of all nodes, and of a rest.
WORTHWHILE_TRIM, WORTHWHILE_TRIM_OF_REST = 0.5, 0.05


@dataclass(frozen=True)
class Component:
    """The largest strongly connected component.

    Attributes
    ----------
    nodes : NodeSet
        Empty if there is no cycle.
    second_bound : int
        No other component has more nodes; there need not be one of this size.
    """

    nodes: NodeSet
    second_bound: int


def largest_component_steps(
    network: StepNetwork,
    explicit_links: int = EXPLICIT_LINKS,
    within: NodeSet | None = None,
    start: WarmStart | None = None,
) -> Generator[Progress, None, Component]:
    """Return the largest strongly connected component. Yields progress.

    Of components of equal size, the one that holds the lowest node in order of x, y, heading, segment. Rests of up to
    ``explicit_links`` links are written out; the result does not depend on it. Only nodes of ``within`` and the links
    between them take part, if it is given. A warm ``start``, of all nodes, makes it quicker where there are many small
    components, and no other.
    """
    everything = network.everything if within is None else within
    best, best_size, second_bound, fraction, n_pivots = network.empty, 0, 0, 0.0, 0
    # Nodes that are still to be searched, and where most of them have a dead end: ahead of them, or behind.
    rests = [_Rest(len(everything), everything, ends_ahead=False)]
    while rests:
        rests.sort(key=lambda rest: rest.size)
        rest = rests.pop()
        if rest.size < max(best_size, 1):
            second_bound = max(second_bound, rest.size)
            break
        worthwhile = WORTHWHILE_TRIM if within is None and n_pivots == 0 else WORTHWHILE_TRIM_OF_REST
        trimming = _trimmed_steps(network, rest, max(best_size, 1), worthwhile)
        nodes = yield from portion(trimming, fraction, fraction)
        if start is not None and start.second_bound < best_size <= len(nodes):
            second_bound = max(second_bound, start.second_bound)
            nodes = yield from portion(start.candidates_steps(network, nodes), fraction, fraction)
        if len(nodes) < max(best_size, 1):
            second_bound = max(second_bound, len(nodes))
            continue
        few = explicit_links if n_pivots >= PATIENT_PIVOTS else int(explicit_links * AT_ONCE)
        if n_pivots > 0 and network.count_links(nodes, few) <= few:
            component, next_size = _largest_written_out(network, nodes)
            second_bound = max(second_bound, next_size)
        else:
            n_pivots += 1
            pivot = _pivot(network, nodes, start)
            # Most of the time this is all there is to do.
            end = fraction + 0.9 * (1 - fraction)
            middle = (fraction + end) / 2
            reached = yield from portion(reached_from_steps(network, pivot, nodes), fraction, middle)
            component = yield from portion(reaching_steps(network, pivot, reached), middle, end)
            fraction = end
            downstream, elsewhere = reached - component, nodes - reached
            rests.append(_Rest(len(downstream), downstream, ends_ahead=True))
            rests.append(_Rest(len(elsewhere), elsewhere, ends_ahead=False))
        size = len(component)
        if _has_cycle(network, component) and (
            size > best_size or (size == best_size and _first_node(network, component) < _first_node(network, best))
        ):
            best, best_size, size = component, size, best_size
        second_bound = max(second_bound, size)
    return Component(best, second_bound)


@dataclass(frozen=True)
class _Rest:
    """Nodes that are still to be searched.

    Attributes
    ----------
    size : int
    nodes : NodeSet
    ends_ahead : bool
        Most of their dead ends lie ahead, where nothing leads on; otherwise behind, where nothing leads to.
    """

    size: int
    nodes: NodeSet
    ends_ahead: bool


def _trimmed_steps(
    network: StepNetwork, rest: _Rest, enough: int, worthwhile: float
) -> Generator[Progress, None, NodeSet]:
    """Trim most of the loose ends of a rest; the work ends when fewer than ``enough`` nodes are left, or when trimming
    all segments once more has taken away no more than a share of ``worthwhile``."""
    nodes, left = rest.nodes, rest.size
    passes = [network.trim_unentered, network.trim_unleft]
    if rest.ends_ahead:
        passes.reverse()
    while True:
        before = left
        for trim in passes:
            yield Progress(0.0, "Trimming dead ends")
            nodes = trim(nodes)
            left = len(nodes)
            if left < enough:
                return nodes
        if left > before * (1 - worthwhile):
            return nodes


def _largest_written_out(network: StepNetwork, nodes: NodeSet) -> tuple[NodeSet, int]:
    """Return the largest component inside ``nodes``, by SciPy on explicit links, and the size of the next.

    Empty if no node lies on a cycle.
    """
    indices, starts, ends = network.links_within(nodes)
    matrix = sparse.csr_array((np.ones(len(starts), dtype=bool), (starts, ends)), shape=(len(indices),) * 2)
    _, label = connected_components(matrix, directed=True, connection="strong")
    size = np.bincount(label)
    looped = np.zeros(len(size), dtype=bool)
    looped[label[starts[starts == ends]]] = True
    size[(size == 1) & ~looped] = 0
    if size.max() == 0:
        return network.empty, 0
    # Of the largest, the one whose first node comes first by place, heading and segment.
    plane, cell = indices.T
    segment, heading = np.divmod(plane, network.n_headings)
    largest = np.flatnonzero(size[label] == size.max())
    first = largest[np.lexsort((segment[largest], heading[largest], cell[largest]))[0]]
    component = network.nodes(indices[label == label[first]])
    size[label[first]] = 0
    return component, int(size.max())


def _pivot(network: StepNetwork, nodes: NodeSet, start: WarmStart | None) -> NodeSet:
    """Choose a single node that is likely to lie in the largest component of ``nodes``.

    Where one was known before, of what is left of it. Of the segment with the most ways in and out: in a heading and on
    a cell that many other segments share, in the middle of all such cells, far from the dead ends along the walls.
    """
    if start is not None:
        nodes = (nodes & start.nodes) or nodes
    n_headings, planes = network.n_headings, nodes.planes
    by_segment = [NodeSet(planes[first : first + n_headings]) for first in range(0, len(planes), n_headings)]
    degree = [len(parents) * len(children) for parents, children in zip(network.parents, network.children, strict=True)]
    order = sorted(
        (segment for segment, own in enumerate(by_segment) if own),
        key=lambda segment: (-degree[segment] * len(by_segment[segment]), segment),
    )
    shared = by_segment[order[0]]
    for segment in order[1:]:
        shared = (shared & by_segment[segment]) or shared
    heading = max(range(n_headings), key=lambda k: shared.planes[k].bit_count())
    cells = network.layout.cells(shared.planes[heading])
    x, y = cells[np.argmin(np.square(cells - cells.mean(axis=0)).sum(axis=1))].tolist()
    return network.node(order[0], heading, x, y)


def _has_cycle(network: StepNetwork, component: NodeSet) -> bool:
    """Test whether a strongly connected set is more than one node that no link joins to itself."""
    return len(component) > 1 or bool(component & network.image(component))


def _first_node(network: StepNetwork, nodes: NodeSet) -> tuple[int, int, int]:
    """Return (bit of the cell, heading, segment) of the lowest node of a set, in order of x, y, heading, segment."""
    return min(
        ((plane & -plane).bit_length(), index % network.n_headings, index // network.n_headings)
        for index, plane in enumerate(nodes.planes)
        if plane
    )
