"""What matters? What is lost without each clip, what can be deleted, and what pruning costs."""

from collections.abc import Generator

from ... import wording
from ...embedding.embedding import Embedding
from ...errors import EvaluationError
from ...evaluation.ablation import Verdict, ablate_steps
from ...evaluation.deletion import deletable_together_steps
from ...evaluation.link_utility import link_utility
from ...evaluation.segment_groups import Grouping
from ...evaluation.size import mean_time_to
from ...progress import Progress, portion
from ...tuning.pruning_curve import pruning_curve_steps
from ..chart import Series, bar_chart, line_chart
from ..finding_tables import links_table, pruning_table
from ..page import Figure, FigureRow, Paragraph, Section
from ..table import Table, table
from .contribution import Contribution, Questions

_SHOWN = 12


def importance_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Ablation as ranked tables, and what can be deleted together."""
    kinds = list(Grouping) if questions.thorough else [Grouping.CLIP, Grouping.TAG]
    # Times to the goal are one more field for each part that is taken away.
    goal = questions.goal if questions.thorough else None
    objective = None if goal is None else mean_time_to(goal.nodes, goal.name)
    found = yield from portion(ablate_steps(embedding, kinds, objective), 0.0, 0.6)
    together = yield from portion(deletable_together_steps(embedding, questions.allowed_loss), 0.6, 1.0)
    tables = {f"ablation_{kind.value}s": table(*found.table(kind)) for kind in kinds}
    clips = sorted(found.ranked(Grouping.CLIP), key=lambda loss: -loss.places)[:_SHOWN]
    clips = [loss for loss in clips if loss.places > 0]
    figures, charts = [], {}
    if clips:
        shares = [100 * loss.places / found.before.places for loss in clips]
        chart = bar_chart("Lost without the clip", "% of places", [loss.group.name for loss in clips], shares)
        charts["ablation"] = chart
        figures.append(Figure(chart, "Positions and headings that nothing reaches any more without each clip."))
    summary, *_ = found.describe(Grouping.CLIP)
    tagged = [loss.describe() for loss in found.ranked(Grouping.TAG)]
    met = [verdict for verdict in Verdict if any(loss.verdict is verdict for loss in found.losses)]
    texts = [summary, *tagged, *together.describe(), "; ".join(verdict.value for verdict in met) + "."]
    shown = _first_rows(tables["ablation_clips"], _SHOWN)
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


def links_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Uses of the motion graph's links, and what hangs on them."""
    yield Progress(0.0, "Counting uses of links")
    found = link_utility(embedding)
    links = links_table(embedding, found)
    return Contribution(
        Section(
            "Which links work?", (Paragraph(found.describe()), _first_rows(links, _SHOWN if questions.thorough else 5))
        ),
        numbers={"idle_links": len(found.idle_links)},
        tables={"links": links},
    )


def pruning_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Local pruning for every k (the paper's section 4.2)."""
    curve = yield from pruning_curve_steps(embedding)
    if not len(curve.k):
        raise EvaluationError("The embedding is empty: there is nothing to prune.")
    size = line_chart(
        "What local pruning leaves",
        "segments kept at each place (k)",
        "% of all",
        [
            Series("nodes", curve.k, 100 * curve.n_nodes / max(embedding.n_nodes, 1)),
            Series("links", curve.k, 100 * curve.n_links / max(embedding.n_links, 1)),
            Series("floor", curve.k, 100 * curve.floor_coverage),
            Series("floor and headings", curve.k, 100 * curve.coverage),
        ],
    )
    numbers = pruning_table(curve)
    enough = curve.smallest_k(0.98 * float(curve.floor_coverage[-1])) if len(curve.k) else None
    if enough is None:
        text = "No k keeps 98% of the floor that is covered now."
    else:
        nodes, links = (wording.share_of(n[enough - 1], n[-1]) for n in (curve.n_nodes, curve.n_links))
        text = (
            f"Keeping the best {enough} of up to {wording.counted(int(curve.k[-1]), 'segment')} at each place keeps "
            f"98% of the covered floor, with {nodes} of the nodes and {links} of the links."
        )
    caption = "Nodes and links are shares of the embedding's, floor of the free floor."
    return Contribution(
        Section("How small can it be?", (Paragraph(text), Figure(size, caption))),
        numbers={"k_for_98_percent": enough},
        tables={"pruning": numbers},
        charts={"pruning": size},
    )


def _first_rows(whole: Table, n: int) -> Table:
    """The first rows; the others are in the file."""
    return Table(whole.columns, whole.rows[:n])
