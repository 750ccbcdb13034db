"""The report of a scene: what can the character reach, what is weak, what matters, what is missing, on one page."""

import json
from collections.abc import Collection, Generator
from dataclasses import dataclass
from pathlib import Path

from .. import wording
from ..embedding.embedding import Embedding
from ..errors import EvaluationError, MotionGraphError
from ..files import write_files
from ..progress import Progress, portion
from .drawing import svg
from .finding import Contribution, Questions, Topic
from .floor_chart import picture_of
from .page import Paragraph, Section, html_page
from .png import png_bytes
from .table import plain
from .topics import REACH, SECTIONS


@dataclass(frozen=True)
class SceneReport:
    """Sections of a report with their numbers, tables and drawings.

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
        """Write the page: one file, pictures inside, nothing from the network."""
        return html_page(self.title, self.lead, [part.section for part in self.contributions.values()])

    def numbers(self) -> dict:
        """Plain values by topic, for JSON; tables as records."""
        return {
            topic.section: _plain(part.numbers) | {name: found.records() for name, found in part.tables.items()}
            for topic, part in self.contributions.items()
        }


def examine_scene_steps(
    embedding: Embedding,
    questions: Questions | None = None,
    title: str = "Scene",
    topics: Collection[Topic] = SECTIONS,
) -> Generator[Progress, None, SceneReport]:
    """Find out all that a report says; yields progress, returns a :class:`SceneReport`.

    Where a question has no answer - an embedding that is empty, nothing that travels - its section says why. Times are
    left out if there is no goal.

    Raises EvaluationError if there are no topics.
    """
    questions = questions or Questions()
    if not topics:
        raise EvaluationError("A report about nothing was asked for; choose at least one topic.")
    asked = [topic for topic in SECTIONS if topic in topics and (questions.goal or topic is not REACH)]
    total = sum(topic.effort for topic in asked)
    found: dict[Topic, Contribution] = {}
    done = 0.0
    for topic in asked:
        try:
            steps = portion(
                _contribution_steps(topic, embedding, questions), done / total, (done + topic.effort) / total
            )
            found[topic] = yield from steps
        except MotionGraphError as error:
            found[topic] = Contribution(Section(topic.title, (Paragraph(str(error)),)), {"problem": str(error)})
        done += topic.effort
    return SceneReport(title, _lead(embedding), found)


def _contribution_steps(
    topic: Topic, embedding: Embedding, questions: Questions
) -> Generator[Progress, None, Contribution]:
    assert topic.find is not None, topic.name
    finding = yield from topic.find(embedding, questions)
    assert finding.contribute is not None, topic.name
    return finding.contribute()


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

    Raises StorageError if one is not ours to replace, or the folder cannot be written to.
    """
    files = report_files(report)
    write_files(folder, files)
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
