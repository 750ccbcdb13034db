"""Pruning: the price of every size, and what it has cost (the paper's section 4.2)."""

from collections.abc import Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...errors import EvaluationError
from ...progress import Progress
from ...tuning.pruning import Pruning
from ...tuning.pruning_curve import PruningCurve, pruning_curve_steps
from ..chart import WIDE, Series, line_chart
from ..drawing import Drawing
from ..finding import Contribution, Finding, Questions, Topic
from ..page import Figure, Paragraph, Section
from ..table import Table, table

_SHARES = (1.0, 0.99, 0.9)
"""Shares of the covered floor, each with the least k that keeps it."""


def pruning_finding(pruning: Pruning) -> Finding:
    """Compare an embedding with what pruning left of it."""
    before, after = pruning.before, pruning.after
    rows = [
        ("nodes", before.nodes, after.nodes),
        ("links", before.links, after.links),
        ("covered floor (m2)", before.floor, after.floor),
        ("covered share of the free floor", before.share, after.share),
        ("covered positions and headings", before.places, after.places),
    ]
    return Finding(
        PRUNING,
        pruning.whole,
        table(("number", "before", "after"), rows),
        numbers=(
            ("Nodes", _change(before.nodes, after.nodes)),
            ("Links", _change(before.links, after.links)),
            ("Floor", f"{wording.amount(before.floor)} \u2192 {wording.area(after.floor)}"),
            ("Places", _change(before.places, after.places)),
        ),
        sentences=(f"{pruning.words}.", *pruning.sentences),
    )


def _change(before: int, after: int) -> str:
    return f"{wording.short(before)} \u2192 {wording.short(after)}"


def _curve_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    curve = yield from pruning_curve_steps(embedding)
    if not len(curve.k):
        raise EvaluationError("The embedding is empty: there is nothing to prune.")
    most, prices = wording.counted(int(curve.k[-1]), "segment"), _prices(curve)
    said = "; ".join(
        f"k = {k} keeps {wording.exact_share(share)} of it with {links} of the links" for share, k, links in prices
    )
    kept = [(f"Keep {wording.exact_share(share)} of Floor", f"k {k}, {links} of links") for share, k, links in prices]
    sizes = _table(curve)
    return Finding(
        PRUNING_CURVE,
        embedding,
        sizes,
        numbers=(("Most at a Place", most), *kept),
        sentences=(f"Up to {most} end at a place of the covered floor: {said}.",),
        contribute=lambda: _contribution(curve, sizes),
    )


def _table(curve: PruningCurve) -> Table:
    """Build a row for each k."""
    arrays = (curve.k, curve.n_nodes, curve.n_links, curve.floor_coverage, curve.coverage)
    columns = ("k", "nodes", "links", "share of the floor", "share of floor and headings")
    return table(columns, list(zip(*(array.tolist() for array in arrays), strict=True)))


def _prices(curve: PruningCurve) -> list[tuple[float, int, str]]:
    """Return shares of the covered floor, the least k that keeps each, and the share of the links left then."""
    prices = []
    for share in _SHARES:
        k = curve.smallest_k(share * float(curve.floor_coverage[-1]))
        if k is not None:
            prices.append((share, k, wording.share_of(int(curve.n_links[k - 1]), int(curve.n_links[-1]))))
    return prices


def _contribution(curve: PruningCurve, sizes: Table) -> Contribution:
    enough = curve.smallest_k(0.98 * float(curve.floor_coverage[-1]))
    if enough is None:
        text = "No k keeps 98% of the floor that is covered now."
    else:
        nodes, links = (wording.share_of(n[enough - 1], n[-1]) for n in (curve.n_nodes, curve.n_links))
        text = (
            f"Keeping the best {enough} of up to {wording.counted(int(curve.k[-1]), 'segment')} at each place keeps "
            f"98% of the covered floor, with {nodes} of the nodes and {links} of the links."
        )
    chart = _chart(sizes)
    caption = "Nodes and links are shares of the embedding's, floor of the free floor."
    return Contribution(
        Section("How small can it be?", (Paragraph(text), Figure(chart, caption))),
        numbers={"k_for_98_percent": enough},
        tables={"pruning": sizes},
        charts={"pruning": chart},
    )


def _chart(found: Table) -> Drawing:
    k, nodes, links, floor, places = np.array(found.rows, dtype=float).T
    return line_chart(
        "What local pruning leaves",
        "segments kept at each place (k)",
        "% of all",
        [
            Series("floor", k, 100 * floor),
            Series("floor and headings", k, 100 * places),
            Series("nodes", k, 100 * nodes / max(nodes[-1], 1)),
            Series("links", k, 100 * links / max(links[-1], 1)),
        ],
        width=WIDE,
    )


PRUNING = Topic("PRUNING", "Pruning", of_whole=True)

PRUNING_CURVE = Topic(
    "PRUNING_CURVE",
    "Pruning Curve",
    _curve_steps,
    operator="sweep_pruning",
    button="Sweep K",
    help="Prune locally with every number of segments per place, and draw what is left of nodes, links and floor on a "
    "page in the browser. The embedding stays as it is",
    part="Price of Pruning",
    of_whole=True,
    chart=_chart,
    section="pruning",
    effort=10,
)
