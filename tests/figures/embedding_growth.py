"""Time, memory and size of the embedding against area, headings, links and footprints, as a table and a plot.

python tests/figures/embedding_growth.py FOLDER
"""

import sys
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from core.embedding.embedding import EmbeddingSettings, embed
from core.embedding.footprint import FootprintSettings
from core.environment.environment import Environment
from tests.bench import problems

DEFAULT_COST = 0.12


def with_headings(n_headings: int) -> Environment:
    """The paper-sized room with another number of headings: its samples are the same."""
    environment = problems.room()
    nx, ny, _ = environment.grid.shape
    return Environment(replace(environment.grid, shape=(nx, ny, n_headings)), environment.blocked)


def cases():
    """(question, x value, x label, graph, environment, settings)"""
    default = EmbeddingSettings()
    for side in (5, 10, 20, 40, 60):
        yield "area", side * side, "ground (m²)", problems.graph(DEFAULT_COST), problems.room(side, side), default
    for n_headings in (8, 16, 24, 36, 48, 72):
        yield (
            "headings",
            n_headings,
            "headings",
            problems.graph(DEFAULT_COST),
            with_headings(n_headings),
            default,
        )
    for cost in (0.08, 0.1, 0.12, 0.15, 0.2, 0.3):
        graph = problems.graph(cost)
        yield "links", len(graph.links), "links of the motion graph", graph, problems.room(), default
    for rate in (0.04, 0.08, 0.12, 0.16, 0.2, 0.25):
        settings = EmbeddingSettings(FootprintSettings(position_rate=rate, heading_rate=rate))
        yield "footprint", rate, "footprint (m and rad per m)", problems.graph(DEFAULT_COST), problems.room(), settings


def measured(graph, environment, settings) -> tuple[float, float, int, int]:
    """Processor seconds (the best of three), peak megabytes, nodes, links."""
    seconds = []
    for _ in range(3):
        start = time.process_time()
        embedding = embed(graph, environment, settings)
        seconds.append(time.process_time() - start)
        if seconds[-1] > 1:
            break
    tracemalloc.start()
    embed(graph, environment, settings)
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return min(seconds), peak, embedding.n_nodes, embedding.n_links


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    series: dict[str, list] = {}
    rows = ["question\tvalue\tseconds\tpeak MB\tnodes\tlinks"]
    for question, value, label, graph, environment, settings in cases():
        figures = measured(graph, environment, settings)
        series.setdefault(question, []).append((value, label, *figures))
        rows.append(f"{question}\t{value}\t{figures[0]:.3f}\t{figures[1]:.1f}\t{figures[2]}\t{figures[3]}")
        sys.stdout.write(rows[-1] + "\n")
    (folder / "embedding_growth.tsv").write_text("\n".join(rows) + "\n")

    figure, axes = plt.subplots(1, 4, figsize=(18, 4.4), constrained_layout=True)
    for panel, points in zip(axes, series.values(), strict=True):
        x = np.array([p[0] for p in points])
        seconds, peak, links = (np.array([p[i] for p in points], dtype=float) for i in (2, 3, 5))
        panel.plot(x, seconds, "o-", color="#0072B2", label="seconds")
        panel.set_xlabel(points[0][1])
        panel.set_ylim(0, None)
        panel.set_xlim(0, None)
        panel.set_ylabel("seconds", color="#0072B2")
        other = panel.twinx()
        other.plot(x, links / 1e6, "s--", color="#E69F00")
        other.set_ylim(0, None)
        other.set_ylabel("million links in the embedding", color="#B36B00")
        for value, megabytes, second in zip(x, peak, seconds, strict=True):
            panel.annotate(
                f"{megabytes:.0f} MB", (value, second), textcoords="offset points", xytext=(4, -12), fontsize=8
            )
    figure.suptitle("Cost of embedding: 7 x 8 m, 24 headings, unless the axis says otherwise")
    figure.savefig(folder / "embedding_growth.png", dpi=100)


if __name__ == "__main__":
    main()
