"""Ablation: what an embedding loses without a segment, a clip or a tag. Which clips matter, which can be deleted?

Without some segments, what is left of an embedding is the largest strongly connected component of the other segments'
nodes. Each is exact, and much cheaper than embedding again: what is left without a whole clip is strongly connected
without any single one of its segments too. The closures for the segment start from all of that instead of from one
node, and are done after two or three rounds instead of twenty.
"""

from collections.abc import Collection, Generator, Sequence
from dataclasses import dataclass
from enum import Enum

from .. import wording
from ..embedding.embedding import Embedding, restrict_steps
from ..embedding.node_set import NodeSet
from ..motion.graph import MotionGraph
from ..progress import Progress, portion
from .segment_groups import Grouping, SegmentGroup, segment_groups
from .size import EmbeddingSize, Objective, embedding_size

#: An embedding that keeps less than this share of its floor without a group has collapsed.
COLLAPSED_SHARE = 0.5

#: A group is important if this share of the floor is lost without it, or ...
IMPORTANT_FLOOR = 0.01
#: ... this share of the positions and headings.
IMPORTANT_PLACES = 0.05

#: Hardly anything is lost: less than this share of both.
SPARE_SHARE = 0.001

#: Neighbouring clips that are first taken away together; what is left is where the search for each of them starts.
GROUPED_CLIPS = 4


class Verdict(Enum):
    """The meaning of a loss, from the gravest to none."""

    ESSENTIAL = "essential: the embedding collapses without it"
    IMPORTANT = "important: a part of the ground is lost without it"
    USEFUL = "useful: some places or headings are lost without it"
    SPARE = "spare: hardly anything is lost without it"
    REDUNDANT = "redundant: nothing is lost without it alone"


@dataclass(frozen=True)
class Loss:
    """The loss of an embedding without a group.

    Attributes
    ----------
    group : SegmentGroup
    before, left : EmbeddingSize
        With and without the group.
    """

    group: SegmentGroup
    before: EmbeddingSize
    left: EmbeddingSize

    @property
    def floor(self) -> float:
        """Square metres of floor lost."""
        return self.before.floor - self.left.floor

    @property
    def share(self) -> float:
        """Lost floor as a share of the floor that was covered, 0 to 1."""
        return self.floor / self.before.floor if self.before.floor else 0.0

    @property
    def places(self) -> int:
        """Positions + headings lost."""
        return self.before.places - self.left.places

    @property
    def places_share(self) -> float:
        """Lost positions + headings as a share of those that were covered, 0 to 1."""
        return self.places / max(self.before.places, 1)

    @property
    def nodes(self) -> int:
        return self.before.nodes - self.left.nodes

    @property
    def links(self) -> int:
        return self.before.links - self.left.links

    @property
    def objective(self) -> float | None:
        """The rise of the objective; None if none was asked for."""
        if self.before.objective is None or self.left.objective is None:
            return None
        # Two endless times are the same.
        return 0.0 if self.left.objective == self.before.objective else self.left.objective - self.before.objective

    @property
    def verdict(self) -> Verdict:
        if self.before.nodes and self.left.floor < COLLAPSED_SHARE * self.before.floor:
            return Verdict.ESSENTIAL
        if self.share >= IMPORTANT_FLOOR or self.places_share >= IMPORTANT_PLACES:
            return Verdict.IMPORTANT
        if self.share >= SPARE_SHARE or self.places_share >= SPARE_SHARE:
            return Verdict.USEFUL
        return Verdict.SPARE if self.floor or self.places else Verdict.REDUNDANT

    def describe(self) -> str:
        """One sentence: "Clip 'turn' is important: without it 3.20 m² (12.0%) of the covered floor and ... lost."."""
        subject, word = f"{self.group.kind.value.capitalize()} '{self.group.name}'", self.verdict.name.lower()
        if self.verdict is Verdict.REDUNDANT:
            return f"{subject} is redundant: without it alone every place stays within reach in every heading."
        if not self.left.nodes:
            return f"{subject} is essential: without it no endless walk is left."
        return (
            f"{subject} is {word}: without it {wording.area(self.floor)} ({wording.share(self.share)}) of the covered "
            f"floor and {wording.share(self.places_share)} of its positions and headings are lost."
        )


@dataclass(frozen=True)
class Ablation:
    """The losses without each of some groups.

    Attributes
    ----------
    before : EmbeddingSize
        Of the whole embedding.
    losses : tuple of Loss
        In the order of kinds, and of segments, clips and tags.
    objective : Objective or None
    """

    before: EmbeddingSize
    losses: tuple[Loss, ...]
    objective: Objective | None = None

    def ranked(self, kind: Grouping | None = None) -> list[Loss]:
        """The losses of one kind, or all, greatest first: by floor, places, the objective, then nodes and links."""
        chosen = [loss for loss in self.losses if kind is None or loss.group.kind is kind]
        return sorted(chosen, key=lambda loss: (-loss.floor, -loss.places, -(loss.objective or 0), -loss.nodes))

    def table(self, kind: Grouping | None = None) -> tuple[list[str], list[list]]:
        """The ranked losses as the names of columns and rows of text and numbers."""
        columns = ["name", "kind", "lost floor (m2)", "lost share", "lost places", "lost nodes", "lost links"]
        if self.objective is not None:
            columns.append(f"{self.objective.name}, rise ({self.objective.unit})")
        rows = []
        for loss in self.ranked(kind):
            group = loss.group
            row = [group.name, group.kind.value, loss.floor, loss.share, loss.places, loss.nodes, loss.links]
            rows.append([*row, *([] if self.objective is None else [loss.objective]), loss.verdict.name.lower()])
        return [*columns, "verdict"], rows

    def describe(self, kind: Grouping = Grouping.CLIP) -> list[str]:
        """Sentences for a report: how many of a kind matter, then one for each, greatest loss first."""
        ranked = self.ranked(kind)
        if not ranked:
            return [f"There is no {kind.value} to take away."]
        numbers = [(sum(loss.verdict is v for loss in ranked), v.name.lower()) for v in Verdict]
        said = ", ".join(f"{n} {name}" for n, name in numbers if n)
        lead = f"Of {wording.counted(len(ranked), kind.value)}, taken away one at a time: {said}."
        return [lead, *(loss.describe() for loss in ranked)]


def without_steps(
    embedding: Embedding, segments: Collection[int], core: NodeSet | None = None
) -> Generator[Progress, None, Embedding]:
    """Restrict an embedding to the nodes of all but some segments (indices). Yields progress.

    ``core`` may be a strongly connected set of nodes of other segments: see :func:`.restrict_steps`.
    """
    n_headings, gone = embedding.shape[2], set(segments)
    return restrict_steps(embedding, embedding.nodes.where(lambda index: index // n_headings not in gone), core)


def ablate_steps(
    embedding: Embedding, kinds: Sequence[Grouping] = tuple(Grouping), objective: Objective | None = None
) -> Generator[Progress, None, Ablation]:
    """Find what an embedding loses without each of its segments, each of its clips and each tag, one at a time.

    Without a tag means: without all segments that carry it on any frame. All numbers are exact, those of the objective
    as exact as it is.
    """
    graph, before = embedding.graph, embedding_size(embedding, objective)
    wanted = [group for kind in kinds for group in segment_groups(graph, kind)]
    plan = _plan(graph, {group.segments for group in wanted})
    cores: dict[tuple[int, ...] | None, NodeSet] = {}
    seeding = set(plan.values())
    left: dict[tuple[int, ...], EmbeddingSize] = {}
    for done, (segments, larger) in enumerate(plan.items()):
        steps = without_steps(embedding, segments, cores.get(larger))
        rest = yield from portion(steps, done / len(plan), (done + 1) / len(plan))
        if segments in seeding:
            cores[segments] = rest.nodes
        left[segments] = embedding_size(rest, objective)
    return Ablation(before, tuple(Loss(group, before, left[group.segments]) for group in wanted), objective)


def _plan(graph: MotionGraph, wanted: set[tuple[int, ...]]) -> dict[tuple[int, ...], tuple[int, ...] | None]:
    """Plan what to take away, in which order, and the larger set, taken before, whose rest makes the search faster."""
    plan: dict[tuple[int, ...], tuple[int, ...] | None] = {}
    clips = [group.segments for group in segment_groups(graph, Grouping.CLIP)]
    for first in range(0, len(clips), GROUPED_CLIPS):
        grouped = clips[first : first + GROUPED_CLIPS]
        group = tuple(sorted(sum(grouped, ())))
        n_wanted = sum(group in wanted for clip in grouped for group in {clip, *((i,) for i in clip)})
        if n_wanted > 1 and len(clips) > GROUPED_CLIPS:
            plan.setdefault(group, None)
        for clip in grouped:
            single = [(i,) for i in clip if (i,) in wanted]
            if clip in wanted or len(single) > 1:
                plan.setdefault(clip, group if group in plan else None)
            for segment in single:
                plan.setdefault(segment, clip if clip in plan else None)
    for segments in sorted(wanted):
        plan.setdefault(segments, None)
    return plan
