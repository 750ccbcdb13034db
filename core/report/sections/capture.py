"""What is missing? Motions that nobody has captured, ranked by what they would open."""

from collections.abc import Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.capture.candidate import CandidateFamily, candidates
from ...evaluation.capture.director import direct_capture_steps
from ...progress import Progress
from ..chart import Swatch
from ..floor_chart import floor_chart
from ..page import Block, Bullets, Figure, Paragraph, Section
from ..table import Table, table
from .contribution import Contribution, Questions

_OPENED, _COVERED = (0.34, 0.71, 0.91), (0.80, 0.80, 0.79)
_QUICK = CandidateFamily(
    lengths=(0.0, 0.8), turns=tuple(np.radians([0, 45, -45, 90, -90]).tolist()), sidesteps=(0.4,), mirrored=False
)
_SHOWN = 8


def capture_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Sentences of the capture director, and a map of what the best motion would open."""
    tried = candidates(embedding) if questions.thorough else candidates(embedding, _QUICK)
    advice = yield from direct_capture_steps(embedding, tried)
    gains = table(*advice.table())
    sentences = advice.describe()
    family = len(candidates(embedding))
    lead = f"{wording.counted(len(tried), 'motion')} were tried, each alone and exactly, as if it had been captured"
    blocks: list[Block] = [
        Paragraph(f"{lead}; a thorough report tries {family}." if len(tried) < family else f"{lead}."),
        Bullets(tuple(sentences)),
    ]
    maps = {}
    best = advice.gains[0] if advice.gains else None
    if best is not None and best.floor > 0:
        colors = np.where(best.opened[..., None], _OPENED, _COVERED)
        legend = [Swatch(_OPENED, "opened by it"), Swatch(_COVERED, "reached already")]
        present = best.opened | embedding.covered().any(axis=2)
        scene = questions.floor_scene(embedding)
        maps["capture"] = floor_chart(
            scene, "What the best new motion opens", colors, present, legend, "still not reached"
        )
        blocks.append(Figure(maps["capture"], best.describe()))
    blocks.append(Table(gains.columns, gains.rows[:_SHOWN]))
    return Contribution(
        Section("What is missing?", tuple(blocks)),
        numbers={"capture": sentences, "motions_tried": len(tried)},
        tables={"capture": gains},
        maps=maps,
    )
