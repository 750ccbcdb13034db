"""The strongly connected component that holds a given one, when more nodes may be used."""

from collections.abc import Generator

from ..embedding.closure import reached_from_steps, reaching_steps
from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..progress import Progress, portion


def component_around_steps(embedding: Embedding, core: NodeSet, within: NodeSet) -> Generator[Progress, None, NodeSet]:
    """The strongly connected component of ``within`` that holds ``core``: a strongly connected subset, not empty.

    The larger ``core`` is, the less there is to search. Never smaller than for less of ``within``. Yields progress.
    """
    network = embedding.network
    reached = yield from portion(reached_from_steps(network, core, within), 0.0, 0.5)
    return (yield from portion(reaching_steps(network, core, reached), 0.5, 1.0))
