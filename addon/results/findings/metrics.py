"""The metrics of Reitsma and Pollard 2007, and the paper's own wishes: turn balance, utility of links."""

import math
from collections.abc import Generator

import numpy as np

from ....core import wording
from ....core.embedding.embedding import Embedding
from ....core.evaluation.metrics import Metrics, metrics_steps
from ....core.progress import Progress
from ....core.report.finding_tables import actions_table, links_table, metrics_table
from .finding import ACTIONS, LINKS, METRICS, Finding, Row


def measure_steps(
    embedding: Embedding, rng: np.random.Generator, n_pairs: int
) -> Generator[Progress, None, list[Finding]]:
    """The numbers of an embedding, of its actions (clips) and of its links; path efficiency over ``n_pairs`` pairs."""
    found = yield from metrics_steps(embedding, rng, n_pairs)
    links = Finding(LINKS, embedding, links_table(embedding, found.links), sentences=(found.links.describe(),))
    return [_metrics(embedding, found), _actions(embedding, found), links]


def _metrics(embedding: Embedding, found: Metrics) -> Finding:
    ground, ways, turns = found.ground, found.ways, found.turns
    efficiency = [("Path Efficiency", "too little room")]
    if ways:
        efficiency = [("Path Efficiency", ways.mean_in_words), ("Sampled", ways.sample)]
    wait = "never" if math.isinf(found.mean_wait) else f"{wording.time(found.mean_wait)} to a clip"
    return Finding(
        METRICS,
        embedding,
        metrics_table(found),
        numbers=(
            ("Position", f"{wording.share(ground.position_share)} ({wording.area(ground.covered_area)})"),
            ("Position + Heading", wording.share(ground.task_share)),
            ("Every Heading", wording.area(ground.full_area)),
            ("Actions", f"{wording.share(float(found.actions.shares.mean()))} of the floor"),
            *efficiency,
            ("Maneuverability", wait),
            ("Turn Balance", f"{wording.balance(turns.total)} ({_leaning(turns.total)})"),
            ("Links Unused", wording.of(len(found.links.idle_links), len(found.links.links))),
        ),
        sentences=tuple(found.describe()),
    )


def _leaning(balance: float) -> str:
    return "even" if abs(balance) < 0.05 else "left" if balance > 0 else "right"


def _actions(embedding: Embedding, found: Metrics) -> Finding:
    lines = []
    for index in found.actions.ranked():
        action, wait = found.actions.actions[index], found.prompt[index]
        area, share = wording.area(float(found.actions.areas[index])), wording.share(float(found.actions.shares[index]))
        sentence = f"Can begin on {area}, {share} of the free floor. {wait.describe()}"
        lines.append(Row(action.name, share, wording.time(wait.mean), sentence, "ACTION"))
    return Finding(ACTIONS, embedding, actions_table(found), rows=tuple(lines))
