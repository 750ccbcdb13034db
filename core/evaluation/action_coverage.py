"""Action coverage: on how much of the free ground each action can be performed.

Reitsma & Pollard 2007, "Evaluating motion graphs for character animation". An action is a segment, a clip or a tag;
it can be performed where one of its segments can begin on a link of the embedding.
"""

from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..embedding.node_set import union_of
from .floor import floor_cells
from .segment_groups import Grouping, SegmentGroup, segment_groups


@dataclass(frozen=True)
class ActionCoverage:
    """The places where each action can begin.

    Attributes
    ----------
    actions : tuple of SegmentGroup
        n segments, clips or tags.
    begins : (n, nx, ny) bool array
        Cells in which a link of the embedding begins the action, in at least one heading.
    areas : (n,) float array
        Square metres of them.
    shares : (n,) float array
        The same as a share of the free floor, 0 to 1.
    """

    actions: tuple[SegmentGroup, ...]
    begins: np.ndarray
    areas: np.ndarray
    shares: np.ndarray

    def ranked(self) -> list[int]:
        """Indices of the actions, least coverage first."""
        return np.argsort(self.areas, kind="stable").tolist()

    def _named(self, index: int) -> str:
        where = f"{wording.area(float(self.areas[index]))}, {wording.share(float(self.shares[index]))}"
        return f"'{self.actions[index].name}' ({where})"

    def describe(self) -> str:
        if not self.actions:
            return "There is no action to look for."
        kind = self.actions[0].kind.value
        least, *_, most = self.ranked()[:1] + self.ranked()[-1:]
        text = (
            f"On average a {kind} can begin on {wording.share(float(self.shares.mean()))} of the free floor: most "
            f"often {self._named(most)}, least often {self._named(least)}."
        )
        n_never = int(np.count_nonzero(self.areas == 0))
        return text + (f" {n_never} of {len(self.actions)} can begin nowhere." if n_never else "")


def action_coverage(embedding: Embedding, kind: Grouping = Grouping.CLIP) -> ActionCoverage:
    """Find where each segment, clip or tag of an embedding's motion graph can begin."""
    network, layout = embedding.network, embedding.network.layout
    standing = [
        union_of(embedding.planes[parent * network.n_headings + heading] for parent in network.parents[members[0]])
        for members in network.entry_groups
        for heading in range(network.n_headings)
    ]
    began = [0] * network.n_segments
    for segment, heading, _, _, able in network.moves_within(embedding.nodes):
        began[segment] |= able & standing[network.entry_group_of[segment] * network.n_headings + heading]

    actions = tuple(segment_groups(embedding.graph, kind))
    begins = np.zeros((len(actions), *embedding.shape[:2]), dtype=bool)
    for index, action in enumerate(actions):
        begins[index] = layout.unpack(union_of(began[segment] for segment in action.segments))
    n_cells = np.count_nonzero(begins, axis=(1, 2))
    areas = n_cells * embedding.environment.grid.cell_size**2
    return ActionCoverage(actions, begins, areas, n_cells / max(int(np.count_nonzero(floor_cells(embedding))), 1))
