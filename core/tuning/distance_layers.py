"""Distances in links from one node and back to it, for every node of an embedding."""

from collections.abc import Callable, Generator

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..progress import Progress


class DistanceLayers:
    """Sets of nodes by their distance from a start: layer 0 is the start itself.

    Distances are kept as binary digits, some set of nodes for each, so that hundreds of layers of a large ground take
    the memory of eight sets.
    """

    def __init__(self):
        self._digits: list[list[int]] = []
        self.n_layers = 0

    def append(self, nodes: NodeSet) -> None:
        """The nodes of the next distance, which are in no layer yet."""
        # Counted from 1: no digit at all says that a node is in no layer.
        self.n_layers += 1
        if self.n_layers >> len(self._digits):
            self._digits.append([0] * len(nodes.planes))
        for place, digit in enumerate(self._digits):
            if self.n_layers >> place & 1:
                for index, plane in enumerate(nodes.planes):
                    if plane:
                        digit[index] |= plane

    def layer(self, distance: int) -> NodeSet:
        """The nodes at a distance."""
        number = distance + 1
        digits = [NodeSet(tuple(digit)) for digit in self._digits]
        found = digits[number.bit_length() - 1]
        for place, digit in enumerate(digits):
            found = found & digit if number >> place & 1 else found - digit
        return found


def layers_from_steps(embedding: Embedding, start: NodeSet) -> Generator[Progress, None, DistanceLayers]:
    """Nodes of the embedding by the number of links from ``start``. Yields progress."""
    return _layers_steps(embedding, start, embedding.network.image)


def layers_to_steps(embedding: Embedding, goal: NodeSet) -> Generator[Progress, None, DistanceLayers]:
    """Nodes of the embedding by the number of links to ``goal``. Yields progress."""
    return _layers_steps(embedding, goal, embedding.network.preimage)


def _layers_steps(
    embedding: Embedding, start: NodeSet, step: Callable[[NodeSet], NodeSet]
) -> Generator[Progress, None, DistanceLayers]:
    layers, layer = DistanceLayers(), start
    unseen = embedding.nodes - start
    expected = embedding.network.layout.expected_rounds
    while layer:
        layers.append(layer)
        yield Progress(layers.n_layers / (layers.n_layers + expected), "Measuring distances")
        layer = step(layer) & unseen
        unseen = unseen - layer
    return layers
