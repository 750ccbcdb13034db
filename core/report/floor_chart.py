"""Floor maps of a scene: what was found in every cell, and around it obstacles, regions, walks and a legend."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..environment.environment import Environment
from ..environment.grid import SUBDIVISION
from ..environment.regions import RegionRule
from ..evaluation.floor import ruled_cells
from ..maps.colors import (
    BLOCKED,
    OBSTACLE,
    RULED,
    STEP,
    UNREACHED,
    WALK,
    lightest_value,
    lightness,
    ruled_samples,
)
from ..maps.legend import ColorBar, Swatch
from ..maps.scales import CIVIDIS, GREYS, ColorScale
from .chart import Trace, map_chart
from .drawing import Color, Drawing, Picture

#: Left against right.
BALANCE = ColorScale("Balance", ((0.70, 0.30, 0.00), (0.96, 0.96, 0.94), (0.00, 0.33, 0.62)))

_HATCH = 7
"""Samples from one line of a region's hatching to the next; a third of them are drawn."""


@dataclass(frozen=True)
class FloorScene:
    """Everything that all maps of a scene share.

    Attributes
    ----------
    environment : Environment
    obstacles : (4 nx, 4 ny) bool array, optional
        Samples on which something stands. Without it only what is too near an obstacle is known.
    classes : tuple of frozenset of str
        The combinations of tags that frames carry (``embedding.unrolling.sweep.classes``): where rules forbid all of
        them, nothing can be reached. Without them only what regions require is known.
    """

    environment: Environment
    obstacles: np.ndarray | None = None
    classes: tuple[frozenset[str], ...] = ()

    @property
    def ruled(self) -> np.ndarray:
        """(nx, ny) bool: cells that can only be crossed, as :func:`..evaluation.floor.ruled_cells` says."""
        return ruled_cells(self.environment, self.classes)


@dataclass(frozen=True)
class FloorWalk:
    """A way over the floor.

    Attributes
    ----------
    path : (F, 2 or more) float array
        World x and y in metres.
    """

    path: np.ndarray
    color: Color = WALK


def amount_chart(
    scene: FloorScene,
    title: str,
    values: np.ndarray,
    unit: str,
    missing: str = "cannot go here",
    walks: Sequence[FloorWalk] = (),
    scale: ColorScale = GREYS,
    lightest: float | None = None,
    least: str = "few",
    width: int = 480,
) -> Drawing:
    """Draw amounts (nx, ny) of something in each cell; 0 is none.

    Colours grow with the square root, up to ``lightest`` (by default the 99th percentile), so that few can be told
    from none. Give several maps that are to be compared the same ``lightest``. ``least`` stands at
    the dark end.
    """
    end = lightest_value(values) if lightest is None else lightest
    most = f"{wording.short(end)}{'+' if values.max(initial=0) > end else ''} {unit}"
    bar = ColorBar(scale.stops, ((0.0, least), (1.0, most)))
    colors = scale.colors(lightness(values, end))
    return floor_chart(scene, title, colors, values > 0, (bar,), missing, walks, width)


def band_chart(
    scene: FloorScene,
    title: str,
    seconds: np.ndarray,
    limits: Sequence[float],
    missing: str,
    walks: Sequence[FloorWalk] = (),
    width: int = 480,
) -> Drawing:
    """Times (nx, ny), not finite where there is none, in as many steps as there are ascending ``limits`` (s), and one
    more for what takes longer: the quicker, the lighter (the paper's Fig. 8)."""
    present = np.isfinite(seconds)
    steps = CIVIDIS.colors(1 - np.arange(len(limits) + 1) / len(limits))
    # A hair, because times are whole frames in single precision.
    colors = steps[np.searchsorted(np.array(limits) + 1e-3, np.where(present, seconds, 0.0))]
    names = [*(f"up to {wording.exact(limit)} s" for limit in limits), "longer"]
    legend = [Swatch(_color(step), name) for step, name in zip(steps, names, strict=True)]
    return floor_chart(scene, title, colors, present, legend, missing, walks, width)


def balance_chart(scene: FloorScene, title: str, balance: np.ndarray, low: str, high: str, width: int = 480) -> Drawing:
    """Shares (nx, ny) from -1 (``low``) to 1 (``high``), not a number where there is none."""
    present = np.isfinite(balance)
    colors = BALANCE.colors(np.where(present, balance, 0.0) / 2 + 0.5)
    bar = ColorBar(BALANCE.stops, ((0.0, low), (1.0, high)))
    return floor_chart(scene, title, colors, present, (bar,), "no links", (), width)


def floor_chart(
    scene: FloorScene,
    title: str,
    colors: np.ndarray,
    present: np.ndarray,
    legend: Sequence[Swatch | ColorBar] = (),
    missing: str = "cannot go here",
    walks: Sequence[FloorWalk] = (),
    width: int = 480,
) -> Drawing:
    """Draw a map in any colours.

    Parameters
    ----------
    colors : (nx, ny, 3) float array
        sRGB of the cells that are ``present`` (nx, ny). Others are out of reach (``missing`` says what that means), in
        a region, or too near an obstacle.
    """
    environment, grid = scene.environment, scene.environment.grid
    pixels = floor_pixels(scene, colors, present)
    free = environment.free_cells()
    ruled = scene.ruled
    entries = list(legend)
    if np.any(free & ~present & ~ruled):
        entries.append(Swatch(UNREACHED, missing))
    if np.any(ruled & ~present):
        entries.append(Swatch(RULED, "only crossed, under a rule"))
    entries.append(Swatch(BLOCKED, "too near an obstacle"))
    if scene.obstacles is not None:
        entries.append(Swatch(OBSTACLE, "obstacle"))
    entries += [Swatch(STEP, words) for words in _region_words(environment)]
    traces = [
        Trace((np.asarray(walk.path)[:, :2] - grid.origin) / grid.sample_size - 0.5, walk.color) for walk in walks
    ]
    return map_chart(title, pixels, grid.sample_size, entries, traces, width)


def floor_pixels(scene: FloorScene, colors: np.ndarray, present: np.ndarray) -> np.ndarray:
    """(4 nx, 4 ny, 3) sRGB of the samples of a floor, for (nx, ny, 3) colours of the cells that are ``present``."""
    environment = scene.environment
    free = environment.free_cells()
    cells = np.array(colors, dtype=float)
    cells[~present & free] = UNREACHED
    cells[~present & scene.ruled] = RULED
    cells[~present & ~free] = BLOCKED
    pixels = cells.repeat(SUBDIVISION, axis=0).repeat(SUBDIVISION, axis=1)
    pixels[environment.blocked] = BLOCKED
    x, y = np.indices(environment.blocked.shape)
    hatched = (x + y) % _HATCH < _HATCH // 3
    pixels[ruled_samples(environment) & hatched & ~environment.blocked] = STEP
    if scene.obstacles is not None:
        pixels[scene.obstacles] = OBSTACLE
    return pixels


def picture_of(chart: Drawing) -> np.ndarray:
    """Return the pixels of a map alone, (rows, columns, 3) uint8, each three by three: for a PNG file."""
    pixels = max((m.pixels for m in chart.marks if isinstance(m, Picture)), key=lambda found: found.size)
    return np.ascontiguousarray(pixels.repeat(3, axis=0).repeat(3, axis=1))


def _region_words(environment: Environment) -> list[str]:
    words = {RegionRule.REQUIRE: "only '{}' motion", RegionRule.FORBID: "no '{}' motion"}
    rules = [region for region in environment.regions if region.rule in words]
    return list(dict.fromkeys(words[region.rule].format(region.tag) for region in rules))


def _color(values: np.ndarray) -> Color:
    red, green, blue = values.tolist()
    return red, green, blue
