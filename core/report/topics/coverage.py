"""Reach: coverage, variability (the paper's Fig. 1), and the links that the scene costs."""

from collections.abc import Generator

import numpy as np

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.environment_coverage import EnvironmentCoverage, environment_coverage
from ...evaluation.floor import floor_cells
from ...evaluation.variability import variability_steps
from ...evaluation.why_not import LostLinks, Reason, lost_links_steps, why_not_steps
from ...progress import Progress, finish, portion
from ..finding import Contribution, Finding, Questions, Topic
from ..floor_chart import amount_chart
from ..page import Figure, FigureRow, Paragraph, Section
from ..quantity import Options, Quantity, one_of
from ..table import Table, table


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    ways = (yield from portion(variability_steps(embedding), 0.0, 0.5)).sum(axis=2)
    lost = yield from portion(lost_links_steps(embedding), 0.5, 1.0)
    found = environment_coverage(embedding)
    sizes = _sizes(embedding, found, ways)
    blocked, ruled, used = (wording.share_of(n, lost.possible) for n in (lost.obstacles, lost.regions, lost.embedded))
    cost = (
        f"Of {wording.counted(lost.possible, 'link')} that an empty ground of this size would allow, obstacles block "
        f"{blocked} and rules of regions {ruled}; {used} are part of the embedding, the endless walks that can all be "
        "reached from one another."
    )
    return Finding(
        COVERAGE,
        embedding,
        sizes,
        sentences=(found.describe(), cost),
        contribute=lambda: _contribution(embedding, questions, found, ways, lost, sizes, cost),
    )


def _sizes(embedding: Embedding, found: EnvironmentCoverage, ways: np.ndarray) -> Table:
    graph = embedding.graph
    return table(
        ["what", "amount", "unit"],
        [
            ["free floor", found.free_area, "m2"],
            ["covered in any heading", found.covered_area, "m2"],
            ["covered in every heading", found.full_area, "m2"],
            ["coverage by position", found.position_share, "share"],
            ["coverage by position and heading", found.task_share, "share"],
            ["motion segments", len(graph.segments), ""],
            ["links of the motion graph", len(graph.links), ""],
            ["nodes of the embedding", embedding.n_nodes, ""],
            ["links of the embedding", embedding.n_links, ""],
            ["most ways through a cell", int(ways.max(initial=0)), ""],
        ],
    )


def _contribution(
    embedding: Embedding,
    questions: Questions,
    found: EnvironmentCoverage,
    ways: np.ndarray,
    lost: LostLinks,
    sizes: Table,
    cost: str,
) -> Contribution:
    scene, headings = questions.floor_scene(embedding), found.covered.sum(axis=2)
    most = float(embedding.environment.grid.n_headings)
    title = "Coverage: headings that a walk can pass in"
    coverage = amount_chart(scene, title, headings, "headings", lightest=most)
    variability = amount_chart(scene, "Variability: ways through", ways, "ways")
    captions = (
        "The lighter, the more of the headings the character can pass a place in.",
        "The lighter, the more pairs of a way in and a way out (the paper's equation 2, summed over headings).",
    )
    figures = FigureRow((Figure(coverage, captions[0]), Figure(variability, captions[1])))
    return Contribution(
        Section("What can it reach?", (Paragraph(found.describe()), figures, sizes, Paragraph(cost))),
        numbers={
            "free_m2": found.free_area,
            "covered_m2": found.covered_area,
            "fully_covered_m2": found.full_area,
            "position_share": found.position_share,
            "task_share": found.task_share,
            "segments": len(embedding.graph.segments),
            "graph_links": len(embedding.graph.links),
            "nodes": embedding.n_nodes,
            "links": embedding.n_links,
            "possible_links": lost.possible,
            "links_lost_to_obstacles": lost.obstacles,
            "links_lost_to_regions": lost.regions,
        },
        tables={"sizes": sizes},
        maps={"coverage": coverage, "variability": variability},
    )


def _lost(embedding: Embedding, _: Options) -> LostLinks:
    return finish(lost_links_steps(embedding))


def _reasons(embedding: Embedding, _: Options) -> tuple[np.ndarray, int]:
    """Count the places of each reason, and those of the free floor."""
    counts = np.bincount(finish(why_not_steps(embedding)).ravel(), minlength=len(Reason))
    return counts, int(np.count_nonzero(floor_cells(embedding))) * embedding.shape[2]


def _missing(found: tuple[np.ndarray, int], reason: str = "") -> float:
    counts, n_places = found
    # All that is embedded lies on the free floor; what can only be crossed does not, and counts only if asked for.
    n_missing = counts[Reason[reason.upper()]] if reason else n_places - counts[Reason.EMBEDDED]
    return int(n_missing) / max(n_places, 1)


def _lost_share(found: LostLinks) -> float:
    return (found.obstacles + found.regions) / max(found.possible, 1)


_NO_PLACES = (Reason.EMBEDDED, Reason.BLOCKED, Reason.NO_GROUND)
_REASON = one_of([reason.name.lower() for reason in Reason if reason not in _NO_PLACES])

COVERAGE = Topic(
    "COVERAGE",
    "Reach",
    _find_steps,
    section="reach",
    quantities={
        "missing": Quantity(
            "positions x headings not in the embedding, for any reason or one, against those of the free floor",
            _missing,
            find=_reasons,
            options={"reason": _REASON},
            own=("reason",),
        ),
        "possible_links": Quantity("one-step links of an empty ground", lambda found: found.possible, find=_lost),
        "obstacle_links": Quantity("one-step links that obstacles block", lambda found: found.obstacles, find=_lost),
        "region_links": Quantity("one-step links that regions forbid", lambda found: found.regions, find=_lost),
        "free_links": Quantity("one-step links that are left", lambda found: found.free, find=_lost),
        "blocked_links": Quantity(
            "share of the one-step links that obstacles and regions block", _lost_share, find=_lost
        ),
    },
)
