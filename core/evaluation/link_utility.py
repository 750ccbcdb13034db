"""Utility of the motion graph's links and segments: how much of the embedding hangs on each.

Counted, not tried: what stands or falls at once. A node *hangs* on a link of the motion graph where all links of the
embedding that lead to it, or all that lead from it, play that one transition: without it the node is dead. What dies
next because of that is left to ablation (:mod:`.ablation`), which is exact and takes longer.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.network import Nodes, StepNetwork


@dataclass(frozen=True)
class LinkUtility:
    """What hangs on each link and segment of a motion graph.

    Attributes
    ----------
    names : tuple of str
        Of the segments.
    links : (L, 2) int array
        The motion graph's links.
    link_uses : (L,) int array
        Links of the embedding that play this transition.
    link_dependents : (L,) int array
        Nodes that are dead without it.
    segment_uses : (S,) int array
        Links of the embedding that play this segment.
    segment_dependents : (S,) int array
        Nodes that are dead without it: its own, and those that can only be entered from it or left by it.
    n_nodes, n_links : int
        Of the embedding.
    """

    names: tuple[str, ...]
    links: np.ndarray
    link_uses: np.ndarray
    link_dependents: np.ndarray
    segment_uses: np.ndarray
    segment_dependents: np.ndarray
    n_nodes: int
    n_links: int

    @property
    def idle_links(self) -> np.ndarray:
        """(n,) indices of the links that the embedding never plays."""
        return np.flatnonzero(self.link_uses == 0)

    def link_name(self, link: int) -> str:
        a, b = self.links[link]
        return f"'{self.names[a]}' to '{self.names[b]}'"

    def describe(self) -> str:
        if not self.n_links:
            return "There are no links, so nothing hangs on any of them."
        most, vital = int(np.argmax(self.link_uses)), int(np.argmax(self.link_dependents))
        spare = np.count_nonzero(self.link_dependents == 0)
        return (
            f"Of {wording.counted(len(self.links), 'link')} of the motion graph {wording.number(len(self.idle_links))} "
            f"are never played and {wording.number(spare)} can go without a node that dies at once. The most played "
            f"leads from {self.link_name(most)} ({wording.share_of(self.link_uses[most], self.n_links)} of all links "
            f"of the embedding); most hangs on the one from {self.link_name(vital)}: "
            f"{wording.counted(int(self.link_dependents[vital]), 'node')} "
            f"({wording.share_of(self.link_dependents[vital], self.n_nodes)})."
        )


def link_utility(embedding: Embedding) -> LinkUtility:
    """Uses of every link and segment of the motion graph in an embedding, and the nodes that hang on each."""
    network, nodes, n_blocks = embedding.network, embedding.nodes, embedding.network.n_blocks
    n_segments = network.n_segments
    uses = _uses(network, nodes)
    # [a, b]: the nodes of a whose links all lead to b, and the nodes of b whose links all come from a.
    leaving_by: dict[tuple[int, int], Nodes] = {}
    entered_from: dict[tuple[int, int], Nodes] = {}
    playable = {}
    for b in range(n_segments):
        ends = nodes[b * n_blocks : (b + 1) * n_blocks]
        playable[b] = _joined(network.playable(b, block, ends[block]) for block in range(n_blocks))
    for b in range(n_segments):
        ends = nodes[b * n_blocks : (b + 1) * n_blocks]
        arrivals = {}
        for a in network.parents[b]:
            starts = nodes[a * n_blocks : (a + 1) * n_blocks]
            arrived = _joined(network.arrivals(b, block, starts[block]) for block in range(n_blocks))
            arrivals[a] = [x & y for x, y in zip(arrived, ends, strict=True)]
        for a, only in _alone(arrivals).items():
            entered_from[a, b] = only
    for a in range(n_segments):
        starts = nodes[a * n_blocks : (a + 1) * n_blocks]
        left = {b: [x & y for x, y in zip(playable[b], starts, strict=True)] for b in network.children[a]}
        for b, only in _alone(left).items():
            leaving_by[a, b] = only

    links = np.asarray(embedding.graph.links)
    link_dependents = [
        _count(_joined([leaving_by[a, a], entered_from[a, a]]))
        if a == b
        else _count(leaving_by[a, b]) + _count(entered_from[a, b])
        for a, b in links.tolist()
    ]
    segment_dependents = []
    for c in range(n_segments):
        hanging = {c: [nodes[c * n_blocks : (c + 1) * n_blocks]]}
        for a in network.parents[c]:
            hanging.setdefault(a, []).append(leaving_by[a, c])
        for b in network.children[c]:
            hanging.setdefault(b, []).append(entered_from[c, b])
        segment_dependents.append(sum(_count(_joined(sets)) for sets in hanging.values()))
    return LinkUtility(
        names=tuple(segment.name for segment in embedding.graph.segments),
        links=links,
        link_uses=uses[links[:, 0], links[:, 1]],
        link_dependents=np.array(link_dependents, dtype=np.int64),
        segment_uses=uses.sum(axis=0),
        segment_dependents=np.array(segment_dependents, dtype=np.int64),
        n_nodes=embedding.n_nodes,
        n_links=int(uses.sum()),
    )


def _uses(network: StepNetwork, nodes: Nodes) -> np.ndarray:
    """(S, S) int: links of the embedding from nodes of segment a to nodes of segment b."""
    uses = np.zeros((network.n_segments, network.n_segments), dtype=np.int64)
    planes = [plane for bundle in nodes for plane in network.planes(bundle)]
    for segment, heading, _, _, able in network.moves_within(nodes):
        for parent in network.parents[segment]:
            uses[parent, segment] += (planes[parent * network.n_headings + heading] & able).bit_count()
    return uses


def _joined(sets: Iterable[list[int]]) -> list[int]:
    """The union of sets of nodes of one segment."""
    union: list[int] = []
    for bundles in sets:
        union = [x | y for x, y in zip(union, bundles, strict=True)] if union else list(bundles)
    return union


def _alone(sets: dict[int, list[int]]) -> dict[int, list[int]]:
    """Of each of some sets of nodes of one segment what is in no other one."""
    once: list[int] = []
    twice: list[int] = []
    for bundles in sets.values():
        once, twice = once or [0] * len(bundles), twice or [0] * len(bundles)
        twice = [two | (one & x) for one, two, x in zip(once, twice, bundles, strict=True)]
        once = [one | x for one, x in zip(once, bundles, strict=True)]
    single = [one & ~two for one, two in zip(once, twice, strict=True)]
    return {key: [x & y for x, y in zip(bundles, single, strict=True)] for key, bundles in sets.items()}


def _count(bundles: list[int]) -> int:
    return sum(bundle.bit_count() for bundle in bundles)
