"""Missing motions: what nobody has captured, ranked by the floor that it would open."""

from collections.abc import Generator, Sequence

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.capture.candidate import Candidate, CandidateFamily, candidates
from ...evaluation.capture.director import CaptureAdvice, Gain, direct_capture_steps
from ...maps.legend import Swatch
from ...progress import Progress, finish
from ..chart import bars
from ..drawing import Drawing
from ..finding import Contribution, Finding, Questions, Row, Topic
from ..floor_chart import floor_chart
from ..page import Block, Bullets, Figure, Paragraph, Section
from ..quantity import Options, Quantity
from ..table import Table, table

_OPENED, _COVERED = (0.34, 0.71, 0.91), (0.80, 0.80, 0.79)
_QUICK = CandidateFamily(
    lengths=(0.0, 0.8), turns=tuple(np.radians([0, 45, -45, 90, -90]).tolist()), sidesteps=(0.4,), mirrored=False
)
_SHOWN = 8


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    family = candidates(embedding)
    if questions.n_candidates is not None:
        tried = evenly_chosen(family, questions.n_candidates)
    else:
        tried = family if questions.thorough else candidates(embedding, _QUICK)
    found = yield from direct_capture_steps(embedding, tried)
    useful = [gain for gain in found.gains if gain.floor > 0 or gain.places > 0]
    gains = table(*found.table())
    return Finding(
        CAPTURE,
        embedding,
        gains,
        numbers=(
            ("Tried", f"{wording.number(len(tried))} of {wording.counted(len(family), 'motion')}"),
            ("Would Help", str(len(useful))),
            ("Best Opens", wording.area(useful[0].floor) if useful else "nothing"),
        ),
        rows=tuple(_row(embedding, gain) for gain in useful),
        sentences=tuple(found.describe(len(found.gains))),
        contribute=lambda: _contribution(embedding, questions, found, len(tried), len(family), gains),
    )


def evenly_chosen(family: Sequence[Candidate], n: int) -> list[Candidate]:
    """Return up to ``n`` candidates, spread evenly over the family if that is larger."""
    if len(family) <= n:
        return list(family)
    return [family[i] for i in np.linspace(0, len(family) - 1, n).round().astype(int).tolist()]


def _row(embedding: Embedding, gain: Gain) -> Row:
    words, opened = gain.candidate.words, np.argwhere(gain.opened)
    place = None
    if len(opened):
        # The opened cell that is nearest to the middle of all of them.
        nearest = opened[np.argmin(np.linalg.norm(opened - opened.mean(axis=0), axis=1))]
        x, y = embedding.environment.grid.positions(nearest).tolist()
        place = (x, y)
    value, across = f"+{wording.area(gain.floor)}", float(np.sqrt(gain.floor))
    return Row(words[0].upper() + words[1:], value, "", gain.describe(), "new", place, across)


def _contribution(
    embedding: Embedding, questions: Questions, advice: CaptureAdvice, n_tried: int, n_family: int, gains: Table
) -> Contribution:
    sentences = advice.describe()
    lead = f"{wording.counted(n_tried, 'motion')} were tried, each alone and exactly, as if it had been captured"
    blocks: list[Block] = [
        Paragraph(f"{lead}; a thorough report tries {n_family}." if n_tried < n_family else f"{lead}."),
        Bullets(tuple(sentences)),
    ]
    maps = {}
    best = advice.gains[0] if advice.gains else None
    if best is not None and best.floor > 0:
        colors = np.where(best.opened[..., None], _OPENED, _COVERED)
        legend = [Swatch(_OPENED, "opened by it"), Swatch(_COVERED, "reached already")]
        present = best.opened | embedding.covered().any(axis=2)
        title = "What the best new motion opens"
        scene = questions.floor_scene(embedding)
        maps["capture"] = floor_chart(scene, title, colors, present, legend, "still not reached")
        blocks.append(Figure(maps["capture"], best.describe()))
    blocks.append(gains.first(_SHOWN))
    return Contribution(
        Section("What is missing?", tuple(blocks)),
        numbers={"capture": sentences, "motions_tried": n_tried},
        tables={"capture": gains},
        maps=maps,
    )


def _chart(found: Table) -> Drawing:
    opened, unit = found.values(4), "m²"
    if max(opened) <= 0:
        opened, unit = found.values(5), "positions and headings"
    return bars("What one more motion would open", unit, found.texts(0), opened)


def _advice(embedding: Embedding, _: Options) -> CaptureAdvice:
    return finish(direct_capture_steps(embedding))


CAPTURE = Topic(
    "CAPTURE",
    "What Is Missing",
    _find_steps,
    operator="direct_capture",
    button="Find What Is Missing",
    help="Try steps, turns and mirror images that nobody has recorded, one at a time, and list those that would open "
    "floor or headings that the character cannot reach now",
    settings=("n_candidates",),
    columns="Floor Gained",
    of_whole=True,
    # That is when most is missing.
    of_empty=True,
    chart=_chart,
    section="capture",
    effort=15,
    quantities={
        "capture_area": Quantity(
            "floor that the one motion to capture next would open",
            lambda found: max((gain.floor for gain in found.gains), default=0.0),
            "m2",
            find=_advice,
        ),
        "capture_places": Quantity(
            "positions x headings that it would open at most",
            lambda found: max((gain.places for gain in found.gains), default=0),
            find=_advice,
        ),
        "capture_motions": Quantity(
            "motions of those tried that would open any floor",
            lambda found: sum(gain.floor > 0 for gain in found.gains),
            find=_advice,
        ),
    },
)
