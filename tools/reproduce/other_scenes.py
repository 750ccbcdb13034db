"""Fig. 9, a tile and a walk across tiles; Fig. 10, an S-shaped hall and two steps; crowds, beyond the paper."""

import numpy as np

from ...core import wording
from ...core.embedding.embedding import Embedding
from ...core.environment.grid import SUBDIVISION
from ...core.errors import WalkError
from ...core.evaluation.environment_coverage import environment_coverage
from ...core.evaluation.variability import floor_variability
from ...core.maps.colors import BLOCKED, OBSTACLE, WALK, lightest_value, lightness
from ...core.maps.legend import ColorBar, Swatch
from ...core.maps.scales import GREYS, SERIES
from ...core.motion.graph import MotionGraph
from ...core.playback.crowd import Crowd, CrowdSettings, crowd_steps, scattered_starts
from ...core.playback.walk import WalkSettings, random_walk_steps
from ...core.progress import finish
from ...core.report.chart import Trace, map_chart
from ...core.report.drawing import Drawing
from ...core.report.floor_chart import FloorWalk, amount_chart, floor_pixels
from ...core.report.page import Figure, FigureRow, Paragraph, Section
from .chapter import Chapter, Comparison, size_of
from .stage import Place

#: The walk across tiles is shown on so many of them each way.
N_TILES = 3

_CROWD_COLORS = (*SERIES, (0.84, 0.15, 0.16), (0.10, 0.78, 0.25))


def draw_tile(place: Place, graph: MotionGraph) -> tuple[Embedding, Chapter]:
    """Fig. 9."""
    embedding = place.embed(graph)
    walk = _walk_across_tiles(embedding)
    figures = {
        "figure_9_tile": amount_chart(place.floor, "A tile", floor_variability(embedding), "ways"),
        "figure_9_walk": _tiled_chart(place, embedding, walk),
    }
    grid = embedding.environment.grid
    length = float(np.linalg.norm(np.diff(walk[:, :2], axis=0), axis=1).sum())
    captions = (
        f"{size_of(embedding)} nodes / links. What leaves on one side enters on the other.",
        f"The tile laid {N_TILES} x {N_TILES} times: {wording.length(length)} of a random walk that goes on across the "
        "seams.",
    )
    return embedding, Chapter(
        Section(
            "Fig. 9: a tile, and a walk across tiles",
            (
                Paragraph(
                    f"{wording.exact(grid.size[0])} x {wording.exact(grid.size[1])} m, cells of "
                    f"{wording.exact(100 * grid.cell_size)} cm, {grid.n_headings} headings, tiled. "
                    f"{environment_coverage(embedding).describe()}"
                ),
                FigureRow(tuple(Figure(c, text) for c, text in zip(figures.values(), captions, strict=True))),
            ),
        ),
        figures=figures,
        numbers={"nodes": embedding.n_nodes, "links": embedding.n_links, "walk_m": length},
        comparisons=(
            Comparison(
                "Fig. 9: tile of 6 x 6 m, 15 cm, 15°",
                "a walk across tiles (drawn)",
                f"{size_of(embedding)}; {wording.length(length)} across tiles",
                "Other obstacles: the paper's tile is not published.",
            ),
        ),
    )


def draw_halls(hall: Place, two_steps: Place, graph: MotionGraph) -> tuple[dict[str, Embedding], Chapter]:
    """Fig. 10."""
    figures, embeddings, words = {}, {}, []
    for name, place in (("s_hall", hall), ("two_steps", two_steps)):
        embedding = embeddings[name] = place.embed(graph)
        walks = ()
        if embedding.n_nodes:
            walk = finish(random_walk_steps(embedding, np.random.default_rng(2), WalkSettings(60.0)))
            walks = (FloorWalk(walk.root_path),)
        figures[f"figure_10_{name}"] = amount_chart(
            place.floor, place.layout.label, floor_variability(embedding), "ways", walks=walks
        )
        words.append(f"{place.layout.label}: {environment_coverage(embedding).describe()}")
    sizes = ", ".join(f"{name.replace('_', ' ')} {size_of(embedding)}" for name, embedding in embeddings.items())
    parts = _parts_covered(two_steps, embeddings["two_steps"])
    return embeddings, Chapter(
        Section(
            "Fig. 10: an S-shaped hall, and two steps",
            (
                Paragraph(" ".join(words)),
                FigureRow(tuple(Figure(c, "With a random walk of 60 s (green).") for c in figures.values())),
                Paragraph(f"{parts} of the three parts between and beside the two steps are covered."),
            ),
        ),
        figures=figures,
        numbers={name: {"nodes": e.n_nodes, "links": e.n_links} for name, e in embeddings.items()} | {"parts": parts},
        comparisons=(
            Comparison(
                "Fig. 10: S-shaped hall, two step obstacles",
                "both embedded (drawn)",
                f"{sizes} nodes / links",
                f"Other scenes of the same kind; {parts} of 3 parts of the room with two steps are covered.",
            ),
        ),
    )


def draw_crowds(scenes: dict[str, tuple[Place, Embedding]], n_walkers: int, seconds: float) -> Chapter:
    """Walkers that keep clear of one another."""
    figures, words, numbers = {}, [], {}
    for name, (place, embedding) in scenes.items():
        found = _crowd(embedding, n_walkers, seconds)
        if found is None:
            words.append(f"{place.layout.label}: no room for a crowd.")
            continue
        size = embedding.environment.grid.size
        walks = [FloorWalk(path, _CROWD_COLORS[i % len(_CROWD_COLORS)]) for i, path in enumerate(found.places)]
        figures[f"crowd_{name}"] = amount_chart(
            place.floor,
            f"{place.layout.label}: {len(walks)} walkers",
            floor_variability(embedding),
            "ways",
            walks=walks,
        )
        words.append(
            f"{place.layout.label} ({wording.exact(size[0])} x {wording.exact(size[1])} m): {len(found.walks)} of "
            f"{n_walkers} walk for {wording.exact(seconds)} s and never come closer than "
            f"{wording.length(found.closest)}."
        )
        numbers[name] = {"walkers": len(found.walks), "closest_m": found.closest}
    caption = "Each begins at its square. Ways may cross: the walkers are there at different times."
    return Chapter(
        Section(
            "Beyond the paper: crowds",
            (Paragraph(" ".join(words)), FigureRow(tuple(Figure(chart, caption) for chart in figures.values()))),
        ),
        figures=figures,
        numbers=numbers,
    )


def _crowd(embedding: Embedding, n_walkers: int, seconds: float) -> Crowd | None:
    settings, rng = CrowdSettings(), np.random.default_rng(0)
    try:
        starts = scattered_starts(embedding, n_walkers, rng, 2 * settings.radius)
    except WalkError:
        return None
    return finish(crowd_steps(embedding, starts, seconds, rng, settings))


def _walk_across_tiles(embedding: Embedding) -> np.ndarray:
    """(F, 3) a random walk, cut where it would leave the tiles that are shown, that begins on the middle one."""
    grid = embedding.environment.grid
    best = np.empty((0, 3))
    for seed in range(8):
        path = finish(random_walk_steps(embedding, np.random.default_rng(seed), WalkSettings(90.0))).root_path
        tile = np.floor((path[:, :2] - grid.origin) / grid.size).astype(int)
        outside = np.flatnonzero(np.any(np.abs(tile) > N_TILES // 2, axis=1))
        path = path[: outside[0] if len(outside) else len(path)]
        if len(path) > len(best):
            best = path
    return best


def _tiled_chart(place: Place, embedding: Embedding, path: np.ndarray) -> Drawing:
    grid, values = embedding.environment.grid, floor_variability(embedding)
    end = lightest_value(values)
    tile = floor_pixels(place.floor, GREYS.colors(lightness(values, end)), values > 0)
    pixels = np.tile(tile, (N_TILES, N_TILES, 1))
    # A dark seam, so that the tiles can be told apart.
    step = np.array(tile.shape[:2])
    for i in range(1, N_TILES):
        pixels[i * step[0]] *= 0.75
        pixels[:, i * step[1]] *= 0.75
    corner = np.array(grid.origin) - np.array(grid.size) * (N_TILES // 2)
    trace = Trace((path[:, :2] - corner) / grid.sample_size - 0.5, WALK)
    legend = (
        ColorBar(GREYS.stops, ((0.0, "few"), (1.0, f"{wording.short(end)}+ ways"))),
        Swatch(BLOCKED, "too near an obstacle"),
        Swatch(OBSTACLE, "obstacle"),
        Swatch(WALK, "the walk"),
    )
    return map_chart("A walk across tiles", pixels, grid.cell_size / SUBDIVISION, legend, (trace,), 640)


def _parts_covered(place: Place, embedding: Embedding) -> int:
    """Count the parts, of those that a scene's steps divide it into, that are covered."""
    grid = embedding.environment.grid
    covered = embedding.covered().any(axis=2)
    y = grid.positions(np.column_stack([np.zeros(grid.shape[1]), np.arange(grid.shape[1])]))[:, 1]
    part = np.searchsorted(np.array(place.layout.steps), y)
    return sum(bool(covered[:, part == i].any()) for i in range(len(place.layout.steps) + 1))
