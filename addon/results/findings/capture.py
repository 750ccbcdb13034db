"""What is missing: motions that nobody has recorded, ranked by what they would open."""

from collections.abc import Generator

import numpy as np

from ....core import wording
from ....core.embedding.embedding import Embedding
from ....core.evaluation.capture.candidate import Candidate, candidates
from ....core.evaluation.capture.director import Gain, direct_capture_steps
from ....core.progress import Progress
from ....core.report.table import table
from ...bridge.text import counted
from .finding import CAPTURE, Finding, Row


def capture_finding_steps(embedding: Embedding, n_candidates: int) -> Generator[Progress, None, Finding]:
    """Try up to ``n_candidates`` motions on an embedding that was not pruned; those that open most come first."""
    tried, n_known = chosen_candidates(embedding, n_candidates), len(candidates(embedding))
    found = yield from direct_capture_steps(embedding, tried)
    useful = [gain for gain in found.gains if gain.floor > 0 or gain.places > 0]
    columns, rows = found.table()
    best = wording.area(useful[0].floor) if useful else "nothing"
    return Finding(
        CAPTURE,
        embedding,
        table(columns, rows),
        numbers=(
            ("Tried", f"{wording.number(len(tried))} of {counted(n_known, 'motion')}"),
            ("Would Help", str(len(useful))),
            ("Best Opens", best),
        ),
        rows=tuple(_row(embedding, gain) for gain in useful),
        sentences=tuple(found.describe(len(found.gains))),
    )


def chosen_candidates(embedding: Embedding, n_candidates: int) -> list[Candidate]:
    """Up to so many of the core's candidates, spread evenly over the family if that is larger."""
    family = candidates(embedding)
    if len(family) <= n_candidates:
        return family
    return [family[i] for i in np.linspace(0, len(family) - 1, n_candidates).round().astype(int).tolist()]


def _row(embedding: Embedding, gain: Gain) -> Row:
    words = gain.candidate.words
    value = f"+{wording.area(gain.floor)}"
    across, place = float(np.sqrt(gain.floor)), _place(embedding, gain)
    return Row(words[0].upper() + words[1:], value, "", gain.describe(), "ADD", place, across)


def _place(embedding: Embedding, gain: Gain) -> tuple[float, float] | None:
    """The opened cell that is nearest to the middle of all of them (m); None if only headings are opened."""
    opened = np.argwhere(gain.opened)
    if not len(opened):
        return None
    nearest = opened[np.argmin(np.linalg.norm(opened - opened.mean(axis=0), axis=1))]
    x, y = embedding.environment.grid.positions(nearest).tolist()
    return x, y
