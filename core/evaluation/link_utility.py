"""Utility of the motion graph's links and segments: how much of the embedding depends on each.

Counted, not tried: what stands or falls at once. A node *depends* on a link of the motion graph where all links of the
embedding that lead to it, or all that lead from it, play that one transition: without it the node is dead. What dies
next because of that is left to ablation (:mod:`.ablation`), which is exact and takes longer.
"""

from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.network import StepNetwork
from ..embedding.node_set import NodeSet


@dataclass(frozen=True)
class LinkUtility:
    """The nodes that depend on each link and segment of a motion graph.

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
    """Count the uses of every link and segment of the motion graph in an embedding, and the nodes that need each."""
    network, n_segments, n_headings = embedding.network, embedding.shape[3], embedding.shape[2]
    uses = _uses(network, embedding.nodes)
    own = [NodeSet(embedding.planes[s * n_headings : (s + 1) * n_headings]) for s in range(n_segments)]
    # [a, b]: the nodes of a whose links all lead to b, and the nodes of b whose links all come from a.
    leaving_by: dict[tuple[int, int], NodeSet] = {}
    entered_from: dict[tuple[int, int], NodeSet] = {}
    playable = [NodeSet(tuple(network.playable(b, own[b].planes))) for b in range(n_segments)]
    for b in range(n_segments):
        arrivals = {a: NodeSet(tuple(network.arrivals(b, own[a].planes))) & own[b] for a in network.parents[b]}
        for a, only in _alone(arrivals).items():
            entered_from[a, b] = only
    for a in range(n_segments):
        for b, only in _alone({b: playable[b] & own[a] for b in network.children[a]}).items():
            leaving_by[a, b] = only

    links = np.asarray(embedding.graph.links)
    link_dependents = [
        len(leaving_by[a, a] | entered_from[a, a]) if a == b else len(leaving_by[a, b]) + len(entered_from[a, b])
        for a, b in links.tolist()
    ]
    segment_dependents = []
    for c in range(n_segments):
        dependents = {c: own[c]}
        for a in network.parents[c]:
            dependents[a] = dependents[a] | leaving_by[a, c] if a in dependents else leaving_by[a, c]
        for b in network.children[c]:
            dependents[b] = dependents[b] | entered_from[c, b] if b in dependents else entered_from[c, b]
        segment_dependents.append(sum(map(len, dependents.values())))
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


def _uses(network: StepNetwork, nodes: NodeSet) -> np.ndarray:
    """(S, S) int: links of the embedding from nodes of segment a to nodes of segment b."""
    uses = np.zeros((network.n_segments, network.n_segments), dtype=np.int64)
    for segment, heading, _, _, able in network.moves_within(nodes):
        for parent in network.parents[segment]:
            uses[parent, segment] += (nodes.planes[parent * network.n_headings + heading] & able).bit_count()
    return uses


def _alone(sets: dict[int, NodeSet]) -> dict[int, NodeSet]:
    """Return of each of some sets of nodes of one segment the part that is in no other one."""
    once, twice = None, None
    for nodes in sets.values():
        twice = nodes - nodes if once is None or twice is None else twice | (once & nodes)
        once = nodes if once is None else once | nodes
    return {key: nodes - twice for key, nodes in sets.items()} if twice is not None else {}
