"""Numbers to compare by: the metrics of Reitsma & Pollard 2007, "Evaluating motion graphs for character animation"."""

import re
from collections.abc import Generator

import numpy as np

from ...embedding.embedding import Embedding
from ...evaluation.metrics import metrics_steps
from ...progress import Progress
from ..finding_tables import actions_table, metrics_table
from ..page import Bullets, Paragraph, Section
from .contribution import Contribution, Questions


def metrics_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Coverage, action coverage, path efficiency, local maneuverability, turns and links."""
    found = yield from metrics_steps(embedding, np.random.default_rng(questions.seed), questions.n_pairs)
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
