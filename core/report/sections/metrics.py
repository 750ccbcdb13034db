"""The metrics of Reitsma & Pollard 2007, "Evaluating motion graphs for character animation"."""

from collections.abc import Generator

import numpy as np

from ...embedding.embedding import Embedding
from ...evaluation.ablation import Kind
from ...evaluation.action_coverage import action_coverage
from ...evaluation.environment_coverage import environment_coverage
from ...evaluation.maneuverability import PROMPT, maneuverabilities_steps
from ...evaluation.path_efficiency import path_efficiency_steps
from ...progress import Progress, portion
from ..page import Bullets, Section
from ..table import table
from .contribution import Contribution, Questions


def metrics_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Coverage, action coverage, path efficiency and local maneuverability."""
    n_pairs, n_goals = (100, 20) if questions.thorough else (24, 4)
    rng = np.random.default_rng(questions.seed)
    paths = yield from portion(path_efficiency_steps(embedding, rng, n_pairs, n_goals), 0.0, 0.4)
    soon = yield from portion(maneuverabilities_steps(embedding, Kind.CLIP), 0.4, 1.0)
    space, actions = environment_coverage(embedding), action_coverage(embedding, Kind.CLIP)
    waits = [wait.mean for wait in soon if np.isfinite(wait.mean)]
    rows = [
        ["environment coverage by position", 100 * space.position_share, "%"],
        ["environment coverage by position and heading", 100 * space.task_share, "%"],
        ["action coverage, mean over clips", 100 * float(actions.shares.mean()), "%"],
        ["path efficiency, mean", 100 * paths.mean, "%"],
        ["path efficiency, median", 100 * float(np.median(paths.efficiency)), "%"],
        ["local maneuverability, mean over clips", float(np.mean(waits)) if waits else None, "s"],
    ]
    metrics = table(["metric", "value", "unit"], rows)
    by_clip = table(
        ["clip", "can begin on (m2)", "share of the floor", "mean wait (s)", "worst wait (s)", f"within {PROMPT:g} s"],
        [
            [action.name, float(area), float(share), wait.mean, wait.worst, wait.promptly]
            for action, area, share, wait in zip(actions.actions, actions.areas, actions.shares, soon, strict=True)
        ],
    )
    slowest = max(soon, key=lambda wait: wait.mean)
    texts = (space.describe(), actions.describe(), paths.describe(), slowest.describe())
    return Contribution(
        Section("How does it compare? Metrics of 2007", (Bullets(texts), metrics)),
        numbers={name.replace(",", "").replace(" ", "_"): value for name, value, _ in rows},
        tables={"metrics": metrics, "actions": by_clip},
    )
