"""What can it reach? Coverage and variability (the paper's Fig. 1)."""

from collections.abc import Generator

from ... import wording
from ...embedding.embedding import Embedding
from ...evaluation.environment_coverage import environment_coverage
from ...evaluation.variability import variability_steps
from ...evaluation.why_not import lost_links_steps
from ...progress import Progress, portion
from ..floor_chart import amount_chart
from ..page import Figure, FigureRow, Paragraph, Section
from ..table import table
from .contribution import Contribution, Questions


def reach_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Contribution]:
    """Coverage, variability, and what obstacles and regions cost."""
    ways = (yield from portion(variability_steps(embedding), 0.0, 0.5)).sum(axis=2)
    lost = yield from portion(lost_links_steps(embedding), 0.5, 1.0)
    found, scene = environment_coverage(embedding), questions.floor_scene(embedding)
    grid, graph = embedding.environment.grid, embedding.graph
    headings = found.covered.sum(axis=2)
    coverage = amount_chart(
        scene, "Coverage: headings that a walk can pass in", headings, "headings", lightest=float(grid.n_headings)
    )
    variability = amount_chart(scene, "Variability: ways through", ways, "ways")
    sizes = table(
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
    blocked, ruled, used = (wording.share_of(n, lost.possible) for n in (lost.obstacles, lost.regions, lost.embedded))
    cost = (
        f"Of {wording.counted(lost.possible, 'link')} that an empty ground of this size would allow, obstacles block "
        f"{blocked} and rules of regions {ruled}; {used} are part of the embedding, the endless walks that can all be "
        "reached from one another."
    )
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
            "segments": len(graph.segments),
            "graph_links": len(graph.links),
            "nodes": embedding.n_nodes,
            "links": embedding.n_links,
            "possible_links": lost.possible,
            "links_lost_to_obstacles": lost.obstacles,
            "links_lost_to_regions": lost.regions,
        },
        tables={"sizes": sizes},
        maps={"coverage": coverage, "variability": variability},
    )
