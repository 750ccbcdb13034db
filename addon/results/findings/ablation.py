"""What matters: what is lost without each segment, clip or tag, and which clips can all be deleted."""

from collections.abc import Generator

from ....core import wording
from ....core.embedding.embedding import Embedding
from ....core.evaluation.ablation import Loss, Verdict, ablate_steps
from ....core.evaluation.deletion import allowed_places, deletable_together_steps
from ....core.evaluation.segment_groups import Grouping
from ....core.progress import Progress
from ....core.report.table import table
from ...bridge.text import counted
from .finding import ABLATION, DELETION, Finding, Row

_ICONS = {
    Verdict.ESSENTIAL: "CANCEL",
    Verdict.IMPORTANT: "ERROR",
    Verdict.USEFUL: "CHECKMARK",
    Verdict.SPARE: "REMOVE",
    Verdict.REDUNDANT: "TRASH",
}


def ablation_finding_steps(embedding: Embedding, kind: Grouping) -> Generator[Progress, None, Finding]:
    """What is lost without each part of one kind, the greatest loss first."""
    found = yield from ablate_steps(embedding, (kind,))
    columns, rows = found.table(kind)
    ranked = found.ranked(kind)
    counts = {verdict: sum(loss.verdict is verdict for loss in ranked) for verdict in Verdict}
    return Finding(
        ABLATION,
        embedding,
        table(columns, rows),
        numbers=tuple((verdict.name.title(), counted(n, kind.value)) for verdict, n in counts.items() if n),
        rows=tuple(_row(loss) for loss in ranked),
        sentences=tuple(found.describe(kind)),
    )


def _row(loss: Loss) -> Row:
    return Row(
        loss.group.name, wording.area(loss.floor), loss.verdict.name.title(), loss.describe(), _ICONS[loss.verdict]
    )


def deletion_finding_steps(embedding: Embedding, allowed: float) -> Generator[Progress, None, Finding]:
    """The clips that can all be deleted while the covered floor shrinks by at most the share ``allowed``, and its
    positions and headings by at most :func:`allowed_places`."""
    found = yield from deletable_together_steps(embedding, allowed, Grouping.CLIP)
    whole, rows, lines = found.before.floor, [], []
    for number, (part, left) in enumerate(zip(found.groups, found.left_after, strict=True), start=1):
        lost = whole - left.floor
        rows.append((number, part.name, lost, lost / whole if whole else 0.0, left.nodes, left.links))
        lines.append(Row(part.name, wording.area(lost), icon="ACTION"))
    columns = ("order", "clip", "lost so far (m2)", "lost share", "nodes left", "links left")
    return Finding(
        DELETION,
        embedding,
        table(columns, rows),
        numbers=(
            ("Deletable", counted(len(found.groups), "clip")),
            ("Floor Lost", f"{wording.area(whole - found.left.floor)} ({wording.share(found.share)})"),
            ("Places Lost", wording.share(found.places_share)),
            ("Allowed", f"{wording.share(allowed)}, {wording.share(allowed_places(allowed))}"),
        ),
        rows=tuple(lines),
        sentences=tuple(found.describe()),
    )
