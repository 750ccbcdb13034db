"""All metrics at once: those of Reitsma & Pollard 2007, and the wishes of their paper (turn balance, use of links).

One definition for the panel, the report and what they write to files: the same names, the same samples.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..errors import EvaluationError
from ..progress import Progress, portion
from .action_coverage import ActionCoverage, action_coverage
from .environment_coverage import EnvironmentCoverage, environment_coverage
from .link_utility import LinkUtility, link_utility
from .maneuverability import Maneuverability, maneuverabilities_steps
from .path_efficiency import PathEfficiency, path_efficiency_steps
from .segment_groups import Grouping
from .turn_balance import TurnBalance, turn_balance

#: Pairs of places that share a goal, which costs a field of exact times.
PAIRS_FOR_A_GOAL = 5


@dataclass(frozen=True)
class Metrics:
    """All metrics of an embedding.

    Attributes
    ----------
    ground : EnvironmentCoverage
    actions : ActionCoverage
        Of the clips.
    turns : TurnBalance
    links : LinkUtility
    prompt : tuple of Maneuverability
        How soon each clip can begin, in the order of ``actions``.
    ways : PathEfficiency or None
        None where the ground has no two places far enough apart.
    problem : str
        Why there is no path efficiency; empty if there is.
    """

    ground: EnvironmentCoverage
    actions: ActionCoverage
    turns: TurnBalance
    links: LinkUtility
    prompt: tuple[Maneuverability, ...]
    ways: PathEfficiency | None
    problem: str

    @property
    def mean_wait(self) -> float:
        """Mean over the clips that can begin anywhere of the mean seconds until they can; infinite if none can."""
        waits = [found.mean for found in self.prompt if np.isfinite(found.mean)]
        return float(np.mean(waits)) if waits else float("inf")

    @property
    def n_never(self) -> int:
        """Clips that can begin nowhere."""
        return sum(not np.isfinite(found.mean) for found in self.prompt)

    def describe(self) -> list[str]:
        """Sentences for a report."""
        said = [self.ground.describe(), self.actions.describe(), self.turns.describe()]
        ways = self.ways.describe() if self.ways else f"There is no path efficiency: {self.problem}"
        slowest = max(self.prompt, key=lambda found: found.mean).describe()
        return [*said, ways, slowest, self.links.describe()]

    def rows(self) -> list[tuple[str, float | int | None, str]]:
        """Names, values and units ("share": from 0 to 1); None where there is no value."""
        ground, turns, ways = self.ground, self.turns, self.ways
        error = ways.standard_error if ways and ways.n_goals > 1 else None
        wait = self.mean_wait if self.n_never < len(self.prompt) else None
        return [
            ("covered floor", ground.covered_area, "m2"),
            ("free floor", ground.free_area, "m2"),
            ("environment coverage by position", ground.position_share, "share"),
            ("environment coverage by position and heading", ground.task_share, "share"),
            ("floor covered in every heading", ground.full_area, "m2"),
            ("action coverage, mean over clips", float(self.actions.shares.mean()), "share"),
            ("path efficiency, mean", ways.mean if ways else None, "share"),
            ("path efficiency, standard error of the mean", error, "share"),
            ("path efficiency, median", float(np.median(ways.efficiency)) if ways else None, "share"),
            ("path efficiency, pairs of places", len(ways.walked) if ways else 0, "pairs"),
            ("path efficiency, goals", ways.n_goals if ways else 0, "goals"),
            ("local maneuverability, mean over clips", wait, "s"),
            ("clips that can begin nowhere", self.n_never, "clips"),
            ("turn balance (-1: right, 1: left)", turns.total, ""),
            ("links that turn left", turns.n_left, "links"),
            ("links that turn right", turns.n_right, "links"),
            ("links that go straight", turns.n_straight, "links"),
            ("links of the motion graph", len(self.links.links), "links"),
            ("links of the motion graph that are never played", len(self.links.idle_links), "links"),
        ]


def metrics_steps(
    embedding: Embedding, rng: np.random.Generator, n_pairs: int = 100
) -> Generator[Progress, None, Metrics]:
    """Measure an embedding; path efficiency over ``n_pairs`` pairs of places.

    EvaluationError if the embedding is empty, or there are to be no pairs.
    """
    if not embedding.n_nodes:
        raise EvaluationError("The embedding is empty: there is nothing to measure. Make room, or use other clips.")
    if n_pairs < 1:
        raise EvaluationError(f"Path efficiency cannot be measured over {n_pairs} pairs; ask for one or more.")
    yield Progress(0.0, "Measuring coverage")
    ground = environment_coverage(embedding)
    yield Progress(0.05, "Measuring actions")
    actions = action_coverage(embedding, Grouping.CLIP)
    yield Progress(0.1, "Measuring turns")
    turns = turn_balance(embedding)
    yield Progress(0.15, "Measuring links")
    links = link_utility(embedding)
    prompt = yield from portion(maneuverabilities_steps(embedding, Grouping.CLIP), 0.2, 0.6)
    ways, problem = None, ""
    n_goals = max(n_pairs // PAIRS_FOR_A_GOAL, 1)
    try:
        ways = yield from portion(path_efficiency_steps(embedding, rng, n_pairs, n_goals), 0.6, 1.0)
    except EvaluationError as error:
        # A small room has no two places far enough apart; that is no reason to keep the other numbers back.
        problem = str(error)
    return Metrics(ground, actions, turns, links, tuple(prompt), ways, problem)
