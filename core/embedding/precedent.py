"""What an embedding tells of the next one, in which something stands elsewhere.

Taking links away can only split strongly connected components. A component that is new, or larger than before, holds
a link that was added, with both of its ends: it lies in what can be reached from such links and leads to them again.
Every other is a part of what was the largest component, or no larger than the second.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass

from ..progress import Progress, portion
from .closure import reached_from_steps, reaching_steps
from .network import intersection, union
from .plane_network import PlaneNetwork, Planes


@dataclass(frozen=True)
class Precedent:
    """The components of a network as they were before links were added, and others taken away.

    Attributes
    ----------
    nodes : Planes
        The nodes of the largest component.
    runner_up : int
        No other component had more nodes.
    starts, ends : Planes
        Where the added links start and end.
    """

    nodes: Planes
    runner_up: int
    starts: Planes
    ends: Planes

    def candidates_steps(self, network: PlaneNetwork, nodes: Planes) -> Generator[Progress, None, Planes]:
        """Those of ``nodes`` that may lie in a component of theirs with more than ``runner_up`` nodes: in what is left
        of the largest, or in one that is new. Yields progress."""
        ends = intersection(self.ends, nodes)
        reached = yield from portion(reached_from_steps(network, ends, nodes), 0.0, 0.5)
        starts = intersection(self.starts, reached)
        new = yield from portion(reaching_steps(network, starts, reached), 0.5, 1.0)
        return union(new, intersection(self.nodes, nodes))


def precedent(
    network: PlaneNetwork, before: Sequence[int], after: Sequence[int], nodes: Planes, runner_up: int
) -> Precedent:
    """The precedent that ``nodes``, a largest component, set for ``network``.

    Parameters
    ----------
    before, after : (K,) sequences of int
        For each stencil the plane of the start cells from which it could be played, and from which it can be now.
    """
    added = [now & ~then for then, now in zip(before, after, strict=True)]
    starts, ends = network.ends_of_links(added)
    return Precedent(nodes, runner_up, starts, ends)
