"""What pruning costs, and the price of every k."""

from collections.abc import Generator

from ....core import wording
from ....core.embedding.embedding import Embedding
from ....core.progress import Progress
from ....core.report.finding_tables import pruning_table
from ....core.report.table import table
from ....core.tuning.pruning import Pruning
from ....core.tuning.pruning_curve import PruningCurve, pruning_curve_steps
from ...bridge.text import counted
from .finding import PRUNING, PRUNING_CURVE, Finding

_SHARES = (1.0, 0.99, 0.9)
"""Of the covered floor, for which the least k is told."""


def pruning_finding(pruning: Pruning) -> Finding:
    """The numbers before and after."""
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


def pruning_curve_finding_steps(whole: Embedding) -> Generator[Progress, None, Finding]:
    """Local pruning for every k: nodes, links and coverage."""
    curve = yield from pruning_curve_steps(whole)
    return Finding(PRUNING_CURVE, whole, pruning_table(curve), numbers=_numbers(curve), sentences=_sentences(curve))


def _numbers(curve: PruningCurve) -> tuple[tuple[str, str], ...]:
    """The least k that keeps most of the floor, and what is left of the links then."""
    if not len(curve.k):
        return ()
    numbers = [("Most at a Place", counted(int(curve.k[-1]), "segment"))]
    return (
        *numbers,
        *(
            (f"Keep {wording.exact_share(share)} of Floor", f"k {k}, {links} of links")
            for share, k, links in _prices(curve)
        ),
    )


def _prices(curve: PruningCurve) -> list[tuple[float, int, str]]:
    """Shares of the covered floor, the least k that keeps each, and the share of the links that are left then."""
    prices = []
    for share in _SHARES if len(curve.k) else ():
        k = curve.smallest_k(share * float(curve.floor_coverage[-1]))
        if k is not None:
            prices.append((share, k, wording.share_of(int(curve.n_links[k - 1]), int(curve.n_links[-1]))))
    return prices


def _sentences(curve: PruningCurve) -> tuple[str, ...]:
    if not len(curve.k):
        return ("The embedding is empty: there is nothing to prune.",)
    prices = "; ".join(
        f"k = {k} keeps {wording.exact_share(share)} of it with {links} of the links"
        for share, k, links in _prices(curve)
    )
    return (f"Up to {counted(int(curve.k[-1]), 'segment')} end at a place of the covered floor: {prices}.",)
