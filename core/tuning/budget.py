"""Budgeted pruning: at most so many links or bytes, and still nearly everything can be reached.

The k-rule of :mod:`.local_pruning` promises neither a size nor what is left. Here both are settings: how large the
result may be, and how much of what the embedding is good for may be lost. What is promised is checked on the result.

The result grows from a spanning subgraph (see :mod:`.spanning`), which covers every place with few links; only if even
that is too large, places are given up, the most remote ones first, as far as is allowed - or local pruning is the
start, if that covers more. What the budget has left is filled with the best nodes. Whatever is added to the start can
only add places, so that bisection finds the most that fits.
"""

from collections.abc import Generator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from .. import wording
from ..embedding.closure import reached_from_steps, reaching_steps
from ..embedding.embedding import Embedding, with_nodes
from ..embedding.node_set import NodeSet
from ..errors import TuningError
from ..evaluation.size import Objective
from ..progress import Progress, portion
from .filling import Filling, FillOrder, filling_steps
from .local_pruning import prune_local_steps
from .spanning import Places, SpanningPlan, covered_places, plan_spanning_steps, spanning_steps

#: An engine's table of a motion graph's embedding: for each node x, y, heading and segment as 16 bit numbers and the
#: index of its first link (32 bit); for each link the index of the node that it leads to (32 bit).
NODE_BYTES = 4 * 2 + 4
LINK_BYTES = 4

#: A budget counts as used up within this share; refining goes on while more is left.
_CLOSE_ENOUGH = 0.002

#: Where the budget cannot be met, the least that keeps the objective is sought in steps of this part of all nodes.
_MEASURED = 1000


def table_bytes(n_nodes: int, n_links: int) -> int:
    """Return the bytes of an engine's table of an embedding: 12 for each node, 4 for each link and 4 for the last row.

    A node takes x, y, heading and segment as uint16 and the index of its first link as uint32; a link the index of
    its destination as uint32. Durations are those of the destination's segment.

    >>> table_bytes(n_nodes=2, n_links=3)
    40
    """
    return n_nodes * NODE_BYTES + n_links * LINK_BYTES + LINK_BYTES


class Limit(Enum):
    """The units that a budget can count."""

    LINKS = "Links"
    BYTES = "Bytes"


@dataclass(frozen=True)
class BudgetSettings:
    """Limits to what a pruned embedding may cost, and to what it may lose.

    Attributes
    ----------
    limit : Limit
        What ``budget`` counts: links, or bytes of an engine's table (see :func:`table_bytes`).
    budget : int
    places : Places
        Whether coverage means cells, or cells and headings.
    coverage_loss : float
        Share of the places covered by the embedding that the result may lose, from 0 to 1.
    objective : Objective, optional
        Any number of an embedding that should stay low, such as the mean time to reach a goal.
    objective_growth : float
        The result's objective may be at most this many times that of the embedding; 1 or more.
    """

    limit: Limit = Limit.LINKS
    budget: int = 100_000
    places: Places = Places.CELLS
    coverage_loss: float = 0.0
    objective: Objective | None = None
    objective_growth: float = 1.1

    def __post_init__(self):
        if not self.budget >= 0:
            raise TuningError(f"A budget of {self.budget} {self.limit.value.lower()} is no budget; use 0 or more.")
        if not 0 <= self.coverage_loss <= 1:
            raise TuningError(f"Coverage may fall by a share from 0 to 1, not {self.coverage_loss}.")
        if not self.objective_growth >= 1:
            raise TuningError(
                f"The objective may grow to {self.objective_growth} times its value at most; use 1 or more: "
                "pruning never makes it less."
            )

    def cost(self, n_nodes: int, n_links: int) -> int:
        """Count an embedding's size in the units of the budget."""
        return n_links if self.limit is Limit.LINKS else table_bytes(n_nodes, n_links)


@dataclass(frozen=True)
class BudgetedPruning:
    """An embedding pruned to a budget. The promises about coverage and objective hold whether or not the budget is met.

    Attributes
    ----------
    embedding : Embedding
        If the budget is not met: the smallest that was found to keep the promises.
    settings : BudgetSettings
    met : bool
        Whether the result fits into the budget.
    cost, cost_before : int
        Links or bytes.
    places, places_before : int
        Places covered.
    objective, objective_before : float or None
    """

    embedding: Embedding
    settings: BudgetSettings
    met: bool
    cost: int
    cost_before: int
    places: int
    places_before: int
    objective: float | None
    objective_before: float | None

    @property
    def coverage_kept(self) -> float:
        """Share of the places covered before that the result covers; 1 if there were none."""
        return self.places / self.places_before if self.places_before else 1.0

    def describe(self) -> str:
        """The result in a sentence."""
        unit = self.settings.limit.value.lower()
        kept = f"{wording.share(self.coverage_kept)} of the {self.settings.places.value.lower()}"
        worth = ""
        asked = self.settings.objective
        if asked is not None and self.objective is not None and self.objective_before is not None:
            now, before = wording.short(self.objective), wording.short(self.objective_before)
            worth = f", with a {asked.name} of {now} {asked.unit} instead of {before}"
        size = f"{wording.number(self.cost)} of {wording.number(self.cost_before)} {unit} keep {kept}{worth}"
        if self.met:
            return f"{size}."
        return (
            f"The budget of {wording.number(self.settings.budget)} {unit} cannot be met: {size}, and nothing smaller "
            "was found that keeps what was asked for; raise the budget (Links or Megabytes) or May Lose."
        )


def prune_to_budget_steps(
    embedding: Embedding, settings: BudgetSettings, order: FillOrder | None = None
) -> Generator[Progress, None, BudgetedPruning]:
    """Prune an embedding to a budget of links or bytes, with promises about what is left.

    Parameters
    ----------
    order : FillOrder, optional
        What is kept beyond the spanning subgraph; by default the best nodes at each place, like local pruning. With an
        objective that this fails to keep low, the other order is tried, too.

    Returns
    -------
    BudgetedPruning
        Strongly connected, a part of ``embedding``; it covers at least 1 - ``coverage_loss`` of the places, and its
        objective is at most ``objective_growth`` times what it was - always. ``met`` says whether it fits the budget.
    """
    trial = _Trial(embedding, settings)
    if trial.fits(embedding) or not embedding.n_nodes:
        return trial.result(embedding)
    plan = yield from portion(plan_spanning_steps(embedding, settings.places), 0.0, 0.2)
    smallest = yield from portion(_core_steps(plan, trial), 0.2, 0.35)
    if trial.places(smallest) < trial.n_places:
        by_rule = yield from portion(_by_rule_steps(trial), 0.35, 0.4)
        if trial.prefers(by_rule, smallest):
            smallest = by_rule
    if settings.objective is None and not trial.fits(smallest):
        return trial.result(smallest)
    best = None
    orders = [order] if order else list(FillOrder) if settings.objective else [FillOrder.PLACES]
    for turn, chosen in enumerate(orders):
        start, end = 0.4 + 0.6 * turn / len(orders), 0.4 + 0.6 * (turn + 1) / len(orders)
        filling = yield from portion(filling_steps(embedding, chosen), start, (start + end) / 2)
        steps = _filled_steps(trial, filling, smallest)
        found = yield from portion(steps, (start + end) / 2, end)
        if best is None or (trial.fits(found), -trial.cost(found)) > (trial.fits(best), -trial.cost(best)):
            best = found
        if trial.fits(best):
            break
    assert best is not None
    return trial.result(best)


class _Trial:
    """Judges candidates against the settings and the embedding that they come from."""

    def __init__(self, embedding: Embedding, settings: BudgetSettings):
        self.embedding = embedding
        self.settings = settings
        self.objective_before = None if settings.objective is None else float(settings.objective.of(embedding))
        self.n_places = self.places(embedding)

    @property
    def n_required(self) -> int:
        """Places that the result has to cover. A share that falls short of a whole number by rounding is one."""
        return int(np.ceil(self.n_places * (1 - self.settings.coverage_loss) - 1e-9 * self.n_places))

    def places(self, candidate: Embedding) -> int:
        return int(np.count_nonzero(covered_places(candidate, self.settings.places)))

    def prefers(self, candidate: Embedding, to: Embedding) -> bool:
        """Return True if a candidate fits and covers enough, and more than another one, if that fits, too."""
        n_places = self.places(candidate)
        if not self.fits(candidate) or n_places < self.n_required:
            return False
        return not self.fits(to) or n_places > self.places(to)

    def cost(self, candidate: Embedding) -> int:
        return self.settings.cost(candidate.n_nodes, candidate.n_links)

    def fits(self, candidate: Embedding) -> bool:
        return self.cost(candidate) <= self.settings.budget

    def keeps_objective(self, candidate: Embedding) -> bool:
        """Return True if the objective has not grown too far, also from infinity; never where it is not a number."""
        if self.settings.objective is None or self.objective_before is None or candidate is self.embedding:
            return True
        return float(self.settings.objective.of(candidate)) <= self.settings.objective_growth * self.objective_before

    def result(self, embedding: Embedding) -> BudgetedPruning:
        settings = self.settings
        return BudgetedPruning(
            embedding=embedding,
            settings=settings,
            met=self.fits(embedding),
            cost=self.cost(embedding),
            cost_before=self.cost(self.embedding),
            places=self.places(embedding),
            places_before=self.n_places,
            objective=None if settings.objective is None else float(settings.objective.of(embedding)),
            objective_before=self.objective_before,
        )


def _core_steps(plan: SpanningPlan, trial: _Trial) -> Generator[Progress, None, Embedding]:
    """Find the spanning subgraph of as many places as fit into the budget, but of no fewer than are required.

    The most remote places, in links from the centre, are given up first. No nodes, if none is required or fits.
    """
    places = np.flatnonzero(plan.depth.ravel() >= 0)
    order = places[np.argsort(plan.depth.ravel()[places], kind="stable")]
    low, high = trial.n_required, len(order)
    smallest = trial.embedding
    n_wanted = high
    n_tries = max(high - low, 1).bit_length() + 1
    for turn in range(n_tries + 1):
        wanted = np.zeros(plan.depth.size, dtype=bool)
        wanted[order[:n_wanted]] = True
        steps = spanning_steps(plan, wanted.reshape(plan.depth.shape))
        nodes = yield from portion(steps, turn / (n_tries + 1), (turn + 1) / (n_tries + 1))
        core = with_nodes(trial.embedding, nodes)
        if trial.fits(core):
            smallest, low = core, n_wanted + 1
        else:
            if trial.cost(core) < trial.cost(smallest):
                smallest = core
            high = n_wanted - 1
        if low > high:
            break
        n_wanted = (low + high) // 2
    if trial.n_required == 0 and not trial.fits(smallest):
        return with_nodes(trial.embedding, trial.embedding.network.empty)
    return smallest


def _by_rule_steps(trial: _Trial) -> Generator[Progress, None, Embedding]:
    """Local pruning to the largest k that fits into the budget; to 1, if none does."""
    low, high = 1, trial.embedding.shape[3]
    best = yield from prune_local_steps(trial.embedding, 1)
    while high - low > 1 and trial.fits(best):
        middle = (low + high) // 2
        pruned = yield from prune_local_steps(trial.embedding, middle)
        if trial.fits(pruned):
            low, best = middle, pruned
        else:
            high = middle
    return best


def _filled_steps(trial: _Trial, filling: Filling, core: Embedding) -> Generator[Progress, None, Embedding]:
    """The core, filled until the budget is used up; filled further only if the objective demands it.

    What holds more nodes of the filling holds all that held fewer, and may grow around it.
    """
    taken, best = 0, core
    if trial.fits(best):
        low, high = taken, filling.n_steps
        while high - low > 1 and trial.cost(best) < trial.settings.budget * (1 - _CLOSE_ENOUGH):
            middle = (low + high) // 2
            share = 1 - (high - low) / filling.n_steps
            grown = yield from portion(_grown_steps(trial, filling, best.nodes, middle), share / 2, share / 2)
            if trial.fits(grown):
                low = taken = middle
                best = grown
            else:
                high = middle
    if trial.keeps_objective(best):
        return best
    # Nothing that fits keeps the objective low enough: the least that does.
    low, high, kept = taken, filling.n_steps, trial.embedding
    while high - low > max(filling.n_steps // _MEASURED, 1):
        middle = (low + high) // 2
        share = 1 - (high - low) / filling.n_steps
        grown = yield from portion(_grown_steps(trial, filling, best.nodes, middle), (1 + share) / 2, (1 + share) / 2)
        if trial.keeps_objective(grown):
            high, kept = middle, grown
        else:
            low, best = middle, grown
    return kept


def _grown_steps(trial: _Trial, filling: Filling, core: NodeSet, n_steps: int) -> Generator[Progress, None, Embedding]:
    within = core | filling.nodes(n_steps)
    network = trial.embedding.network
    reached = yield from portion(reached_from_steps(network, core, within), 0.0, 0.5)
    nodes = yield from portion(reaching_steps(network, core, reached), 0.5, 1.0)
    return with_nodes(trial.embedding, nodes)
