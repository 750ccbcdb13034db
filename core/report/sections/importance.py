"""What matters? What is lost without each clip, what can be deleted, and what pruning costs."""

from collections.abc import Generator

from ...embedding.embedding import Embedding
from ...errors import EvaluationError
from ...evaluation.ablation import Kind, ablate_steps
from ...evaluation.deletion import deletable_together_steps
from ...evaluation.link_utility import link_utility
from ...progress import Progress, portion
from ...tuning.pruning_curve import pruning_curve_steps
from ..chart import Series, bar_chart, line_chart
from ..page import Figure, FigureRow, Paragraph, Section
from ..table import Table, table
from .contribution import Contribution, Questions

#: Share of the covered floor that deleting clips together may cost.
ALLOWED_LOSS = 0.02

_SHOWN = 12


def importance_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Ablation as ranked tables, and what can be deleted together."""
    kinds = list(Kind) if questions.thorough else [Kind.CLIP, Kind.TAG]
    found = yield from portion(ablate_steps(embedding, kinds), 0.0, 0.6)
    together = yield from portion(deletable_together_steps(embedding, ALLOWED_LOSS), 0.6, 1.0)
    tables = {f"ablation_{kind.value}s": table(*found.table(kind)) for kind in kinds}
    clips = sorted(found.ranked(Kind.CLIP), key=lambda loss: -loss.places)[:_SHOWN]
    clips = [loss for loss in clips if loss.places > 0]
    figures, charts = [], {}
    if clips:
        shares = [100 * loss.places / found.before.places for loss in clips]
        chart = bar_chart("Lost without the clip", "% of places", [loss.part.name for loss in clips], shares)
        charts["ablation"] = chart
        figures.append(Figure(chart, "Positions and headings that nothing reaches any more without each clip."))
    summary, *_ = found.describe(Kind.CLIP)
    tagged = [loss.describe() for loss in found.ranked(Kind.TAG)]
    texts = [summary, *tagged, *together.describe()]
    shown = _first_rows(tables["ablation_clips"], _SHOWN)
    return Contribution(
        Section("What matters?", (*map(Paragraph, texts), FigureRow(tuple(figures)), shown)),
        numbers={
            "verdicts": {loss.part.name: loss.verdict.name.lower() for loss in found.ranked(Kind.CLIP)},
            "deletable_together": [part.name for part in together.parts],
            "deletion_lost_share": together.share,
        },
        tables=tables,
        charts=charts,
    )


def links_section_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Uses of the motion graph's links, and what hangs on them."""
    yield Progress(0.0, "Counting uses of links")
    found = link_utility(embedding)
    order = sorted(range(len(found.links)), key=lambda i: (-found.link_hanging[i], -found.link_uses[i], i))
    rows = [
        [
            *(found.names[segment] for segment in found.links[i]),
            int(found.link_uses[i]),
            int(found.link_hanging[i]),
            float(embedding.graph.link_costs[i]),
        ]
        for i in order
    ]
    links = table(["from", "to", "uses", "nodes that hang on it", "cost (rad2)"], rows)
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
    rows = zip(
        *(a.tolist() for a in (curve.k, curve.n_nodes, curve.n_links, curve.floor_coverage, curve.coverage)),
        strict=True,
    )
    numbers = table(["k", "nodes", "links", "share of the floor", "share of floor and headings"], list(rows))
    enough = curve.smallest_k(0.98 * float(curve.floor_coverage[-1])) if len(curve.k) else None
    text = (
        "No k keeps 98 % of the floor that is covered now."
        if enough is None
        else (
            f"Keeping the best {enough} of up to {int(curve.k[-1])} segments at each place keeps 98 % of the floor, "
            f"with {100 * curve.n_nodes[enough - 1] / embedding.n_nodes:.0f} % of the nodes and "
            f"{100 * curve.n_links[enough - 1] / embedding.n_links:.0f} % of the links."
        )
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
