"""The report of a scene: what can the character reach, what is weak, what matters, what is missing, on one page."""

import json
from collections.abc import Generator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..errors import EvaluationError, MotionGraphError
from ..progress import Progress, finish, portion
from .drawing import svg
from .floor_chart import picture_of
from .page import Paragraph, Section, html_page
from .png import png_bytes
from .sections.capture import capture_section_steps
from .sections.contribution import Contribution, Goal, Questions, SectionSteps
from .sections.importance import importance_section_steps, links_section_steps, pruning_section_steps
from .sections.metrics import metrics_section_steps
from .sections.reach import reach_steps
from .sections.times import occupancy_section_steps, times_section_steps
from .sections.weakness import detours_section_steps, turns_section_steps, weak_spots_section_steps
from .table import plain

__all__ = ["Goal", "ReportOptions", "SceneReport", "Topic", "examine_scene_steps", "scene_report", "write_report"]


class Topic(Enum):
    """What a report can be about, in the order in which it says it."""

    REACH = "Reach"
    WEAK_SPOTS = "Weak Spots"
    CAPTURE = "What Is Missing"
    IMPORTANCE = "What Matters"
    TIMES = "Time to Reach"
    DETOURS = "Long Way Around"
    TURNS = "Turn Balance"
    OCCUPANCY = "Occupancy"
    METRICS = "Metrics"
    PRUNING = "Pruning"
    LINKS = "Links"


_STEPS: dict[Topic, tuple[SectionSteps, float]] = {
    Topic.REACH: (reach_steps, 1),
    Topic.WEAK_SPOTS: (weak_spots_section_steps, 1),
    Topic.DETOURS: (detours_section_steps, 30),
    Topic.TURNS: (turns_section_steps, 1),
    Topic.IMPORTANCE: (importance_section_steps, 15),
    Topic.LINKS: (links_section_steps, 1),
    Topic.PRUNING: (pruning_section_steps, 10),
    Topic.CAPTURE: (capture_section_steps, 15),
    Topic.TIMES: (times_section_steps, 1),
    Topic.OCCUPANCY: (occupancy_section_steps, 12),
    Topic.METRICS: (metrics_section_steps, 12),
}
"""For each topic its work, and about how long that takes compared to the others."""


@dataclass(frozen=True)
class ReportOptions:
    """What a report is to say.

    Attributes
    ----------
    title : str
        Mostly the name of the scene.
    topics : frozenset of Topic
        Times to reach are left out if there is no goal.
    thorough : bool
        Look at single segments, at every motion that might be captured, and at many places; otherwise at fewer.
    goal : Goal, optional
    obstacles : (4 nx, 4 ny) bool array, optional
        Samples on which something stands; without it maps show only what is too near an obstacle.
    seed, n_pairs : int
        Of the pairs of places that are drawn for path efficiency.
    allowed_loss : float
        Share of the covered floor that deleting clips together may cost.
    """

    title: str = "Scene"
    topics: frozenset[Topic] = frozenset(Topic)
    thorough: bool = True
    goal: Goal | None = None
    obstacles: np.ndarray | None = None
    seed: int = 0
    n_pairs: int = 100
    allowed_loss: float = 0.01

    def __post_init__(self):
        if not self.topics:
            raise EvaluationError("A report about nothing was asked for; choose at least one topic.")


#: The topics that take a moment only, at any size of scene.
QUICK_TOPICS = frozenset({Topic.REACH, Topic.WEAK_SPOTS, Topic.TURNS, Topic.LINKS, Topic.TIMES})


@dataclass(frozen=True)
class SceneReport:
    """What was found out about a scene.

    Attributes
    ----------
    title, lead : str
    contributions : dict of Topic to Contribution
        In the order of the topics.
    """

    title: str
    lead: str
    contributions: dict[Topic, Contribution]

    def html(self) -> str:
        """The page: one file, pictures inside, nothing from the network."""
        return html_page(self.title, self.lead, [part.section for part in self.contributions.values()])

    def numbers(self) -> dict:
        """Plain values by topic, for JSON; tables as records."""
        return {
            topic.name.lower(): _plain(part.numbers) | {name: found.records() for name, found in part.tables.items()}
            for topic, part in self.contributions.items()
        }


def scene_report(embedding: Embedding, options: ReportOptions | None = None) -> str:
    """The report of a scene as a page of HTML; :func:`examine_scene_steps` gives its parts."""
    return finish(examine_scene_steps(embedding, options)).html()


def examine_scene_steps(
    embedding: Embedding, options: ReportOptions | None = None
) -> Generator[Progress, None, SceneReport]:
    """Find out all that a report is to say; yields progress, returns a :class:`SceneReport`.

    Where a question has no answer - an embedding that is empty, nothing that travels - its section says why.
    """
    options = options or ReportOptions()
    topics = [topic for topic in Topic if topic in options.topics and (options.goal or topic is not Topic.TIMES)]
    questions = Questions(
        options.thorough, options.goal, options.obstacles, options.seed, options.n_pairs, options.allowed_loss
    )
    total = sum(_STEPS[topic][1] for topic in topics)
    found: dict[Topic, Contribution] = {}
    done = 0.0
    for topic in topics:
        steps, effort = _STEPS[topic]
        try:
            found[topic] = yield from portion(steps(embedding, questions), done / total, (done + effort) / total)
        except MotionGraphError as error:
            found[topic] = Contribution(Section(topic.value, (Paragraph(str(error)),)), {"problem": str(error)})
        done += effort
    return SceneReport(options.title, _lead(embedding), found)


def report_files(report: SceneReport) -> dict[str, bytes]:
    """report.html, report.json, a .csv for each table, a .png for each map and an .svg for each map and chart."""
    files: dict[str, bytes] = {
        "report.html": report.html().encode(),
        "report.json": (json.dumps({"title": report.title, **report.numbers()}, indent=2) + "\n").encode(),
    }
    for part in report.contributions.values():
        for name, found in part.tables.items():
            files[f"{name}.csv"] = found.csv().encode()
        for name, chart in (part.maps | part.charts).items():
            files[f"{name}.svg"] = svg(chart).encode()
        for name, chart in part.maps.items():
            files[f"{name}.png"] = png_bytes(picture_of(chart))
    return files


def write_report(folder: Path, report: SceneReport) -> list[Path]:
    """Write the files of a report into a folder, which is made if there is none; returns them.

    Raises
    ------
    EvaluationError
        The folder cannot be written to.
    """
    files = report_files(report)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            (folder / name).write_bytes(data)
    except OSError as error:
        raise EvaluationError(
            f"The report cannot be written to '{folder}': {error.strerror}; choose another folder."
        ) from None
    return [folder / name for name in files]


def _lead(embedding: Embedding) -> str:
    grid, graph = embedding.environment.grid, embedding.graph
    used = len({segment.clip for segment in graph.segments})
    seconds = sum(segment.duration for segment in graph.segments)
    return (
        f"{wording.counted(len(graph.segments), 'motion segment')} ({wording.time(seconds)}) of "
        f"{wording.counted(used, 'clip')} and {wording.counted(len(graph.links), 'link')} between them, on a ground of "
        f"{wording.amount(grid.size[0])} x {wording.amount(grid.size[1])} m in cells of "
        f"{wording.exact(100 * grid.cell_size)} cm and {wording.counted(grid.n_headings, 'heading')}. Unrolled into "
        f"the scene: {wording.counted(embedding.n_nodes, 'node')} and {wording.counted(embedding.n_links, 'link')}."
    )


def _plain(value):
    """Nested values as JSON knows them."""
    if isinstance(value, dict):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return plain(value)
