"""Trials: what becomes of an embedding when one more segment joins its motion graph, without embedding again.

The old embedding stays strongly connected, so that all closures start from it: forwards from everything that it
already reached, backwards from everything that already led to it. What differs from one trial to the next is one
segment: only its stencils are checked, and only what it adds is followed. The result is that of embedding the larger
graph, to the bit.
"""

from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np

from ...embedding.closure import reached_from_steps, reaching_steps
from ...embedding.component import largest_component_steps
from ...embedding.embedding import Embedding
from ...embedding.network import StepNetwork
from ...embedding.node_set import NodeSet
from ...embedding.stencil import build_stencils
from ...embedding.sweep import Sweep, sweep_steps
from ...embedding.unroll import Unrolling, unroll_steps
from ...errors import EmbeddingError
from ...progress import Progress, portion
from .candidate import Candidate, augmented


class Trials:
    """An embedding that is ready to try candidates; :func:`trials_steps` prepares it.

    Attributes
    ----------
    embedding : Embedding
        The embedding with planes that have room for the paths of all candidates.
    """

    def __init__(self, embedding: Embedding, sweep: Sweep, reached: NodeSet, leading: NodeSet, apart: int):
        self.embedding = embedding
        self._sweep = sweep
        self._reached = reached
        self._leading = leading
        self._apart = apart

    def try_steps(self, candidate: Candidate, index: int) -> Generator[Progress, None, Embedding]:
        """Embed the motion graph with a candidate, the ``index``-th of those that the trials were prepared for."""
        old = self.embedding
        n_segments = len(old.graph.segments)
        alone = chosen_segments(self._sweep, [n_segments + index])
        unrolled = yield from portion(unroll_steps(alone, old.environment), 0.0, 0.1)
        sweep = chosen_segments(self._sweep, [*range(n_segments), n_segments + index])
        unrolling = Unrolling(sweep, old.unrolling.valid + unrolled.valid)
        graph = augmented(old.graph, candidate)
        network = StepNetwork(unrolling, graph.links, n_segments + 1)
        nodes = yield from portion(self._component_steps(network), 0.1, 1.0)
        return Embedding(graph, old.environment, old.settings, unrolling, nodes.planes, known_network=network)

    def _component_steps(self, network: StepNetwork) -> Generator[Progress, None, NodeSet]:
        """The largest component of a network with one segment more."""
        if not self._reached:
            return (yield from largest_component_steps(network)).nodes
        none = (0,) * network.n_headings
        everything = network.everything
        steps = reached_from_steps(network, NodeSet(self._reached.planes + none), everything)
        reached = yield from portion(steps, 0.0, 0.4)
        seed = NodeSet(self._leading.planes + none) & reached
        component = yield from portion(reaching_steps(network, seed, reached), 0.4, 0.8)
        # A component apart from this one holds nodes of the new segment, or the old embedding would be smaller. It lies
        # wholly in what is reached, or wholly outside.
        downstream = reached - component
        new = self._arrivals_of_last(network)
        size = len(component)
        elsewhere = everything - reached
        larger = False
        if len(downstream) >= size:
            larger = yield from portion(_may_hold(network, new, downstream, size), 0.8, 0.85)
        if not larger and self._apart + len(new) >= size:
            larger = yield from portion(_may_hold(network, new, elsewhere, size), 0.85, 0.9)
        if larger:
            return (yield from portion(largest_component_steps(network), 0.9, 1.0)).nodes
        return component

    @staticmethod
    def _arrivals_of_last(network: StepNetwork) -> NodeSet:
        """Every node of the last segment that has any link to it, wherever that comes from."""
        arrived = network.arrivals(network.n_segments - 1, [network.layout.ground] * network.n_headings)
        return NodeSet((0,) * ((network.n_segments - 1) * network.n_headings) + tuple(arrived))


def _may_hold(network: StepNetwork, new: NodeSet, within: NodeSet, size: int) -> Generator[Progress, None, bool]:
    """Return False if no strongly connected set of at least ``size`` with a node of ``new`` can lie in ``within``."""
    new = new & within
    reached = yield from portion(reached_from_steps(network, new, within), 0.0, 0.5)
    around = yield from portion(reaching_steps(network, new, reached), 0.5, 1.0)
    return len(around) >= size


def trials_steps(embedding: Embedding, candidates: Sequence[Candidate]) -> Generator[Progress, None, Trials]:
    """Prepare an embedding for trials of some candidates; yields progress, returns a :class:`Trials`.

    Raises
    ------
    EmbeddingError
        The embedding was pruned: it is not the largest component of its motion graph in its environment.
    """
    graph, environment, grid = embedding.graph, embedding.environment, embedding.environment.grid
    segments = [*graph.segments, *(candidate.segment for candidate in candidates)]
    stencils = build_stencils(segments, grid, embedding.settings.footprint)
    sweep = yield from portion(sweep_steps(segments, stencils, grid, environment.tags), 0.0, 0.4)
    own = chosen_segments(sweep, range(len(graph.segments)))
    unrolling = yield from portion(unroll_steps(own, environment), 0.4, 0.6)
    network = StepNetwork(unrolling, graph.links, len(graph.segments))
    before, after = embedding.unrolling.layout, unrolling.layout
    planes = tuple(after.pack(before.unpack(plane)) if plane else 0 for plane in embedding.planes)
    wider = Embedding(graph, environment, embedding.settings, unrolling, planes, known_network=network)
    everything = network.everything
    reached = yield from portion(reached_from_steps(network, wider.nodes, everything), 0.6, 0.8)
    leading = yield from portion(reaching_steps(network, wider.nodes, everything), 0.8, 1.0)
    if len(reached & leading) != wider.n_nodes:
        raise EmbeddingError(
            "This embedding was pruned; embed the motion graph again before asking which motion is missing."
        )
    alive = network.image(everything)
    apart = len(alive - reached)
    return Trials(wider, sweep, reached, leading, apart)


def chosen_segments(sweep: Sweep, segments: Sequence[int]) -> Sweep:
    """Return the sweep of some segments only, in the order given and numbered anew; the layout stays."""
    stencils, bounds = sweep.stencils, np.array(sweep.bounds)
    rows = [np.flatnonzero(stencils.segment == segment) for segment in segments]
    numbers = np.repeat(np.arange(len(rows)), [len(of_segment) for of_segment in rows])
    kept = np.concatenate(rows)
    # Stencils that share a path follow one another.
    path = np.array(sweep.path, dtype=int)[kept]
    new = np.diff(path, prepend=-1) != 0
    n_checks = np.diff(bounds)[path[new]]
    ends = np.cumsum(n_checks)
    checks = (np.repeat(bounds[path[new]] - (ends - n_checks), n_checks) + np.arange(n_checks.sum())).tolist()
    arrays = ("heading", "dx", "dy", "turn", "position_error", "heading_error")
    return replace(
        sweep,
        stencils=replace(stencils, segment=numbers, **{name: getattr(stencils, name)[kept] for name in arrays}),
        path=(np.cumsum(new) - 1).tolist(),
        bounds=[0, *ends.tolist()],
        tag_class=[sweep.tag_class[check] for check in checks],
        part=[sweep.part[check] for check in checks],
        shift=[sweep.shift[check] for check in checks],
    )
