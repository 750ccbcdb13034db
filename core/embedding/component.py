"""The largest strongly connected component of an unrolled motion graph.

The search is forward-backward on bit-planes, without storing a link: everything that a pivot reaches, and what of that
reaches the pivot, is the pivot's component; every other component lies wholly in one of the two rests, which are
searched only while they hold at least as many nodes as the best component found. With a well chosen pivot the first
component is the largest, and the rests are too small to look at.

Nodes that lie on no cycle would make useless pivots, and large rests: most of them are trimmed away beforehand, pass by
pass over all segments.

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
from .network import Nodes, StepNetwork, count, difference, intersection
from .plane_network import PlaneNetwork, Planes
from .precedent import Precedent

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
    nodes : Planes
        All 0 if there is no cycle.
    runner_up : int
        No other component has more nodes; there need not be one of this size.
    """

    nodes: Planes
    runner_up: int


def largest_component_steps(
    network: StepNetwork, explicit_links: int = EXPLICIT_LINKS, within: Nodes | None = None
) -> Generator[Progress, None, Nodes]:
    """The nodes of the largest strongly connected component; yields progress, returns bundles (all 0 if no cycle).

    Of components of equal size, the one that holds the lowest node in order of x, y, heading, segment. Rests of up to
    ``explicit_links`` links are written out; the result does not depend on it. Only nodes of ``within`` and the links
    between them take part, if it is given.
    """
    planes = None if within is None else network.all_planes(within)
    found = yield from component_steps(network.by_plane, explicit_links, planes)
    return network.bundles(found.nodes)


def component_steps(
    network: PlaneNetwork,
    explicit_links: int = EXPLICIT_LINKS,
    within: Planes | None = None,
    precedent: Precedent | None = None,
) -> Generator[Progress, None, Component]:
    """As :func:`largest_component_steps`, for sets of nodes that are kept in single planes.

    A ``precedent``, of all nodes, makes it quicker where there are many small components, and no other.
    """
    everything = network.everything() if within is None else within
    best, best_size, runner_up, fraction, n_pivots = [0] * len(everything), 0, 0, 0.0, 0
    # Nodes that are still to be searched, and where most of them have a dead end: ahead of them, or behind.
    rests = [_Rest(count(everything), everything, ends_ahead=False)]
    while rests:
        rests.sort(key=lambda rest: rest.size)
        rest = rests.pop()
        if rest.size < max(best_size, 1):
            runner_up = max(runner_up, rest.size)
            break
        worthwhile = WORTHWHILE_TRIM if within is None and n_pivots == 0 else WORTHWHILE_TRIM_OF_REST
        trimming = _trimmed_steps(network, rest, max(best_size, 1), worthwhile)
        nodes = yield from portion(trimming, fraction, fraction)
        if precedent is not None and precedent.runner_up < best_size <= count(nodes):
            runner_up = max(runner_up, precedent.runner_up)
            nodes = yield from portion(precedent.candidates_steps(network, nodes), fraction, fraction)
        if count(nodes) < max(best_size, 1):
            runner_up = max(runner_up, count(nodes))
            continue
        few = explicit_links if n_pivots >= PATIENT_PIVOTS else int(explicit_links * AT_ONCE)
        if n_pivots > 0 and network.count_links(nodes, few) <= few:
            component, next_size = _largest_written_out(network, nodes)
            runner_up = max(runner_up, next_size)
        else:
            n_pivots += 1
            pivot = _pivot(network, nodes, precedent)
            # Most of the time this is all there is to do.
            end = fraction + 0.9 * (1 - fraction)
            middle = (fraction + end) / 2
            reached = yield from portion(reached_from_steps(network, pivot, nodes), fraction, middle)
            component = yield from portion(reaching_steps(network, pivot, reached), middle, end)
            fraction = end
            downstream, elsewhere = difference(reached, component), difference(nodes, reached)
            rests.append(_Rest(count(downstream), downstream, ends_ahead=True))
            rests.append(_Rest(count(elsewhere), elsewhere, ends_ahead=False))
        size = count(component)
        if _has_cycle(network, component) and (
            size > best_size or (size == best_size and _first_node(network, component) < _first_node(network, best))
        ):
            best, best_size, size = component, size, best_size
        runner_up = max(runner_up, size)
    return Component(best, runner_up)


@dataclass(frozen=True)
class _Rest:
    """Nodes that are still to be searched.

    Attributes
    ----------
    size : int
    nodes : Planes
    ends_ahead : bool
        Whether most of their dead ends lie ahead, where nothing leads on, or behind, where nothing leads to.
    """

    size: int
    nodes: Planes
    ends_ahead: bool


def _trimmed_steps(
    network: PlaneNetwork, rest: _Rest, enough: int, worthwhile: float
) -> Generator[Progress, None, Planes]:
    """A rest without most of its loose ends; the work ends when fewer than ``enough`` nodes are left, or when trimming
    all segments once more has taken away no more than a share of ``worthwhile``."""
    nodes, left = rest.nodes, rest.size
    passes = (network.leading_on, network.led_to) if rest.ends_ahead else (network.led_to, network.leading_on)
    while True:
        before = left
        for trim in passes:
            yield Progress(0.0, "Trimming dead ends")
            nodes = trim(nodes)
            left = count(nodes)
            if left < enough:
                return nodes
        if left > before * (1 - worthwhile):
            return nodes


def _largest_written_out(network: PlaneNetwork, nodes: Planes) -> tuple[Planes, int]:
    """The largest component inside ``nodes``, by SciPy on explicit links, and the size of the next.

    All 0 if no node lies on a cycle.
    """
    indices, starts, ends = network.links_within(nodes)
    matrix = sparse.csr_array((np.ones(len(starts), dtype=bool), (starts, ends)), shape=(len(indices),) * 2)
    _, label = connected_components(matrix, directed=True, connection="strong")
    size = np.bincount(label)
    looped = np.zeros(len(size), dtype=bool)
    looped[label[starts[starts == ends]]] = True
    size[(size == 1) & ~looped] = 0
    if size.max() == 0:
        return [0] * len(nodes), 0
    # Of the largest, the one whose first node comes first by place, heading and segment.
    plane, cell = indices.T
    segment, heading = np.divmod(plane, network.n_headings)
    largest = np.flatnonzero(size[label] == size.max())
    first = largest[np.lexsort((segment[largest], heading[largest], cell[largest]))[0]]
    component = network.nodes(indices[label == label[first]])
    size[label[first]] = 0
    return component, int(size.max())


def _pivot(network: PlaneNetwork, nodes: Planes, precedent: Precedent | None) -> Planes:
    """A single node that is likely to lie in the largest component of ``nodes``.

    Where one was known before, of what is left of it. Of the segment with the most ways in and out: in a heading and on
    a cell that many other segments share, in the middle of all such cells, far from the dead ends along the walls.
    """
    if precedent is not None:
        left = intersection(nodes, precedent.nodes)
        nodes = left if any(left) else nodes
    n_headings = network.n_headings
    by_segment = [nodes[first : first + n_headings] for first in range(0, len(nodes), n_headings)]
    degree = [len(parents) * len(children) for parents, children in zip(network.parents, network.children, strict=True)]
    order = sorted(
        (segment for segment, planes in enumerate(by_segment) if any(planes)),
        key=lambda segment: (-degree[segment] * count(by_segment[segment]), segment),
    )
    shared = by_segment[order[0]]
    for segment in order[1:]:
        both = intersection(shared, by_segment[segment])
        shared = both if any(both) else shared
    heading = max(range(n_headings), key=lambda k: shared[k].bit_count())
    cells = network.layout.cells(shared[heading])
    x, y = cells[np.argmin(np.square(cells - cells.mean(axis=0)).sum(axis=1))].tolist()
    return network.nodes(np.array([[order[0] * n_headings + heading, x * network.layout.ny + y]]))


def _has_cycle(network: PlaneNetwork, component: Planes) -> bool:
    """Whether a strongly connected set is more than one node that no link joins to itself."""
    return count(component) > 1 or any(intersection(component, network.image(component)))


def _first_node(network: PlaneNetwork, nodes: Planes) -> tuple[int, int, int]:
    """(bit of the cell, heading, segment) of the lowest node of a set, in order of x, y, heading, segment."""
    return min(
        ((plane & -plane).bit_length(), index % network.n_headings, index // network.n_headings)
        for index, plane in enumerate(nodes)
        if plane
    )
