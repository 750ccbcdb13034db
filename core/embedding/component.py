"""The largest strongly connected component of an unrolled motion graph, without storing a link.

The search is forward-backward: everything that a pivot reaches, and what of that reaches the pivot, is the pivot's
component; every other component lies wholly in one of the two rests, which are searched only while they hold at
least as many nodes as the best component found. With a well chosen pivot the first component is the largest, and
the rests are too small to look at.
"""

from collections.abc import Generator

import numpy as np

from ..progress import Progress
from .network import Nodes, StepNetwork, count, difference, intersection


def largest_component_steps(network: StepNetwork) -> Generator[Progress, None, Nodes]:
    """The nodes of the largest strongly connected component; yields progress, returns bundles (all 0 if no cycle).

    Of components of equal size, the one that holds the lowest node in order of x, y, heading, segment.
    """
    everything = network.image(network.everything())
    best, best_size = [0] * len(everything), 0
    total = count(everything)
    rests = [(total, everything)]
    while rests:
        rests.sort(key=lambda rest: rest[0])
        left, nodes = rests.pop()
        if left < max(best_size, 1):
            break
        if best_size:
            # Most of a rest is usually loose ends: cut them off before looking closer.
            nodes = network.trim(nodes)
            if count(nodes) < max(best_size, 1):
                continue
            if count(nodes) < left:
                rests.append((count(nodes), nodes))
                continue
        yield Progress(1 - left / total, "Finding the largest strongly connected component")
        pivot = _pivot(network, nodes)
        reached = network.reached_from(pivot, nodes)
        yield Progress(1 - left / total / 2, "Finding the largest strongly connected component")
        component = network.reaching(pivot, reached)
        size = count(component)
        if _has_cycle(network, component) and (
            size > best_size or (size == best_size and _first_node(network, component) < _first_node(network, best))
        ):
            best, best_size = component, size
        for rest in (difference(reached, component), difference(nodes, reached)):
            rests.append((count(rest), rest))
    return best


def _pivot(network: StepNetwork, nodes: Nodes) -> Nodes:
    """A single node that is likely to lie in the largest component of ``nodes``.

    Of the segment with the most ways in and out: in a heading and on a cell that many other segments share, in the
    middle of all such cells, far from the dead ends along the walls.
    """
    n_blocks = network.n_blocks
    degree = [len(parents) * len(children) for parents, children in zip(network.parents, network.children, strict=True)]
    order = sorted(
        (index for index, bundle in enumerate(nodes) if bundle),
        key=lambda index: (-degree[index // n_blocks] * nodes[index].bit_count(), index),
    )
    segment, block = divmod(order[0], n_blocks)
    shared = nodes[order[0]]
    for index in order[1:]:
        if index % n_blocks == block:
            shared = (shared & nodes[index]) or shared
    planes = network.planes(shared)
    place = max(range(len(planes)), key=lambda k: planes[k].bit_count())
    cells = network.layout.cells(planes[place])
    x, y = cells[np.argmin(np.square(cells - cells.mean(axis=0)).sum(axis=1))].tolist()
    return network.node(segment, block * network.bundled + place, x, y)


def _has_cycle(network: StepNetwork, component: Nodes) -> bool:
    """Whether a strongly connected set is more than one node that no link joins to itself."""
    return count(component) > 1 or any(intersection(component, network.image(component)))


def _first_node(network: StepNetwork, nodes: Nodes) -> tuple[int, int, int]:
    """(bit of the cell, heading, segment) of the lowest node of a set, in order of x, y, heading, segment."""
    bundled, n_blocks = network.bundled, network.n_blocks
    return min(
        ((plane & -plane).bit_length(), index % n_blocks * bundled + place, index // n_blocks)
        for index, bundle in enumerate(nodes)
        if bundle
        for place, plane in enumerate(network.planes(bundle))
        if plane
    )
