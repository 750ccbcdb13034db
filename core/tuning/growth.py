"""The strongly connected component that holds a given one, when more nodes may be used."""

from collections.abc import Generator

from ..embedding.embedding import Embedding
from ..embedding.network import Nodes
from ..progress import Progress, portion


def component_around_steps(embedding: Embedding, core: Nodes, within: Nodes) -> Generator[Progress, None, Nodes]:
    """The strongly connected component of ``within`` that holds ``core``: a strongly connected subset, not empty.

    The larger ``core`` is, the less there is to search. Never smaller than for less of ``within``. Yields progress.
    """
    network = embedding.network
    reached = yield from portion(network.reached_from_steps(core, within), 0.0, 0.5)
    return (yield from portion(network.reaching_steps(core, reached), 0.5, 1.0))
