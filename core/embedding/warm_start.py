"""Warm starts: an embedding helps to find the next one, in which something stands elsewhere.

Taking links away can only split strongly connected components. A component that is new, or larger than before, holds
a link that was added, with both of its ends: it lies in what can be reached from such links and leads to them again.
Every other is a part of what was the largest component, or no larger than the second.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

from ..progress import Progress, portion
from .closure import reached_from_steps, reaching_steps
from .network import StepNetwork
from .node_set import NodeSet


@dataclass(frozen=True)
class WarmStart:
    """The components of a network as they were before links were added, and others taken away.

    Attributes
    ----------
    nodes : NodeSet
        The nodes of the largest component.
    second_bound : int
        No other component had more nodes.
    starts, ends : NodeSet
        Where the added links start and end.
    """

    nodes: NodeSet
    second_bound: int
    starts: NodeSet
    ends: NodeSet

    def candidates_steps(self, network: StepNetwork, nodes: NodeSet) -> Generator[Progress, None, NodeSet]:
        """Return those of ``nodes`` that may lie in a component of theirs with more than ``second_bound`` nodes: in
        what is left of the largest, or in one that is new. Yields progress."""
        reached = yield from portion(reached_from_steps(network, self.ends & nodes, nodes), 0.0, 0.5)
        new = yield from portion(reaching_steps(network, self.starts & reached, reached), 0.5, 1.0)
        return new | (self.nodes & nodes)


def warm_start(
    network: StepNetwork, before: Sequence[int], after: Sequence[int], nodes: NodeSet, second_bound: int
) -> WarmStart:
    """Return the warm start that ``nodes``, a largest component, give ``network``.

    Parameters
    ----------
    before, after : (K,) sequences of int
        For each stencil the plane of the start cells from which it could be played, and from which it can be now.
    """
    added = [now & ~then for then, now in zip(before, after, strict=True)]
    starts, ends = network.ends_of_links(added)
    return WarmStart(nodes, second_bound, starts, ends)
