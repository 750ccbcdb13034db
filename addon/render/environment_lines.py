"""The environment as lines on the ground: its rectangle, what obstacles block, and the regions."""

from dataclasses import dataclass

import numpy as np

from ...core.environment.environment import Environment
from ...core.environment.grid import Grid
from ...core.environment.regions import RegionRule

RGBA = tuple[float, float, float, float]

# sRGB: blue, orange and pink that everybody can tell apart, after Okabe and Ito.
GROUND: RGBA = (0.85, 0.87, 0.90, 0.9)
BLOCKED: RGBA = (0.95, 0.35, 0.25, 0.9)
RULES: dict[RegionRule, RGBA] = {
    RegionRule.REQUIRE: (0.96, 0.70, 0.16, 1.0),
    RegionRule.FORBID: (0.85, 0.45, 0.70, 1.0),
    RegionRule.CONFINE: (0.35, 0.71, 0.91, 1.0),
}
BODY: RGBA = (0.25, 0.85, 0.45, 1.0)

_ABOVE = 0.01
"""Metres above the ground."""


@dataclass(frozen=True)
class Lines:
    """Pieces of straight line, (2 n, 3) points in metres, two for each piece, in one colour (sRGB and alpha)."""

    points: np.ndarray
    color: RGBA


def environment_lines(environment: Environment, ground_height: float) -> tuple[Lines, ...]:
    """Ground rectangle, outline of what is blocked, and outlines of the regions in the colour of their rule."""
    grid, z = environment.grid, ground_height + _ABOVE
    low = np.array(grid.origin)
    high = low + grid.size
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    rectangle = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).reshape(-1, 2)
    lines = [Lines(_at_height(rectangle, z), GROUND), Lines(_outline(environment.blocked, grid, z), BLOCKED)]
    lines += [Lines(_outline(region.mask, grid, z), RULES[region.rule]) for region in environment.regions]
    return tuple(found for found in lines if len(found.points))


def body_lines(x: float, y: float, z: float, radius: float, heading: float | None) -> Lines:
    """The circle that the character keeps free around x, y (m), and an arrow if there is a ``heading`` (rad)."""
    angle = np.linspace(0, 2 * np.pi, 49)
    circle = np.array([x, y]) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    pieces = [np.stack([circle[:-1], circle[1:]], axis=1)]
    if heading is not None:
        reach = max(1.8 * radius, 0.3)
        tip = np.array([x, y]) + reach * np.array([np.cos(heading), np.sin(heading)])
        barbs = [tip - 0.3 * reach * np.array([np.cos(heading + t), np.sin(heading + t)]) for t in (0.5, -0.5)]
        pieces.append(np.array([[(x, y), tip], [tip, barbs[0]], [tip, barbs[1]]]))
    return Lines(_at_height(np.concatenate(pieces).reshape(-1, 2), z + _ABOVE), BODY)


def _outline(mask: np.ndarray, grid: Grid, z: float) -> np.ndarray:
    """(2 n, 3) points of the borders between samples inside and outside a mask; straight runs are one piece.

    None along the edge of the ground: the rectangle is drawn there.
    """
    pieces = []
    for axis in (0, 1):
        turned = mask if axis == 0 else mask.T
        # Borders between columns i and i + 1, and where along them a run begins and ends.
        border = turned[1:] != turned[:-1]
        ends = np.diff(np.pad(border.astype(np.int8), ((0, 0), (1, 1))), axis=1)
        at, start = np.nonzero(ends == 1)
        _, stop = np.nonzero(ends == -1)
        a, b = np.column_stack([at + 1, start]), np.column_stack([at + 1, stop])
        piece = np.stack([a, b], axis=1)
        pieces.append(piece if axis == 0 else piece[..., ::-1])
    points = np.concatenate(pieces).reshape(-1, 2) * grid.sample_size + grid.origin
    return _at_height(points, z)


def _at_height(points: np.ndarray, z: float) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), z)]).astype(np.float32)
