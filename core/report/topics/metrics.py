"""Numbers to compare by: the metrics of Reitsma & Pollard 2007, "Evaluating motion graphs for character animation"."""

import math
import re
from collections.abc import Callable, Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...errors import EvaluationError
from ...evaluation.action_coverage import ActionCoverage, action_coverage
from ...evaluation.maneuverability import PROMPT, Maneuverability, maneuverabilities_steps, maneuverability_steps
from ...evaluation.metrics import Metrics, metrics_steps
from ...evaluation.path_efficiency import PathEfficiency, path_efficiency_steps
from ...evaluation.segment_groups import Grouping, SegmentGroup, segment_groups
from ...progress import Progress, finish
from ..chart import bars
from ..drawing import Drawing
from ..finding import Contribution, Finding, Questions, Row, Topic
from ..page import Bullets, Paragraph, Section
from ..quantity import COUNT, KIND, NATURAL, TEXT, Options, Quantity, chosen_kind
from ..table import Table, table
from .links import links_finding


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    """Measure an embedding, its actions (clips) and its links."""
    found = yield from metrics_steps(embedding, np.random.default_rng(questions.seed), questions.n_pairs)
    actions = Finding(ACTIONS, embedding, actions_table(found), rows=tuple(_action_rows(found)))
    return Finding(
        METRICS,
        embedding,
        metrics_table(found),
        numbers=tuple(_numbers(found)),
        sentences=tuple(found.describe()),
        contribute=lambda: _contribution(found),
        also=(actions, links_finding(embedding, found.links)),
    )


def metrics_table(found: Metrics) -> Table:
    """Build a row for each number."""
    return table(("metric", "value", "unit"), found.rows())


def actions_table(found: Metrics) -> Table:
    """Tabulate where and how soon each clip can begin, least floor first."""
    rows = []
    for index in found.actions.ranked():
        action, wait = found.actions.actions[index], found.prompt[index]
        area, share = float(found.actions.areas[index]), float(found.actions.shares[index])
        rows.append((action.name, area, share, wait.mean, wait.worst, wait.at_once, wait.promptly))
    columns = ("clip", "can begin on (m2)", "share of the free floor", "mean wait (s)", "worst wait (s)")
    return table((*columns, "share of nodes at once", f"share of nodes within {wording.exact(PROMPT)} s"), rows)


def _numbers(found: Metrics) -> list[tuple[str, str]]:
    ground, ways, turns = found.ground, found.ways, found.turns.total
    efficiency = [("Path Efficiency", "too little room")]
    if ways:
        efficiency = [("Path Efficiency", ways.mean_in_words), ("Sampled", ways.sample)]
    wait = "never" if math.isinf(found.mean_wait) else f"{wording.time(found.mean_wait)} to a clip"
    leaning = "even" if abs(turns) < 0.05 else "left" if turns > 0 else "right"
    return [
        ("Position", f"{wording.share(ground.position_share)} ({wording.area(ground.covered_area)})"),
        ("Position + Heading", wording.share(ground.task_share)),
        ("Every Heading", wording.area(ground.full_area)),
        ("Actions", f"{wording.share(float(found.actions.shares.mean()))} of the floor"),
        *efficiency,
        ("Maneuverability", wait),
        ("Turn Balance", f"{wording.balance(turns)} ({leaning})"),
        ("Links Unused", wording.of(len(found.links.idle_links), len(found.links.links))),
    ]


def _action_rows(found: Metrics) -> Generator[Row, None, None]:
    for index in found.actions.ranked():
        action, wait = found.actions.actions[index], found.prompt[index]
        area, share = wording.area(float(found.actions.areas[index])), wording.share(float(found.actions.shares[index]))
        sentence = f"Can begin on {area}, {share} of the free floor. {wait.describe()}"
        yield Row(action.name, share, wording.time(wait.mean), sentence, "clip")


def _contribution(found: Metrics) -> Contribution:
    lead = (
        "The metrics of Reitsma and Pollard (2007) describe how well the motions suit the scene; they are made to "
        "compare other clips in this scene, or these clips in other scenes."
    )
    numbers, by_clip = metrics_table(found), actions_table(found)
    return Contribution(
        Section("Numbers to compare by", (Paragraph(lead), Bullets(tuple(found.describe())), numbers, by_clip)),
        numbers={_key(name): value for name, value, _ in found.rows()},
        tables={"metrics": numbers, "actions": by_clip},
    )


def _key(name: str) -> str:
    """ "path_efficiency_mean" of "path efficiency, mean"."""
    return "_".join(re.findall(r"[a-z0-9]+", name.partition(" (")[0]))


def _actions_chart(found: Table) -> Drawing:
    clips = sorted(zip(found.texts(0), found.values(2), strict=True), key=lambda row: -row[1])
    return bars("Where clips can begin", "% of the floor", [clip for clip, _ in clips], [100 * x for _, x in clips])


# -------------------------------------------------------------------------------------------------- quantities


def _begins(embedding: Embedding, options: Options) -> ActionCoverage:
    return action_coverage(embedding, chosen_kind(options))


def _named_action(embedding: Embedding, options: Options) -> SegmentGroup | None:
    """Return the tag or clip that the options name; None if they name neither."""
    for kind in (Grouping.TAG, Grouping.CLIP):
        if kind.value in options:
            found = {part.name: part for part in segment_groups(embedding.graph, kind)}
            if options[kind.value] not in found:
                known = ", ".join(f"'{name}'" for name in found) or "none"
                raise EvaluationError(
                    f"The motion graph has no {kind.value} '{options[kind.value]}' (it has: {known})."
                )
            return found[options[kind.value]]
    return None


def _waits(embedding: Embedding, options: Options) -> list[Maneuverability]:
    """Return that of the action that the options name, possible or not, or those of all that are possible."""
    named = _named_action(embedding, options)
    if named is not None:
        return [finish(maneuverability_steps(embedding, named))]
    waits = finish(maneuverabilities_steps(embedding, chosen_kind(options)))
    return [wait for wait in waits if math.isfinite(wait.mean)]


def _wait_quantity(meaning: str, attribute: str, unit: str = "", reduce: Callable[..., float] = np.mean) -> Quantity:
    def number(waits: list[Maneuverability]) -> float:
        return float(reduce([getattr(wait, attribute) for wait in waits])) if waits else math.nan

    options = {"kind": KIND, "tag": TEXT, "clip": TEXT}
    return Quantity(meaning, number, unit, _waits, options, at_most_one=tuple(options))


def _ways(embedding: Embedding, options: Options) -> PathEfficiency:
    rng = np.random.default_rng(options.get("seed", 0))
    return finish(path_efficiency_steps(embedding, rng, options.get("pairs", 100), options.get("goals", 20)))


_PAIRS = {"pairs": COUNT, "goals": COUNT, "seed": NATURAL}

METRICS = Topic(
    "METRICS",
    "Metrics",
    _find_steps,
    operator="measure",
    button="Measure",
    help="Coverage of the floor and of the clips, turns to the left and right, how direct the ways are, how soon each "
    "clip can begin, and which links are used (metrics of Reitsma and Pollard, 2007)",
    settings=("n_pairs", "seed"),
    section="metrics",
    effort=12,
    quantities={
        "path_efficiency": Quantity(
            "shortest ways against the quickest ones, mean", lambda found: found.mean, find=_ways, options=_PAIRS
        ),
        "path_efficiency_error": Quantity(
            "standard error of that mean", lambda found: found.standard_error, find=_ways, options=_PAIRS
        ),
        "median_path_efficiency": Quantity(
            "shortest ways against the quickest ones, median",
            lambda found: float(np.median(found.efficiency)),
            find=_ways,
            options=_PAIRS,
        ),
        "worst_path_efficiency": Quantity(
            "shortest ways against the quickest ones, worst",
            lambda found: float(found.efficiency.min()),
            find=_ways,
            options=_PAIRS,
        ),
    },
)

ACTIONS = Topic(
    "ACTIONS",
    "Actions",
    part="Clips in Numbers",
    columns="Can Begin On, After on Average",
    chart=_actions_chart,
    quantities={
        "action_coverage": Quantity(
            "share of the free floor on which an action can begin, mean over the actions",
            lambda found: float(found.shares.mean()),
            find=_begins,
            options={"kind": KIND},
        ),
        "least_action_coverage": Quantity(
            "the same of the action that can begin least",
            lambda found: float(found.shares.min(initial=1.0)),
            find=_begins,
            options={"kind": KIND},
        ),
        "idle_actions": Quantity(
            "actions that can begin nowhere",
            lambda found: int(np.count_nonzero(found.areas == 0)),
            find=_begins,
            options={"kind": KIND},
        ),
        "maneuverability": _wait_quantity(
            "time until an action can begin, mean over those that can at all", "mean", "s"
        ),
        "worst_maneuverability": _wait_quantity("time until an action can begin, longest", "worst", "s", max),
        "at_once": _wait_quantity(
            "share of the nodes from which an action can begin at once, mean over the actions", "at_once"
        ),
        "promptly": _wait_quantity("share of the nodes from which it can begin within a second", "promptly"),
    },
)
