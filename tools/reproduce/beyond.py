"""Beyond the paper: the metrics of 2007, ablation and the capture director on the same scenes."""

from pathlib import Path

from ...core.embedding.embedding import Embedding
from ...core.progress import finish
from ...core.report.finding import Questions, Topic
from ...core.report.page import Bullets, Paragraph, Section
from ...core.report.scene_report import SceneReport, examine_scene_steps, write_report
from ...core.report.table import table
from ...core.report.topics import CAPTURE, COVERAGE, IMPORTANCE, LINKS, METRICS, TURNS, WEAK_SPOTS
from .chapter import Chapter
from .stage import Place

#: What the table of all scenes is made from.
SHORT = frozenset({COVERAGE, TURNS, CAPTURE, METRICS})

#: What the room of Fig. 1 is asked; other figures show the rest, or it takes long.
WHOLE = SHORT | {WEAK_SPOTS, IMPORTANCE, LINKS}


def examine(place: Place, embedding: Embedding, folder: Path, topics: frozenset[Topic], thorough: bool) -> SceneReport:
    """Examine a scene and write its report into a folder."""
    questions = Questions(thorough, obstacles=place.floor.obstacles)
    report = finish(examine_scene_steps(embedding, questions, place.layout.label, topics))
    write_report(folder, report)
    return report


def compare_scenes(reports: dict[str, SceneReport]) -> Chapter:
    """The metrics of all scenes in one table, and the best advice for each."""
    columns, rows, advice = ["scene"], [], []
    for name, report in reports.items():
        metrics = report.contributions[METRICS].tables.get("metrics")
        balance = report.contributions[TURNS].numbers.get("turn_balance")
        if metrics is not None:
            columns = ["scene", *(f"{row[0]} ({row[2]})" for row in metrics.rows), "turn balance (-1 right, 1 left)"]
            rows.append([report.title, *(row[1] for row in metrics.rows), balance])
        sentences = report.contributions[CAPTURE].numbers.get("capture", ())
        advice += [f"{report.title}: {sentence}" for sentence in sentences[:2]]
        advice.append(f"All about it: {name}/report.html")
    return Chapter(
        Section(
            "Beyond the paper: metrics and the capture director on all scenes",
            (
                Paragraph(
                    "Metrics after Reitsma & Pollard 2007, and which missing motion would open most: each one tried "
                    "was embedded exactly, as if it had been captured."
                ),
                table(columns, rows),
                Bullets(tuple(advice)),
            ),
        ),
        numbers={name: report.numbers() for name, report in reports.items()},
    )


def sections_of(report: SceneReport, topics: tuple[Topic, ...]) -> list[Section]:
    """Some of a scene's sections, with the scene's name in their titles."""
    found = [report.contributions[topic].section for topic in topics if topic in report.contributions]
    return [Section(f"Beyond the paper, {report.title.lower()}: {part.title}", part.blocks) for part in found]
