"""Figs. 5 to 8: local and global pruning, single headings, and times to reach the region beyond the step."""

import numpy as np

from ...core import wording
from ...core.embedding.embedding import Embedding
from ...core.evaluation.goals import goal_in_cells
from ...core.evaluation.reach import PAPER_TIMES, time_to_reach_steps
from ...core.evaluation.variability import coverage_share, floor_variability, heading_variability
from ...core.motion.repertoire import STEP_TAG
from ...core.progress import finish
from ...core.report.chart import Series, line_chart
from ...core.report.floor_chart import amount_chart, band_chart
from ...core.report.page import Figure, FigureRow, Paragraph, Section
from ...core.report.table import table
from ...core.tuning.global_pruning import prune_global_steps
from ...core.tuning.local_pruning import prune_local_steps
from .chapter import Chapter, Comparison, size_of
from .graphs import PAPER_SEGMENTS
from .room import PAPER_EMBEDDED_LINKS, PAPER_NODES, Rooms, beyond_the_step

#: Segments kept at each place -> the paper's nodes and links.
PAPER_LOCAL = {16: (150_000, 1_150_000), 4: (53_000, 404_000)}

#: Nodes for each position and heading of 7 x 8 m in 12.5 cm and 15 degrees.
PAPER_PER_PLACE = PAPER_NODES / (56 * 64 * 24)

#: Segments kept in all.
PAPER_GLOBAL = (36, 8)


def draw_local_pruning(rooms: Rooms) -> Chapter:
    """Fig. 5."""
    whole, figures, rows, comparisons = rooms.embedding, {}, [], []
    lightest = _lightest(whole)
    for k, (nodes, links) in PAPER_LOCAL.items():
        pruned = finish(prune_local_steps(whole, k))
        figures[f"figure_5_k{k}"] = amount_chart(
            rooms.place.floor, f"{k} segments at each place", floor_variability(pruned), "ways", lightest=lightest
        )
        kept = pruned.n_nodes / max(whole.n_nodes, 1), pruned.n_links / max(whole.n_links, 1)
        paper = nodes / PAPER_NODES, links / PAPER_EMBEDDED_LINKS
        over = _area(rooms, pruned)
        rows.append([k, pruned.n_nodes, pruned.n_links, *kept, *paper, coverage_share(pruned, whole), over])
        reached = "the region beyond the step stays" if over else "the region beyond the step is lost"
        comparisons.append(
            Comparison(
                f"Fig. 5: local pruning to {k}: nodes / links kept",
                f"{wording.exact_share(paper[0], 2)} / {wording.exact_share(paper[1], 2)}",
                f"{wording.share(kept[0])} / {wording.share(kept[1])}",
                f"Shares of the whole embedding, {size_of(pruned)} here. Ours has more nodes at each place "
                f"({wording.amount(_per_place(whole))} on average; the paper's room has "
                f"{wording.amount(PAPER_PER_PLACE)} for each cell and "
                f"heading of the grid), so that the same k prunes more; {reached}.",
            )
        )
    alike = [_as_large(rooms, nodes / PAPER_NODES) for nodes, _ in PAPER_LOCAL.values()]
    kept_alike = "; ".join(
        f"{wording.share(share)} of the nodes are kept by k = {k}, with {wording.area(over)} beyond the step"
        for share, k, over in alike
    )
    numbers = table(
        ["k", "nodes", "links", "nodes kept", "links kept", "paper: nodes", "paper: links", "coverage", "beyond (m2)"],
        rows,
    )
    caption = "The lighter, the more ways; on the scale of the whole embedding."
    return Chapter(
        Section(
            "Fig. 5: local pruning",
            (
                Paragraph(
                    "At each position and heading only the segments with the highest variability are kept, then the "
                    "largest strongly connected component is taken again. Coverage is the share of the free floor. As "
                    f"large a share of the nodes as in the paper takes another k here: {kept_alike}."
                ),
                FigureRow(tuple(Figure(chart, caption) for chart in figures.values())),
                numbers,
            ),
        ),
        figures=figures,
        numbers={
            "pruned": numbers.records(),
            "as_large": [dict(zip(("share", "k", "beyond_m2"), a, strict=True)) for a in alike],
        },
        comparisons=tuple(comparisons),
    )


def draw_global_pruning(rooms: Rooms) -> Chapter:
    """Fig. 6."""
    whole = rooms.embedding
    n = len(whole.graph.segments)
    # As many in proportion as the paper kept of its segments.
    targets = {paper: max(round(n * paper / PAPER_SEGMENTS), 1) for paper in PAPER_GLOBAL}
    lightest, figures, texts = _lightest(whole), {}, []
    smallest = finish(prune_global_steps(whole, min(targets.values())))
    lost_at = _step_lost_at(whole, smallest)
    for paper, kept in targets.items():
        pruned = (
            finish(prune_global_steps(whole, kept)).embedding if kept != min(targets.values()) else smallest.embedding
        )
        figures[f"figure_6_{paper}"] = amount_chart(
            rooms.place.floor, f"{kept} of {n} segments", floor_variability(pruned), "ways", lightest=lightest
        )
        over = _area(rooms, pruned)
        texts.append(
            f"{kept} segments (the paper: {paper} of {PAPER_SEGMENTS}): {size_of(pruned)} nodes / links, "
            f"{wording.share(coverage_share(pruned, whole))} of the free floor, {wording.area(over)} beyond the step."
        )
    left = np.array([n - i for i in range(len(smallest.dropped) + 1)])
    shares = np.array([coverage_share(whole), *(drop.coverage for drop in smallest.dropped)])
    nodes = np.array([whole.n_nodes, *(drop.n_nodes for drop in smallest.dropped)])
    curve = line_chart(
        "What global pruning leaves",
        "segments kept",
        "% of all",
        [
            Series("coverage", left, 100 * shares),
            Series("nodes", left, 100 * nodes / max(whole.n_nodes, 1)),
        ],
    )
    figures["figure_6_curve"] = curve
    lost = (
        "No segment steps over anything in this graph."
        if lost_at is None
        else f"The last segment that steps over goes when {lost_at} segments are left."
        if lost_at
        else "The step is kept to the end."
    )
    caption = "The lighter, the more ways; on the scale of the whole embedding."
    return Chapter(
        Section(
            "Fig. 6: global pruning",
            (
                Paragraph(
                    f"The segment with the least variability over the whole room is dropped, again and again. {lost} "
                    + " ".join(texts)
                ),
                FigureRow(tuple(Figure(chart, caption) for name, chart in figures.items() if "curve" not in name)),
                Figure(curve, "Segments that only few places need are the first to go."),
            ),
        ),
        figures=figures,
        numbers={"step_lost_at": lost_at, "segments": n, "kept": list(targets.values()), "coverage": shares.tolist()},
        comparisons=(
            Comparison(
                "Fig. 6: global pruning to 36 and 8 segments",
                "loses the step, then collapses",
                f"step lost at {lost_at} of {n}; at {left[-1]} coverage {wording.share(shares[-1])}, "
                f"{wording.share(nodes[-1] / max(whole.n_nodes, 1))} of the nodes",
                "As in the paper rare segments are the first to go, however much they are needed. What is left on this "
                "side of the step thins out, but better connected segments hold it together longer than the paper's."
                if lost_at
                else "Our step is not the rarest motion here.",
            ),
        ),
    )


def draw_headings(rooms: Rooms) -> Chapter:
    """Fig. 7."""
    embedding, n = rooms.embedding, rooms.embedding.shape[2]
    chosen = {"facing right (0°)": 0, "facing the step (90°)": n // 4}
    maps = {name: heading_variability(embedding, index) for name, index in chosen.items()}
    lightest = float(max(np.percentile(values[values > 0], 99) if values.any() else 1.0 for values in maps.values()))
    figures = {
        f"figure_7_{'ab'[i]}": amount_chart(rooms.place.floor, name.capitalize(), values, "ways", lightest=lightest)
        for i, (name, values) in enumerate(maps.items())
    }
    cell_area = embedding.environment.grid.cell_size**2
    areas = {name: int(np.count_nonzero(values)) * cell_area for name, values in maps.items()}
    return Chapter(
        Section(
            "Fig. 7: single headings",
            (
                Paragraph("; ".join(f"{name}: {wording.area(area)} covered" for name, area in areas.items()) + "."),
                FigureRow(tuple(Figure(chart, "Variability of one heading only.") for chart in figures.values())),
            ),
        ),
        figures=figures,
        numbers=areas,
        comparisons=(
            Comparison(
                "Fig. 7: variability of two headings",
                "differ by place (drawn)",
                ", ".join(f"{wording.area(area)} {name}" for name, area in areas.items()),
                "Drawn without a number in the paper; as there, who faces a wall closely has few ways.",
            ),
        ),
    )


def draw_times(rooms: Rooms) -> Chapter:
    """Fig. 8."""
    embedding, beyond = rooms.embedding, beyond_the_step(rooms.place)
    if not (embedding.covered().any(axis=2) & beyond).any():
        return Chapter(
            Section("Fig. 8: time to reach", (Paragraph("This motion never gets beyond the step: there is no goal."),)),
            comparisons=(
                Comparison("Fig. 8: areas within 2, 3, 5, 7 s", "drawn", "none", "This motion does not step over."),
            ),
        )
    field = finish(time_to_reach_steps(embedding, goal_in_cells(embedding, beyond, "the region beyond the step")))
    seconds = field.floor()
    chart = band_chart(rooms.place.floor, "Time to get beyond the step", seconds, PAPER_TIMES, "no way from here")
    # The region itself is no place to come from.
    cell_area = embedding.environment.grid.cell_size**2
    areas = [float(np.count_nonzero((seconds <= t + 1e-3) & ~beyond) * cell_area) for t in PAPER_TIMES]
    longest = float(seconds[np.isfinite(seconds)].max())
    within = table(["within (s)", "area before the step (m2)"], list(zip(PAPER_TIMES, areas, strict=True)))
    return Chapter(
        Section(
            "Fig. 8: from where the region beyond the step is reached in time",
            (
                Paragraph(f"Exact shortest times in the best heading; the longest is {wording.time(longest)}."),
                FigureRow((Figure(chart, "The lighter, the sooner."),)),
                within,
            ),
        ),
        figures={"figure_8": chart},
        numbers={"areas_m2": areas, "longest_s": longest},
        comparisons=(
            Comparison(
                "Fig. 8: areas within 2, 3, 5, 7 s",
                "growing areas (drawn)",
                ", ".join(map(wording.area, areas)),
                "Drawn without numbers in the paper. Times depend on how long the step itself takes: it must be over.",
            ),
        ),
    )


def _as_large(rooms: Rooms, share: float) -> tuple[float, int, float]:
    """The share, the least k that keeps as large a share of the nodes, and the square metres beyond the step then."""
    wanted = share * rooms.embedding.n_nodes
    # What is kept for one k is kept for all larger ones.
    low, high, best = 0, rooms.embedding.shape[3], rooms.embedding
    while high - low > 1:
        middle = (low + high) // 2
        pruned = finish(prune_local_steps(rooms.embedding, middle))
        if pruned.n_nodes >= wanted:
            high, best = middle, pruned
        else:
            low = middle
    return share, high, _area(rooms, best)


def _lightest(embedding: Embedding) -> float:
    ways = floor_variability(embedding)
    return float(np.percentile(ways[ways > 0], 99)) if ways.any() else 1.0


def _area(rooms: Rooms, embedding: Embedding) -> float:
    """Square metres beyond the step that an embedding of the room covers - if it covers both sides."""
    covered, beyond = embedding.covered().any(axis=2), beyond_the_step(rooms.place)
    both = (covered & beyond).any() and (covered & ~beyond).any()
    return float(np.count_nonzero(covered & beyond) * embedding.environment.grid.cell_size**2) if both else 0.0


def _per_place(embedding: Embedding) -> float:
    """Nodes at each position and heading that has any."""
    return embedding.n_nodes / max(int(np.count_nonzero(embedding.covered())), 1)


def _step_lost_at(whole: Embedding, pruning) -> int | None:
    """Count the segments left when the last that steps over was dropped; 0 if never, None if there is none."""
    stepping = {i for i, segment in enumerate(whole.graph.segments) if STEP_TAG in segment.tags}
    if not stepping:
        return None
    left = len(whole.graph.segments)
    for drop in pruning.dropped:
        left -= 1
        stepping.discard(drop.segment)
        if not stepping:
            return left
    return 0
