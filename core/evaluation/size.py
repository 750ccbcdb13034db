"""The size of an embedding: the numbers that two embeddings of one scene are compared by."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..errors import EvaluationError
from ..progress import finish
from .floor import floor_cells
from .reach import time_to_reach_steps


@dataclass(frozen=True)
class Objective:
    """A number of an embedding that is worth watching, such as the mean time to reach the door.

    Attributes
    ----------
    name : str
        As it stands in a sentence: "mean time to reach the door".
    unit : str
    of : callable
        The number of an embedding. Lower is better; infinite where the embedding does not allow it at all.
    """

    name: str
    unit: str
    of: Callable[[Embedding], float]


@dataclass(frozen=True)
class EmbeddingSize:
    """The size of an embedding.

    Attributes
    ----------
    floor : float
        Square metres of the cells that it covers in at least one heading.
    share : float
        The same as a share of the free floor (:func:`.floor.floor_cells`), 0 to 1.
    places : int
        Grid elements (x, y, heading) that it covers.
    nodes, links : int
    objective : float or None
        Of the objective that was asked for.
    """

    floor: float
    share: float
    places: int
    nodes: int
    links: int
    objective: float | None = None


def mean_time_to(goal: NodeSet, place: str) -> Objective:
    """The mean time from everywhere to a set of nodes (see :mod:`.goals`); infinite for embeddings without any of them.

    For embeddings that share one network: an embedding and what pruning or ablation leave of it. ``place`` is what the
    goal is called: "the door". The objective raises EvaluationError where the network is another one.
    """

    def seconds(embedding: Embedding) -> float:
        if len(goal.planes) != len(embedding.planes):
            raise EvaluationError(f"The time to reach {place} cannot be compared: other motions have other nodes.")
        if not goal & embedding.nodes:
            return float("inf")
        counts = finish(time_to_reach_steps(embedding, goal)).histogram()
        return float(counts @ np.arange(len(counts))) / counts.sum() / embedding.graph.frame_rate

    return Objective(f"mean time to reach {place}", "s", seconds)


def embedding_size(embedding: Embedding, objective: Objective | None = None) -> EmbeddingSize:
    """Return floor, places, nodes and links of an embedding, and an objective if one is given."""
    covered = embedding.covered()
    n_cells = int(np.count_nonzero(covered.any(axis=2)))
    n_free = int(np.count_nonzero(floor_cells(embedding)))
    return EmbeddingSize(
        floor=n_cells * embedding.environment.grid.cell_size**2,
        share=n_cells / max(n_free, 1),
        places=int(np.count_nonzero(covered)),
        nodes=embedding.n_nodes,
        links=embedding.n_links,
        objective=None if objective is None else float(objective.of(embedding)),
    )
