"""Cheapest ways: of all ways that arrive within a limit, the one whose links' prices sum up to the least.

Waves of nodes go out from the starts, link after link; of ways that lead to the same node, the cheapest is kept. The
guide knows exactly how much every node still takes to arrive at the least, so that no node is entered from which the
limit cannot be met. Exact as long as no wave holds more than ``BEAM`` nodes; of more, the most promising are followed.
"""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..embedding.link_reader import LinkReader
from ..progress import Progress
from .prices import LinkPrices

#: Nodes of a wave that are followed.
BEAM = 200

#: Milliseconds for each unit that a way takes more than it is to take: more than all else that it may cost.
LATE = 10**6


class Guide(Protocol):
    """Knowledge of the way to a goal, in whole units: segments, or frames.

    Attributes
    ----------
    spends : (S,) int array
        Units that each segment takes.
    unit_price : int
        Milliseconds that a unit costs, as a rule: to compare ways that have come differently far.
    """

    spends: np.ndarray
    unit_price: int

    def passed(self, stage: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        """Return (n,) the goals that are passed at (n, 4) nodes, of those who have passed (n,) ``stage`` before."""
        ...

    def left(self, stage: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        """Return (n,) least units from (n, 4) nodes past all goals; 0 if all are passed, a huge number for no way."""
        ...

    @property
    def n_goals(self) -> int: ...


def cheapest_way_steps(
    reader: LinkReader,
    prices: LinkPrices,
    guide: Guide,
    starts: np.ndarray,
    limit: int,
    stage: np.ndarray | None = None,
    look_ahead: int = 0,
    beam: int = BEAM,
    at_least: int | None = None,
) -> Generator[Progress, None, tuple[int, list[int], int]]:
    """Find the cheapest way of at least one link that passes all goals within ``limit`` units.

    Parameters
    ----------
    starts : (n, 4) int array
        Nodes to start from the best of, whichever tile they lie in; at least one has a way within the limit.
    stage : (n,) int array, optional
        Goals that they have passed already; none by default.
    look_ahead : int
        Links that the way can be followed by: the cheapest ones count, too, so that it does not end where all that
        follows is dear.
    at_least : int, optional
        Units that the way takes at least: of all ways, one that takes the fewest more than that is found.

    Returns
    -------
    row : int
        Of the start.
    stencils : list of int
        Of the way, and of the ``look_ahead`` links that follow it.
    price : int
        Milliseconds, of all these, and ``LATE`` for each unit beyond ``at_least``.
    """
    segment_of, shape = reader.embedding.unrolling.stencils.segment, reader.embedding.shape
    none = np.zeros(len(starts), dtype=np.int64)
    wave = _Wave(reader.wrapped(starts), none, none if stage is None else stage, none, none)
    came: list[tuple[np.ndarray, np.ndarray]] = []
    least, best = np.iinfo(np.int64).max, (0, 0, 0)
    while len(wave.price):
        yield Progress(0.0, "Looking for the cheapest way")
        row, stencil = reader.links_from(wave.nodes)
        price = wave.price[row] + prices.of(wave.nodes[row, 3], stencil)
        affordable = price < least
        row, stencil, price = row[affordable], stencil[affordable], price[affordable]
        nodes = reader.wrapped(reader.ends(wave.nodes[row], stencil))
        beyond = wave.beyond[row] + (wave.stage[row] == guide.n_goals)
        # What is spent beyond the goals does not matter.
        spent = np.where(beyond > 0, 0, wave.spent[row] + guide.spends[segment_of[stencil]])
        sizes = (*shape, guide.n_goals + 1, look_ahead + 1)
        place = np.asarray(np.ravel_multi_index((*nodes.T, wave.stage[row], beyond), sizes))
        if at_least is not None:
            # A way that has spent less is no better.
            place = place * (limit + guide.spends.max() + 1) + spent
        order = _undominated(place, price, spent)
        row, stencil, price, nodes, spent, beyond = (
            values[order] for values in (row, stencil, price, nodes, spent, beyond)
        )
        stage = guide.passed(wave.stage[row], nodes)
        if at_least is not None:
            stage = np.where(spent < at_least, wave.stage[row], stage)
        left = guide.left(stage, nodes)
        arrived, in_time = stage == guide.n_goals, spent + left <= limit
        total, to_go = price, left - beyond
        if at_least is not None:
            total, to_go = price + LATE * np.maximum(spent + left - at_least, 0), np.maximum(left, at_least - spent)
        done = np.flatnonzero(arrived & (beyond == look_ahead) & in_time)
        if len(done):
            cheapest = done[np.argmin(total[done])]
            least, best = int(total[cheapest]), (len(came), int(row[cheapest]), int(stencil[cheapest]))
        going = np.flatnonzero(in_time & ~(arrived & (beyond == look_ahead)) & (total < least))
        promise = total[going] + guide.unit_price * to_go[going]
        going = going[np.argsort(promise, kind="stable")[:beam]]
        came.append((row[going], stencil[going]))
        wave = _Wave(nodes[going], price[going], stage[going], beyond[going], spent[going])
    n_waves, row, stencil = best
    stencils = [stencil]
    for rows, links in reversed(came[:n_waves]):
        stencils.append(int(links[row]))
        row = int(rows[row])
    return row, stencils[::-1], least


def _undominated(place: np.ndarray, price: np.ndarray, spent: np.ndarray) -> np.ndarray:
    """Return those of (n,) ways to whose place no other is as cheap and has spent as little; of equals, the first.

    >>> _undominated(np.array([7, 7, 7, 3]), np.array([20, 10, 30, 40]), np.array([1, 2, 2, 5])).tolist()
    [3, 1, 0]
    """
    order = np.lexsort((spent, price, place))
    _, group = np.unique(place[order], return_inverse=True)
    # Each place has a range of its own, below that of the one before.
    least = np.minimum.accumulate(spent[order] - group * (spent.max(initial=0) + 1))
    return order[np.flatnonzero(np.diff(least, prepend=np.iinfo(np.int64).max) < 0)]


@dataclass(frozen=True)
class _Wave:
    """Nodes that ways have come to, what these cost, the goals that they have passed, their links since, and units."""

    nodes: np.ndarray
    price: np.ndarray
    stage: np.ndarray
    beyond: np.ndarray
    spent: np.ndarray
