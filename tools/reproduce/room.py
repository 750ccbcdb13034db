"""Fig. 1: the cluttered room, with and without the step; where the differences from the paper's numbers come from."""

from dataclasses import dataclass

import numpy as np

from ...addon.sample.layouts import STEP_MARGIN
from ...core import wording
from ...core.embedding.embedding import Embedding, EmbeddingSettings
from ...core.embedding.footprint import FootprintSettings
from ...core.evaluation.environment_coverage import environment_coverage
from ...core.evaluation.variability import floor_variability
from ...core.motion.graph import MotionGraph
from ...core.motion.repertoire import STEP_OBSTACLE
from ...core.playback.walk import WalkSettings, random_walk_steps
from ...core.progress import finish
from ...core.report.floor_chart import FloorWalk, amount_chart
from ...core.report.page import Figure, FigureRow, Paragraph, Section
from ...core.report.table import Table, table
from .chapter import Chapter, Comparison, size_of
from .graphs import PAPER_LINKS, PAPER_SEGMENTS, Graphs, children_per_segment, mean_length, steps_over
from .stage import Place, timed

#: The paper's embedding of the room with the step.
PAPER_NODES, PAPER_EMBEDDED_LINKS, PAPER_TIME = 198_000, 1_470_000, 1800.0

#: With the step it has that share of the nodes and links that it has without.
PAPER_NODE_SHARE, PAPER_LINK_SHARE = 0.33, 0.18

_WIDE = EmbeddingSettings(FootprintSettings(position_rate=0.15, heading_rate=0.12))


@dataclass(frozen=True)
class Rooms:
    """The paper's room, embedded.

    Attributes
    ----------
    place : Place
        With the step.
    embedding : Embedding
        Our best graph in it.
    """

    place: Place
    embedding: Embedding


def beyond_the_step(place: Place) -> np.ndarray:
    """(nx, ny) bool: cells of a scene that lie beyond its last step, as it is grown."""
    grid = place.environment.grid
    edge = place.layout.steps[-1] + STEP_OBSTACLE[0] / 2 + STEP_MARGIN
    y = grid.positions(np.indices(grid.shape[:2]).transpose(1, 2, 0))[..., 1]
    return y > edge


def timed_embedding(place: Place, graph: MotionGraph) -> tuple[Embedding, float]:
    """An embedding and the seconds that it takes."""
    return timed(lambda: place.embed(graph))


def draw_rooms(graphs: Graphs, with_step: Place, without: Place) -> tuple[Rooms, Chapter]:
    """The section on Fig. 1."""
    best, seconds = timed_embedding(with_step, graphs.best)
    open_best, _ = timed_embedding(without, graphs.best)
    origins, sparse = _origins(graphs, without, open_best)
    lightest = float(max(np.percentile(ways[ways > 0], 99) for ways in map(floor_variability, (best, open_best))))
    walk = _walk_over_the_step(best, beyond_the_step(with_step))
    walks = (FloorWalk(walk.root_path),)
    figures = {
        "figure_1": amount_chart(
            with_step.floor, "With the step", floor_variability(best), "ways", walks=walks, lightest=lightest
        ),
        "figure_1_without_step": amount_chart(
            without.floor, "Without the step", floor_variability(open_best), "ways", lightest=lightest
        ),
        "figure_1_sparse": amount_chart(
            without.floor, "Without the step, sparse graph", floor_variability(sparse), "ways"
        ),
    }
    shares = best.n_nodes / open_best.n_nodes, best.n_links / open_best.n_links
    across = np.count_nonzero(best.covered().any(axis=2) & beyond_the_step(with_step))
    over = across * with_step.environment.grid.cell_size**2
    grid = with_step.environment.grid
    text = (
        f"{wording.exact(grid.size[0])} x {wording.exact(grid.size[1])} m in cells of "
        f"{wording.exact(100 * grid.cell_size)} cm and {grid.n_headings} headings. "
        f"{environment_coverage(best).describe()} {wording.area(over)} of it lie beyond the step. The green line is a "
        f"random walk of {wording.time(walk.duration)}, drawn again and again until one crosses the step."
    )
    captions = (
        f"Our best graph: {size_of(best)} nodes / links. The lighter, the more ways; hatched: only stepping over.",
        f"The same graph without the step, on the same scale: {size_of(open_best)}.",
        f"The graph nearest to the paper's ({len(graphs.nearest.segments)} segments, {len(graphs.nearest.links)} "
        f"links), on its own scale: {size_of(sparse)}.",
    )
    figure_row = FigureRow(tuple(Figure(c, text) for c, text in zip(figures.values(), captions, strict=True)))
    return Rooms(with_step, best), Chapter(
        Section(
            "Fig. 1: a cluttered room, with and without a step",
            (
                Paragraph(text),
                figure_row,
                Paragraph(
                    "Where the numbers come from: every node has as many links as its segment has children, times the "
                    "grid elements of their footprints that are free and embedded. The footprints of the paper are not "
                    "told in numbers; ours are 0.08 m and 0.08 rad for each metre, and wide ones 0.15 and 0.12."
                ),
                origins,
            ),
        ),
        figures=figures,
        numbers={
            "with_step": {"nodes": best.n_nodes, "links": best.n_links, "seconds": seconds, "beyond_m2": over},
            "without_step": {"nodes": open_best.n_nodes, "links": open_best.n_links},
            "sparse_without_step": {"nodes": sparse.n_nodes, "links": sparse.n_links},
            "node_share": shares[0],
            "link_share": shares[1],
            "origins": origins.records(),
        },
        comparisons=_comparisons(graphs, best, sparse, shares, seconds, origins),
    )


def _walk_over_the_step(embedding: Embedding, beyond: np.ndarray):
    """The first of many random walks of a minute that comes to both sides of the step; the last one if none does."""
    rng = np.random.default_rng(0)
    walk = finish(random_walk_steps(embedding, rng, WalkSettings(60.0)))
    for _ in range(30):
        sides = beyond[tuple(walk.states[:, :2].T)]
        if sides.any() and not sides.all():
            break
        walk = finish(random_walk_steps(embedding, rng, WalkSettings(60.0)))
    return walk


def _origins(graphs: Graphs, place: Place, open_best: Embedding) -> tuple[Table, Embedding]:
    """Nodes and links that follow from the graph and the footprint: a table, and the sparse graph's embedding."""
    sparse = place.embed(graphs.nearest)
    paper = PAPER_NODES / PAPER_NODE_SHARE, PAPER_EMBEDDED_LINKS / PAPER_LINK_SHARE
    rows = [_origin("the paper (worked back from its shares)", None, PAPER_SEGMENTS, PAPER_LINKS, *paper)]
    for name, graph, embedding in (
        ("graph nearest to the paper's", graphs.nearest, sparse),
        ("the same, wide footprint", graphs.nearest, place.embed(graphs.nearest, _WIDE)),
        ("our best graph", graphs.best, open_best),
        ("the same, wide footprint", graphs.best, place.embed(graphs.best, _WIDE)),
    ):
        size = len(graph.segments), len(graph.links), embedding.n_nodes, embedding.n_links
        rows.append(_origin(name, mean_length(graph)[1], *size))
    columns = ["without the step", "mean path (m)", "segments", "graph links", "nodes", "links", "links per node"]
    return table([*columns, "children per segment", "elements per child"], rows), sparse


def _origin(name: str, metres: float | None, n_segments: int, n_graph_links: int, nodes: float, links: float) -> list:
    per_node, children = links / max(nodes, 1), n_graph_links / n_segments
    return [
        name,
        metres,
        n_segments,
        n_graph_links,
        round(nodes),
        round(links),
        per_node,
        children,
        per_node / children,
    ]


def _comparisons(graphs: Graphs, best, sparse, shares, seconds: float, origins: Table) -> tuple[Comparison, ...]:
    paper_per_node = PAPER_EMBEDDED_LINKS / PAPER_NODES
    per_child = [float(row["elements per child"] or 0) for row in origins.records()]
    metres = mean_length(graphs.nearest)[1]
    why = (
        f"{wording.amount(children_per_segment(graphs.best))} children per segment instead of "
        f"{wording.amount(PAPER_LINKS / PAPER_SEGMENTS)}: with more ways on, more places are strongly connected and "
        "each has more links."
    )
    faster = f"{wording.short(PAPER_TIME / seconds)} times as fast; on other hardware, and without ever storing a link."
    return (
        Comparison(
            "Room with step: nodes / links",
            f"{wording.short(PAPER_NODES)} / {wording.short(PAPER_EMBEDDED_LINKS)}",
            size_of(best) if best.n_nodes else "empty",
            why if steps_over(graphs.best) else "Our motion does not step over anything: only one side is embedded.",
        ),
        Comparison("Time to embed it", "30 minutes", wording.time(seconds), faster),
        Comparison(
            "Nodes / links with the step, as a share of those without",
            f"{wording.exact_share(PAPER_NODE_SHARE)} / {wording.exact_share(PAPER_LINK_SHARE)}",
            f"{wording.share(shares[0])} / {wording.share(shares[1])}",
            "The step stops all motion but stepping over within its band, so that fewer ways meet around it; how many "
            "depends on how large a part of the room the band takes away, and the paper's room is not published.",
        ),
        Comparison(
            "Without the step, sparse graph: nodes / links",
            f"{wording.short(PAPER_NODES / PAPER_NODE_SHARE)} / "
            f"{wording.short(PAPER_EMBEDDED_LINKS / PAPER_LINK_SHARE)} "
            "(worked back)",
            size_of(sparse),
            f"Links per node: {wording.amount(sparse.n_links / max(sparse.n_nodes, 1))}, in the paper "
            f"{wording.amount(PAPER_EMBEDDED_LINKS / PAPER_LINK_SHARE / (PAPER_NODES / PAPER_NODE_SHARE))} "
            f"({wording.amount(paper_per_node)} with the step). Our segments here go {wording.length(metres)} on "
            f"average, so that edits of {wording.small(0.08 * metres)} seldom reach beyond the nearest cell; longer "
            "segments and wider footprints hold more: our best graph with wide ones has "
            f"{wording.amount(per_child[4])} elements for each "
            f"child, the paper {wording.amount(per_child[0])}.",
        ),
    )
