"""Beyond the paper: the metrics of 2007, ablation and the capture director on the same scenes."""

from pathlib import Path

from ...core.embedding.embedding import Embedding
from ...core.progress import finish
from ...core.report.page import Bullets, Paragraph, Section
from ...core.report.scene_report import ReportOptions, SceneReport, Topic, examine_scene_steps, write_report
from ...core.report.table import table
from .chapter import Chapter
from .stage import Place

#: What the table of all scenes is made from.
SHORT = frozenset({Topic.REACH, Topic.TURNS, Topic.CAPTURE, Topic.METRICS})

#: What the room of Fig. 1 is asked; other figures show the rest, or it takes long.
WHOLE = SHORT | {Topic.WEAK_SPOTS, Topic.IMPORTANCE, Topic.LINKS}


def examine(place: Place, embedding: Embedding, folder: Path, topics: frozenset[Topic], thorough: bool) -> SceneReport:
    """Examine a scene and write its report into a folder."""
    options = ReportOptions(place.layout.label, topics, thorough, obstacles=place.floor.obstacles)
    report = finish(examine_scene_steps(embedding, options))
    write_report(folder, report)
    return report


def compare_scenes(reports: dict[str, SceneReport]) -> Chapter:
    """The metrics of all scenes in one table, and the best advice for each."""
    columns, rows, advice = ["scene"], [], []
    for name, report in reports.items():
        metrics = report.contributions[Topic.METRICS].tables.get("metrics")
        balance = report.contributions[Topic.TURNS].numbers.get("turn_balance")
        if metrics is not None:
            columns = ["scene", *(f"{row[0]} ({row[2]})" for row in metrics.rows), "turn balance (-1 right, 1 left)"]
            rows.append([report.title, *(row[1] for row in metrics.rows), balance])
        sentences = report.contributions[Topic.CAPTURE].numbers.get("capture", ())
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
