"""Pruned embeddings: made in one of three ways, and what they cost against the whole one."""

from collections.abc import Generator
from dataclasses import dataclass
from enum import Enum

from ..embedding.embedding import Embedding, with_nodes
from ..embedding.node_set import NodeSet
from ..errors import EmbeddingError
from ..evaluation.size import EmbeddingSize, embedding_size
from ..progress import Progress, portion
from ..wording import counted, memory, share
from .budget import BudgetSettings, Limit, prune_to_budget_steps
from .global_pruning import prune_global_steps
from .local_pruning import prune_local_steps

#: The numbers of :class:`.EmbeddingSize` that are kept in files.
_SIZES = ("floor", "share", "places", "nodes", "links")


class PruningMethod(Enum):
    """The ways to make an embedding smaller."""

    LOCAL = "local"
    GLOBAL = "global"
    BUDGET = "budget"


@dataclass(frozen=True)
class PruningSettings:
    """A way to prune an embedding; only what its method needs counts.

    Attributes
    ----------
    method : PruningMethod
    k : int
        Segments kept at each place.
    n_segments : int
        Segments kept of the motion graph.
    budget : BudgetSettings
    """

    method: PruningMethod
    k: int
    n_segments: int
    budget: BudgetSettings

    @property
    def words(self) -> str:
        """ "5 segments at each place"."""
        if self.method is PruningMethod.LOCAL:
            return f"{counted(self.k, 'segment')} at each place"
        if self.method is PruningMethod.GLOBAL:
            return f"{counted(self.n_segments, 'segment')} in all"
        if self.budget.limit is Limit.LINKS:
            return f"At most {counted(self.budget.budget, 'link')}"
        return f"At most {memory(self.budget.budget)}"


@dataclass(frozen=True)
class Pruning:
    """An embedding and what pruning made of it.

    Attributes
    ----------
    whole, pruned : Embedding
        The same one twice if nothing had to go.
    before, after : EmbeddingSize
    words : str
        How it was pruned.
    sentences : tuple of str
        What there is to say.
    met : bool
        Whether the budget, if there was one, is kept.
    """

    whole: Embedding
    pruned: Embedding
    before: EmbeddingSize
    after: EmbeddingSize
    words: str
    sentences: tuple[str, ...] = ()
    met: bool = True


def prune_steps(whole: Embedding, settings: PruningSettings) -> Generator[Progress, None, Pruning]:
    """Prune an embedding; TuningError if the settings leave nothing to keep."""
    sentences, met = (), True
    if settings.method is PruningMethod.LOCAL:
        pruned = yield from portion(prune_local_steps(whole, settings.k), 0.0, 0.9)
    elif settings.method is PruningMethod.GLOBAL:
        found = yield from portion(prune_global_steps(whole, settings.n_segments), 0.0, 0.9)
        pruned = found.embedding
        sentences = tuple(
            f"Without '{drop.name}', too, {share(drop.coverage)} of the free floor is covered."
            for drop in found.dropped
        )
    else:
        budgeted = yield from portion(prune_to_budget_steps(whole, settings.budget), 0.0, 0.9)
        pruned, met, sentences = budgeted.embedding, budgeted.met, (budgeted.describe(),)
    if pruned.planes == whole.planes:
        pruned = whole
    yield Progress(0.9, "Counting links")
    return Pruning(whole, pruned, embedding_size(whole), embedding_size(pruned), settings.words, sentences, met)


def pruning_to_plain(pruning: Pruning) -> dict:
    """Return everything but the embeddings, for a file."""
    before, after = ({name: getattr(size, name) for name in _SIZES} for size in (pruning.before, pruning.after))
    return {
        "before": before,
        "after": after,
        "words": pruning.words,
        "sentences": pruning.sentences,
        "met": pruning.met,
    }


def pruning_from_plain(plain: dict, whole: Embedding, planes: tuple[int, ...]) -> Pruning:
    """Read a pruning from a file, with the pruned embedding's planes; EmbeddingError if they do not fit."""
    if len(planes) != len(whole.planes) or any(a & ~b for a, b in zip(planes, whole.planes, strict=True)):
        raise EmbeddingError("the pruned embedding is no part of the whole one.")
    # Of the same network, so that its links are not kept twice.
    pruned = with_nodes(whole, NodeSet(tuple(planes)))
    before, after = ([plain[size][name] for name in _SIZES] for size in ("before", "after"))
    if not all(isinstance(value, int | float) for value in (*before, *after)):
        raise EmbeddingError("the sizes of the pruned embedding are no numbers.")
    sentences = tuple(str(sentence) for sentence in plain["sentences"])
    sizes = EmbeddingSize(*before), EmbeddingSize(*after)
    return Pruning(whole, pruned, *sizes, str(plain["words"]), sentences, bool(plain["met"]))
