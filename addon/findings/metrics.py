"""The metrics of Reitsma and Pollard 2007, and the paper's own wishes: turn balance, utility of links."""

import math
from collections.abc import Generator

import numpy as np

from ...core.embedding.embedding import Embedding
from ...core.errors import EvaluationError
from ...core.evaluation.ablation import Kind
from ...core.evaluation.action_coverage import ActionCoverage, action_coverage
from ...core.evaluation.environment_coverage import EnvironmentCoverage, environment_coverage
from ...core.evaluation.link_utility import LinkUtility, link_utility
from ...core.evaluation.maneuverability import Maneuverability, maneuverabilities_steps
from ...core.evaluation.path_efficiency import PathEfficiency, path_efficiency_steps
from ...core.evaluation.turn_balance import TurnBalance, turn_balance
from ...core.progress import Progress, portion
from ...core.report.table import Table, table
from ..text import counted
from .finding import ACTIONS, LINKS, METRICS, Finding, Row


def measure_steps(
    embedding: Embedding, rng: np.random.Generator, n_pairs: int
) -> Generator[Progress, None, list[Finding]]:
    """The numbers of an embedding, of its actions (clips) and of its links; path efficiency over ``n_pairs`` pairs."""
    if not embedding.n_nodes:
        raise EvaluationError("The embedding is empty: there is nothing to measure. Make room, or use other clips.")
    yield Progress(0.0, "Measuring coverage")
    ground = environment_coverage(embedding)
    yield Progress(0.05, "Measuring actions")
    actions = action_coverage(embedding, Kind.CLIP)
    yield Progress(0.1, "Measuring turns")
    turns = turn_balance(embedding)
    yield Progress(0.15, "Measuring links")
    links = link_utility(embedding)
    prompt = yield from portion(maneuverabilities_steps(embedding, Kind.CLIP), 0.2, 0.6)
    ways, problem = None, ""
    try:
        ways = yield from portion(path_efficiency_steps(embedding, rng, n_pairs, max(n_pairs // 5, 1)), 0.6, 1.0)
    except EvaluationError as error:
        # A small room has no two places far enough apart; that is no reason to keep the other numbers back.
        problem = str(error)
    return [
        _metrics(embedding, ground, actions, turns, links, prompt, ways, problem),
        _actions(embedding, actions, prompt),
        _links(embedding, links),
    ]


def _metrics(
    embedding: Embedding,
    ground: EnvironmentCoverage,
    actions: ActionCoverage,
    turns: TurnBalance,
    links: LinkUtility,
    prompt: list[Maneuverability],
    ways: PathEfficiency | None,
    problem: str,
) -> Finding:
    waits = [found.mean for found in prompt if math.isfinite(found.mean)]
    idle = len(links.idle_links)
    rows = [
        ("covered floor", ground.covered_area, "m2"),
        ("free floor", ground.free_area, "m2"),
        ("coverage by position", ground.position_share, "share"),
        ("coverage by position and heading", ground.task_share, "share"),
        ("floor covered in every heading", ground.full_area, "m2"),
        ("mean action coverage", float(actions.shares.mean()), "share"),
        ("turn balance", turns.total, "-1 right to 1 left"),
        ("links that turn left", turns.n_left, "links"),
        ("links that turn right", turns.n_right, "links"),
        ("links that go straight", turns.n_straight, "links"),
        ("mean path efficiency", ways.mean if ways else None, "share"),
        ("pairs of places", len(ways.seconds) if ways else 0, "pairs"),
        ("speed of the geodesic", ways.speed if ways else None, "m/s"),
        ("mean time until an action can begin", float(np.mean(waits)) if waits else None, "s"),
        ("actions that can begin nowhere", len(prompt) - len(waits), "actions"),
        ("links of the motion graph", len(links.links), "links"),
        ("links that are never played", idle, "links"),
    ]
    said = [ground.describe(), actions.describe(), turns.describe()]
    said += [ways.describe() if ways else f"There is no path efficiency: {problem}", links.describe()]
    efficiency = f"{ways.mean:.0%} ({counted(len(ways.seconds), 'pair')})" if ways else "too little room"
    return Finding(
        METRICS,
        embedding,
        table(("metric", "value", "unit"), rows),
        numbers=(
            ("Position", f"{ground.position_share:.1%} ({ground.covered_area:.1f} m²)"),
            ("Position + Heading", f"{ground.task_share:.1%}"),
            ("Every Heading", f"{ground.full_area:.1f} m²"),
            ("Actions", f"{actions.shares.mean():.0%} of the floor"),
            ("Path Efficiency", efficiency),
            ("Maneuverability", f"{np.mean(waits):.2f} s to an action" if waits else "no action"),
            ("Turn Balance", f"{turns.total:+.2f} ({_leaning(turns.total)})"),
            ("Links Unused", f"{idle:,} of {len(links.links):,}"),
        ),
        sentences=tuple(said),
    )


def _leaning(balance: float) -> str:
    return "even" if abs(balance) < 0.05 else "left" if balance > 0 else "right"


def _actions(embedding: Embedding, actions: ActionCoverage, prompt: list[Maneuverability]) -> Finding:
    rows, lines = [], []
    for index in actions.ranked():
        action, wait = actions.actions[index], prompt[index]
        area, share = float(actions.areas[index]), float(actions.shares[index])
        rows.append((action.name, area, share, wait.mean, wait.worst, wait.at_once, wait.promptly))
        note = f"{wait.mean:.1f} s" if math.isfinite(wait.mean) else "never"
        can = f"Can begin on {area:.1f} m², {share:.0%} of the free floor."
        lines.append(Row(action.name, f"{share:.0%}", note, f"{can} {wait.describe()}", "ACTION"))
    columns = ("clip", "floor (m2)", "share", "mean wait (s)", "worst wait (s)", "at once", "within 1 s")
    return Finding(ACTIONS, embedding, table(columns, rows), rows=tuple(lines))


def _links(embedding: Embedding, links: LinkUtility) -> Finding:
    return Finding(LINKS, embedding, links_table(links), sentences=(links.describe(),))


def links_table(links: LinkUtility) -> Table:
    """Uses of each link of the motion graph, and the nodes that hang on it; most used first."""
    order = np.argsort(-links.link_uses, kind="stable").tolist()
    ends = links.links.tolist()
    rows = [
        (links.names[ends[i][0]], links.names[ends[i][1]], int(links.link_uses[i]), int(links.link_hanging[i]))
        for i in order
    ]
    return table(("from", "to", "uses", "nodes that die without it"), rows)
