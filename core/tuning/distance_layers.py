"""Distances in links from one node and back to it, for every node of an embedding."""

from collections.abc import Callable, Generator

from ..embedding.embedding import Embedding
from ..embedding.network import Nodes, StepNetwork, difference, intersection
from ..progress import Progress


class DistanceLayers:
    """Sets of nodes by their distance from a start: layer 0 is the start itself.

    Distances are kept as binary digits, some set of nodes for each, so that hundreds of layers of a large ground take
    the memory of eight sets.
    """

    def __init__(self):
        self._digits: list[Nodes] = []
        self.n_layers = 0

    def append(self, nodes: Nodes) -> None:
        """The nodes of the next distance, which are in no layer yet."""
        # Counted from 1: no digit at all says that a node is in no layer.
        self.n_layers += 1
        if self.n_layers >> len(self._digits):
            self._digits.append([0] * len(nodes))
        for place, digit in enumerate(self._digits):
            if self.n_layers >> place & 1:
                for index, bundle in enumerate(nodes):
                    if bundle:
                        digit[index] |= bundle

    def layer(self, distance: int) -> Nodes:
        """The nodes at a distance."""
        number = distance + 1
        found: Nodes | None = None
        for place, digit in enumerate(self._digits):
            if number >> place & 1:
                found = digit if found is None else intersection(found, digit)
        assert found is not None
        for place, digit in enumerate(self._digits):
            if not number >> place & 1:
                found = difference(found, intersection(found, digit))
        return found


def layers_from_steps(embedding: Embedding, start: Nodes) -> Generator[Progress, None, DistanceLayers]:
    """Nodes of the embedding by the number of links from ``start``. Yields progress."""
    return _layers_steps(embedding, start, embedding.network.image)


def layers_to_steps(embedding: Embedding, goal: Nodes) -> Generator[Progress, None, DistanceLayers]:
    """Nodes of the embedding by the number of links to ``goal``. Yields progress."""
    return _layers_steps(embedding, goal, embedding.network.preimage)


def _layers_steps(
    embedding: Embedding, start: Nodes, step: Callable[[Nodes], Nodes]
) -> Generator[Progress, None, DistanceLayers]:
    layers, layer = DistanceLayers(), start
    unseen = difference(embedding.nodes, start)
    expected = expected_rounds(embedding.network)
    while any(layer):
        layers.append(layer)
        yield Progress(layers.n_layers / (layers.n_layers + expected), "Measuring distances")
        layer = intersection(step(layer), unseen)
        unseen = difference(unseen, layer)
    return layers


def expected_rounds(network: StepNetwork) -> float:
    """About how many links it takes to cross the ground."""
    layout = network.layout
    return (layout.nx + layout.ny) / max(layout.reach_x, layout.reach_y, 1)
