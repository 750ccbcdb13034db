"""Importance: losses without each clip, segment or tag, and clips that can all be deleted."""

from collections.abc import Generator

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.ablation import Ablation, Loss, Verdict, ablate_steps
from ...evaluation.deletion import JointDeletion, allowed_places, deletable_together_steps
from ...evaluation.segment_groups import Grouping
from ...evaluation.size import mean_time_to
from ...progress import Progress, finish, portion
from ..chart import bar_chart, bars
from ..drawing import Drawing
from ..finding import Contribution, Finding, Questions, Row, Topic
from ..page import Figure, FigureRow, Paragraph, Section
from ..quantity import KIND, SHARE, Options, Quantity, chosen_kind, one_of
from ..table import Table, table

_SHOWN = 12


def _ablation_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    kind = questions.parts
    found = yield from ablate_steps(embedding, (kind,))
    ranked = found.ranked(kind)
    counts = {verdict: sum(loss.verdict is verdict for loss in ranked) for verdict in Verdict}
    return Finding(
        ABLATION,
        embedding,
        table(*found.table(kind)),
        numbers=tuple((verdict.name.title(), wording.counted(n, kind.value)) for verdict, n in counts.items() if n),
        rows=tuple(map(_row, ranked)),
        sentences=tuple(found.describe(kind)),
    )


def _row(loss: Loss) -> Row:
    verdict = loss.verdict.name
    return Row(loss.group.name, wording.area(loss.floor), verdict.title(), loss.describe(), verdict.lower())


def _deletion_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    allowed = questions.allowed_loss
    found = yield from deletable_together_steps(embedding, allowed, Grouping.CLIP)
    whole, rows, lines = found.before.floor, [], []
    for number, (part, left) in enumerate(zip(found.groups, found.left_after, strict=True), start=1):
        lost = whole - left.floor
        rows.append((number, part.name, lost, lost / whole if whole else 0.0, left.nodes, left.links))
        lines.append(Row(part.name, wording.area(lost), sign="clip"))
    return Finding(
        DELETION,
        embedding,
        table(("order", "clip", "lost so far (m2)", "lost share", "nodes left", "links left"), rows),
        numbers=(
            ("Deletable", wording.counted(len(found.groups), "clip")),
            ("Floor Lost", f"{wording.area(whole - found.left.floor)} ({wording.share(found.share)})"),
            ("Places Lost", wording.share(found.places_share)),
            ("Allowed", f"{wording.share(allowed)}, {wording.share(allowed_places(allowed))}"),
        ),
        rows=tuple(lines),
        sentences=tuple(found.describe()),
    )


def _importance_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    kinds = list(Grouping) if questions.thorough else [Grouping.CLIP, Grouping.TAG]
    # Times to the goal are one more field for each part that is taken away.
    goal = questions.goal if questions.thorough else None
    objective = None if goal is None else mean_time_to(goal.nodes, goal.name)
    found = yield from portion(ablate_steps(embedding, kinds, objective), 0.0, 0.6)
    together = yield from portion(deletable_together_steps(embedding, questions.allowed_loss), 0.6, 1.0)
    summary, *_ = found.describe(Grouping.CLIP)
    tagged = [loss.describe() for loss in found.ranked(Grouping.TAG)]
    met = [verdict for verdict in Verdict if any(loss.verdict is verdict for loss in found.losses)]
    texts = (summary, *tagged, *together.describe(), "; ".join(verdict.value for verdict in met) + ".")
    tables = {f"ablation_{kind.value}s": table(*found.table(kind)) for kind in kinds}
    return Finding(
        IMPORTANCE,
        embedding,
        tables["ablation_clips"],
        sentences=texts,
        contribute=lambda: _contribution(found, together, texts, tables),
    )


def _contribution(
    found: Ablation, together: JointDeletion, texts: tuple[str, ...], tables: dict[str, Table]
) -> Contribution:
    clips = sorted(found.ranked(Grouping.CLIP), key=lambda loss: -loss.places)[:_SHOWN]
    clips = [loss for loss in clips if loss.places > 0]
    figures, charts = [], {}
    if clips:
        shares = [100 * loss.places / found.before.places for loss in clips]
        chart = bar_chart("Lost without the clip", "% of places", [loss.group.name for loss in clips], shares)
        charts["ablation"] = chart
        figures.append(Figure(chart, "Positions and headings that nothing reaches any more without each clip."))
    shown = tables["ablation_clips"].first(_SHOWN)
    return Contribution(
        Section("What matters?", (*map(Paragraph, texts), FigureRow(tuple(figures)), shown)),
        numbers={
            "verdicts": {loss.group.name: loss.verdict.name.lower() for loss in found.ranked(Grouping.CLIP)},
            "deletable_together": [part.name for part in together.groups],
            "deletion_lost_share": together.share,
        },
        tables=tables,
        charts=charts,
    )


def _ablation_chart(found: Table) -> Drawing:
    lost = [max(area, 0.0) for area in found.values(2)]
    return bars(f"Lost without the {found.texts(1)[0]}", "m²", found.texts(0), lost)


def _losses(embedding: Embedding, options: Options) -> Ablation:
    return finish(ablate_steps(embedding, (chosen_kind(options),)))


def _judged(found: Ablation, verdict: str) -> int:
    return sum(loss.verdict is Verdict[verdict.upper()] for loss in found.losses)


def _spare(embedding: Embedding, options: Options) -> JointDeletion:
    return finish(deletable_together_steps(embedding, float(options.get("allowed", 0.01)), chosen_kind(options)))


_KIND = {"kind": KIND}
_SPARE = {"kind": KIND, "allowed": SHARE}

ABLATION = Topic(
    "ABLATION",
    "What Matters",
    _ablation_steps,
    operator="ablate",
    button="Find What Matters",
    help="Take away each clip, segment or tag in turn and list what the character loses without it, in square metres",
    settings=("parts",),
    columns="Floor Lost Without It",
    chart=_ablation_chart,
    quantities={
        "greatest_loss": Quantity(
            "share of the floor that is lost with the action that matters most",
            lambda found: max((loss.share for loss in found.losses), default=0.0),
            find=_losses,
            options=_KIND,
        ),
        "greatest_places_loss": Quantity(
            "share of the positions x headings that is lost with one action, at most",
            lambda found: max((loss.places_share for loss in found.losses), default=0.0),
            find=_losses,
            options=_KIND,
        ),
        "judged_actions": Quantity(
            "actions of which a verdict says how much hangs on each by itself",
            _judged,
            find=_losses,
            options={"verdict": one_of([verdict.name.lower() for verdict in Verdict]), "kind": KIND},
            own=("verdict",),
            one_of=("verdict",),
        ),
    },
)

DELETION = Topic(
    "DELETION",
    "Deletable Clips",
    _deletion_steps,
    operator="find_deletable",
    button="Find Deletable Clips",
    help="List the clips that can all be deleted together without losing more of the floor than allowed",
    settings=("allowed_loss",),
    columns="Floor Lost, with Those Above",
    quantities={
        "spare_actions": Quantity(
            "actions that can all be deleted for a small share of the floor",
            lambda found: len(found.groups),
            find=_spare,
            options=_SPARE,
        ),
        "spare_loss": Quantity(
            "share of the floor that is lost without all of these",
            lambda found: found.share,
            find=_spare,
            options=_SPARE,
        ),
        "spare_places_loss": Quantity(
            "share of the positions x headings that is lost without them",
            lambda found: found.places_share,
            find=_spare,
            options=_SPARE,
        ),
    },
)

#: Both for clips and tags, in a report.
IMPORTANCE = Topic("IMPORTANCE", "What Matters", _importance_steps, section="importance", effort=15)
