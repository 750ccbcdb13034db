"""What pruning costs, and the price of every k."""

from collections.abc import Generator

from ...core.embedding.embedding import Embedding
from ...core.progress import Progress
from ...core.report.table import table
from ...core.tuning.pruning_curve import PruningCurve, pruning_curve_steps
from ..pruning import Pruning
from ..render.maps.floor_map import short_number
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
            ("Floor", f"{before.floor:.1f} \u2192 {after.floor:.1f} m²"),
            ("Places", _change(before.places, after.places)),
        ),
        sentences=(f"{pruning.words}.", *pruning.sentences),
    )


def _change(before: int, after: int) -> str:
    return f"{short_number(before)} \u2192 {short_number(after)}"


def pruning_curve_finding_steps(whole: Embedding) -> Generator[Progress, None, Finding]:
    """Local pruning for every k: nodes, links and coverage."""
    curve = yield from pruning_curve_steps(whole)
    columns = ("k", "nodes", "links", "floor coverage", "coverage of floor and headings")
    arrays = (curve.k, curve.n_nodes, curve.n_links, curve.floor_coverage, curve.coverage)
    rows = list(zip(*(array.tolist() for array in arrays), strict=True))
    return Finding(PRUNING_CURVE, whole, table(columns, rows), numbers=_numbers(curve))


def _numbers(curve: PruningCurve) -> tuple[tuple[str, str], ...]:
    """The least k that keeps most of the floor, and what is left of the links then."""
    if not len(curve.k):
        return ()
    numbers = [("Largest", f"k {curve.k[-1]}")]
    for share in _SHARES:
        k = curve.smallest_k(share * float(curve.floor_coverage[-1]))
        if k is not None:
            links = int(curve.n_links[k - 1]) / max(int(curve.n_links[-1]), 1)
            numbers.append((f"{share:.0%} of the Floor", f"k {k}, {links:.0%} links"))
    return tuple(numbers)
