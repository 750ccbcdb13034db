"""Local pruning: at each place keep the segments that offer most ways through (paper, section 4.2)."""

from collections.abc import Generator

from ..embedding.embedding import Embedding, restrict_steps
from ..errors import TuningError
from ..progress import Progress, portion
from .ranking import best_nodes_steps


def prune_local_steps(embedding: Embedding, k: int) -> Generator[Progress, None, Embedding]:
    """At each p = (x, y, heading) keep the ``k`` nodes of highest segment variability, and take the largest strongly
    connected component of what is left (paper, section 4.2).

    Of nodes of equal variability the one of the segment with the lower index stays. With ``k`` at least the number
    of segments nothing changes; an empty embedding stays empty.

    Raises
    ------
    TuningError
        ``k`` is not a whole number of at least 1.
    """
    if int(k) != k or k < 1:
        raise TuningError(f"Local pruning to {k} segments at each place leaves nothing; keep at least 1.")
    nodes = yield from portion(best_nodes_steps(embedding, int(k)), 0.0, 0.5)
    return (yield from portion(restrict_steps(embedding, nodes), 0.5, 1.0))
