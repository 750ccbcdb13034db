"""The paper's Fig. 4: reach of repeated steps, in theory and on the grid.

python tests/figures/footprint_growth.py FILE.png
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Rectangle
from scipy.spatial import ConvexHull

from core.embedding.footprint import FootprintRule, FootprintSettings
from core.embedding.growth import gridded_growth, theoretical_growth
from core.environment.grid import Grid
from core.motion.graph import MotionSegment

N_STEPS = 4
COLOURS = ["#0072B2", "#009E73", "#E69F00", "#CC79A7"]


def arc(length: float, turn: float) -> MotionSegment:
    """A walk of ``length`` metres that turns by ``turn`` radians."""
    t = np.linspace(0, 1, 31)
    middle = turn * (t[1:] + t[:-1]) / 2
    steps = np.column_stack([np.cos(middle), np.sin(middle)]) * length / 30
    xy = np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)])
    return MotionSegment("arc", 0, 0, 30, np.column_stack([xy, turn * t]), 1.0, {})


def draw(axes, segment, grid, settings, title):
    theory = theoretical_growth(segment, settings, N_STEPS, np.random.default_rng(0), 20_000)
    growth = gridded_growth(segment, grid, settings, N_STEPS)
    for step, (grown, colour) in enumerate(zip(growth, COLOURS, strict=True)):
        cells = np.unique(grown[:, :2], axis=0) * grid.cell_size
        squares = [Rectangle(c - grid.cell_size / 2, grid.cell_size, grid.cell_size) for c in cells]
        axes.add_collection(PatchCollection(squares, facecolor=colour, alpha=0.45, edgecolor="white", linewidth=0.6))
        corners = theory[step, ConvexHull(theory[step, :, :2]).vertices, :2]
        axes.fill(*corners.T, facecolor="none", edgecolor=colour, linewidth=1.8, label=f"{step + 1} steps")
    axes.plot(0, 0, "ko", markersize=5)
    axes.arrow(0, 0, 0.2, 0, width=0.015, color="black", length_includes_head=True)
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")


def main() -> None:
    figure, rows = plt.subplots(2, 2, figsize=(13, 10), constrained_layout=True, width_ratios=[1.25, 1])
    settings = FootprintSettings(0.0, 0.15, 0.0, 0.12, FootprintRule.SNAP)
    for axes_row, grid in zip(rows, (Grid((1, 1, 24), 0.125), Grid((1, 1, 72), 0.0625)), strict=True):
        for axes, (name, turn) in zip(axes_row, (("straight", 0.0), ("turning left", 0.5)), strict=True):
            cell, angle = 100 * grid.cell_size, np.degrees(grid.heading_step)
            draw(axes, arc(1.0, turn), grid, settings, f"1 m {name}, cells of {cell:g} cm, headings of {angle:g}°")
    rows[0, 0].legend(title="outline: in theory\nsquares: on the grid", loc="upper left", fontsize=9)
    figure.suptitle("Where repeated steps may end, with edits of up to 0.15 m and 0.12 rad per metre")
    figure.savefig(sys.argv[1], dpi=110)


if __name__ == "__main__":
    main()
