"""Joint deletion: which clips can all be thrown away at once?

Single losses do not add up: of two clips that can replace each other each is redundant, but they cannot both go. What
may be lost is measured as :mod:`.ablation` measures it: with an allowance of 1 %, no clip is deleted that it calls
important.
"""

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..errors import EmbeddingError
from ..progress import Progress
from .ablation import IMPORTANT_FLOOR, IMPORTANT_PLACES, without_steps
from .segment_groups import Grouping, SegmentGroup, segment_groups
from .size import EmbeddingSize, embedding_size

#: So much larger a share of the positions and headings may be lost than of the floor: verdicts weigh them like that.
PLACES_FOR_FLOOR = IMPORTANT_PLACES / IMPORTANT_FLOOR


@dataclass(frozen=True)
class JointDeletion:
    """Groups that can be deleted together.

    Attributes
    ----------
    groups : tuple of SegmentGroup
        In the order in which they were chosen: those that cost least first.
    before : EmbeddingSize
        With all of them.
    allowed : float
        Share of the covered floor that might be lost, and of its positions and headings :data:`PLACES_FOR_FLOOR` times
        as much.
    left_after : tuple of EmbeddingSize
        What is left after the first, the first two, ... of the groups are gone.
    """

    groups: tuple[SegmentGroup, ...]
    before: EmbeddingSize
    allowed: float
    left_after: tuple[EmbeddingSize, ...]

    @property
    def left(self) -> EmbeddingSize:
        """The size without any of them."""
        return self.left_after[-1] if self.left_after else self.before

    @property
    def share(self) -> float:
        """Share of the covered floor that is lost without all of them together, 0 to 1."""
        return 1 - self.left.floor / self.before.floor if self.before.floor else 0.0

    @property
    def places_share(self) -> float:
        """Share of the covered positions + headings that is lost without all of them together, 0 to 1."""
        return 1 - self.left.places / self.before.places if self.before.places else 0.0

    @property
    def allowance(self) -> str:
        """The loss that is allowed, in words: "1.0% of the covered floor and 5.0% of its positions and headings"."""
        places = wording.share(allowed_places(self.allowed))
        return f"{wording.share(self.allowed)} of the covered floor and {places} of its positions and headings"

    def describe(self) -> list[str]:
        if not self.groups:
            return [f"Nothing can be deleted without losing more than {self.allowance}."]
        kind = self.groups[0].kind.value
        names = ", ".join(f"'{group.name}'" for group in self.groups)
        what = f"{len(self.groups)} {kind}s can be deleted together" if len(self.groups) > 1 else f"1 {kind} can go"
        lost = wording.area(self.before.floor - self.left.floor)
        return [
            f"{what}: {names}. That costs {lost} ({wording.share(self.share)}) of the covered floor and "
            f"{wording.share(self.places_share)} of its positions and headings; up to {self.allowance} may be lost."
        ]


def allowed_places(allowed: float) -> float:
    """Return the share of the positions and headings that may be lost beside the share ``allowed`` of the floor."""
    return min(PLACES_FOR_FLOOR * allowed, 1.0)


def deletable_together_steps(
    embedding: Embedding, allowed: float, kind: Grouping = Grouping.CLIP
) -> Generator[Progress, None, JointDeletion]:
    """Find groups that can all be deleted.

    The covered floor shrinks by at most the share ``allowed`` (0 to 1), and its positions and headings by
    :func:`allowed_places`. Greedy: next comes the group that costs least now that those before it are gone. Each choice
    is tried together with all earlier ones, and in the end no other group could be added; something is always left.
    Not always the longest list possible: that would take all subsets.

    Raises
    ------
    EmbeddingError
        ``allowed`` is not between 0 and 1.
    """
    if not 0 <= allowed <= 1:
        raise EmbeddingError(f"The share of the floor that may be lost is {allowed}; give one between 0 and 1.")
    before = embedding_size(embedding)
    enough = before.floor * (1 - allowed) - 1e-9
    enough_places = before.places * (1 - allowed_places(allowed)) - 1e-9
    cell_area = embedding.environment.grid.cell_size**2
    chosen: list[SegmentGroup] = []
    left_after: list[EmbeddingSize] = []
    gone: set[int] = set()
    # Minoux's lazy greedy: what a group would leave gets less as more goes, so that the group that leaves most by old
    # numbers is tried first, and taken if it still leaves most.
    known = [
        _Candidate(group, before.floor, before.places, -1, None) for group in segment_groups(embedding.graph, kind)
    ]
    refused: list[_Candidate] = []
    n_asked, n_parts = 0, len(known)
    while known:
        best = min(known, key=lambda entry: (-entry.floor, -entry.places, -entry.asked, entry.group.segments))
        known.remove(best)
        if best.left is None:
            n_asked += 1
            yield Progress(1 - 1 / (1 + n_asked / n_parts), f"Trying without {best.group.name}")
            left = yield from without_steps(embedding, gone.union(best.group.segments))
            covered = left.covered()
            floor, places = int(np.count_nonzero(covered.any(axis=2))) * cell_area, int(np.count_nonzero(covered))
            allowed_now = floor >= enough and places >= enough_places and left.n_nodes > 0
            asked = _Candidate(best.group, floor, places, len(chosen), left)
            (known if allowed_now else refused).append(asked)
        else:
            chosen.append(best.group)
            gone.update(best.group.segments)
            left_after.append(embedding_size(best.left))
            known = [replace(entry, left=None) for entry in known]
        if not known:
            # Another component may have become the largest, one that never needed what was refused: ask once more.
            known = [replace(entry, left=None) for entry in refused if entry.asked < len(chosen)]
            refused = [entry for entry in refused if entry.asked == len(chosen)]
    return JointDeletion(tuple(chosen), before, allowed, tuple(left_after))


@dataclass(frozen=True)
class _Candidate:
    """A group that may be deleted next: the floor and places that are left without it, when ``asked`` were gone."""

    group: SegmentGroup
    floor: float
    places: int
    asked: int
    left: Embedding | None
