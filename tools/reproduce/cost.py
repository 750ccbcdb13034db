"""Cost against the links of the motion graph and against area: the paper says linear."""

import numpy as np

from ...core import wording
from ...core.embedding.embedding import embed
from ...core.environment.environment import build_environment
from ...core.environment.grid import Grid
from ...core.motion.graph import MotionGraph
from ...core.report.chart import Series, line_chart
from ...core.report.page import Figure, FigureRow, Paragraph, Section
from ...core.report.table import table
from .chapter import Chapter, Comparison
from .graphs import Graphs
from .room import timed_embedding
from .stage import Place, timed


def measure_cost(graphs: Graphs, room: Place, tile: Place, sides: tuple[int, ...]) -> Chapter:
    """Time and size of embeddings of ever more links, and on ever more tiles (``sides`` x ``sides``)."""
    links, seconds, sizes = [], [], []
    for graph in graphs.by_cost:
        embedding, time = timed_embedding(room, graph)
        links.append(len(graph.links))
        seconds.append(time)
        sizes.append(embedding.n_links)
    areas, area_seconds, area_links = [], [], []
    for side in sides:
        area, time, n_links = _on_tiles(graphs.nearest, tile, side)
        areas.append(area)
        area_seconds.append(time)
        area_links.append(n_links)
    charts = (
        ("cost_links", "Time against links of the motion graph", "links", "seconds", links, seconds),
        ("cost_links_size", "Links of the embedding", "links of the motion graph", "links", links, sizes),
        ("cost_area", "Time against area", "m²", "seconds", areas, area_seconds),
        ("cost_area_size", "Links of the embedding", "m²", "links", areas, area_links),
    )
    figures = {
        name: line_chart(title, across, up, [Series(title, np.array(x), np.array(y))], from_zero=True)
        for name, title, across, up, x, y in charts
    }
    by_links, by_area = Fit(links, seconds), Fit(areas, area_seconds)
    rows = [["links of the motion graph", *row] for row in zip(links, seconds, sizes, strict=True)]
    rows += [["area (m2)", *row] for row in zip(areas, area_seconds, area_links, strict=True)]
    return Chapter(
        Section(
            "Cost against links and area",
            (
                Paragraph(
                    "Processor seconds. In the room without the step, at ever higher thresholds: "
                    f"{by_links.text('link')}. The tile laid next to itself, with the graph nearest to the paper's: "
                    f"{by_area.text('m²')}."
                ),
                FigureRow(tuple(Figure(chart) for chart in figures.values())),
                table(["against", "value", "seconds", "links of the embedding"], rows),
            ),
        ),
        figures=figures,
        numbers={"by_links": by_links.numbers(), "by_area": by_area.numbers()},
        comparisons=(
            Comparison(
                f"Time against links of the motion graph ({links[0]} to {links[-1]})",
                "linear",
                f"{by_links.text('link')}",
                f"{wording.short(links[-1] / links[0])} times as many links take "
                f"{wording.amount(seconds[-1] / seconds[0])} times as long: segments with the same parents or children "
                "share their work, and no link is ever stored. A graph that "
                "hardly holds together costs extra: small components are tried before the largest is found.",
            ),
            Comparison(
                f"Time against area ({wording.amount(areas[0])} to {wording.area(areas[-1])})",
                "linear",
                f"{by_area.text('m²')}",
                f"{wording.short(areas[-1] / areas[0])} times the area takes "
                f"{wording.amount(area_seconds[-1] / area_seconds[0])} times as "
                "long: what does not depend on the area, the paths of all segments, is a large part on small grounds.",
            ),
        ),
    )


class Fit:
    """A straight line through points, by least squares."""

    def __init__(self, x, y):
        x, y = np.array(x, dtype=float), np.array(y, dtype=float)
        self.slope, self.start = np.polyfit(x, y, 1).tolist()
        rest = y - (self.start + self.slope * x)
        self.explained = float(1 - (rest @ rest) / max(((y - y.mean()) ** 2).sum(), 1e-12))

    def text(self, unit: str) -> str:
        return f"{wording.time(self.start)} {1000 * self.slope:+.2f} ms per {unit} (R² {self.explained:.2f})"

    def numbers(self) -> dict[str, float]:
        return {"seconds": self.start, "seconds_each": self.slope, "r_squared": self.explained}


def _on_tiles(graph: MotionGraph, tile: Place, side: int) -> tuple[float, float, int]:
    """Area (m2), seconds and links of an embedding on ``side`` x ``side`` copies of a tile, that do not wrap."""
    grid = tile.environment.grid
    width, depth = grid.size
    copies = [tile.obstacles + [i * width, j * depth, 0.0] for i in range(side) for j in range(side)]
    ground = Grid(
        (grid.shape[0] * side, grid.shape[1] * side, grid.n_headings), grid.cell_size, grid.origin, tiled=False
    )
    environment = build_environment(ground, np.concatenate(copies))
    embedding, seconds = timed(lambda: embed(graph, environment))
    return width * depth * side**2, seconds, embedding.n_links
