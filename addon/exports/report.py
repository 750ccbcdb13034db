"""Pages for the browser: the report of a scene, a single finding, contacts."""

import contextlib
from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path

import bpy

from ...core.errors import EvaluationError
from ...core.evaluation.query import query_nodes
from ...core.files import write_whole
from ...core.progress import Progress
from ...core.report.finding import Goal, Topic
from ...core.report.page import Bullets, Figure, Section, html_page
from ...core.report.scene_report import SceneReport, examine_scene_steps
from ...core.report.table import table
from ..results.findings import chart_of, find_finding, numbers_of, table_of
from ..results.store import embedding_of


def scene_report_steps(scene, thorough: bool) -> Generator[Progress, None, SceneReport]:
    """Examine the scene's embedding; times count to what the panel Queries asks for, if that can be reached."""
    embedding, query = embedding_of(scene), scene.wayfarer.queries.to_query()
    goal = None
    with contextlib.suppress(EvaluationError):
        goal = Goal(query.words, query_nodes(embedding, query))
    character = scene.wayfarer.character
    title = f"{character.name} in {scene.name}" if character is not None else scene.name
    questions = replace(
        scene.wayfarer.evaluation.to_core(), thorough=thorough, goal=goal, weak_spots=None, n_candidates=None
    )
    return (yield from examine_scene_steps(embedding, questions, title))


def open_finding(scene, topic: Topic) -> Path | None:
    """Open a page with the finding on a topic: chart, sentences and all numbers; None if there is nothing to draw."""
    chart, kept = chart_of(scene, topic), find_finding(scene, topic)
    if chart is None:
        return None
    blocks = (Figure(chart), Bullets(tuple(kept.sentences.splitlines())), table_of(kept))
    numbers = table(("number", "value"), numbers_of(kept))
    return open_page(topic.title, scene.name, [Section(topic.title, (numbers, *blocks) if numbers.rows else blocks)])


def open_page(title: str, lead: str, sections: Sequence[Section]) -> Path:
    """Write a page to Blender's folder for temporary files, and show it in the browser if there is a window."""
    path = Path(bpy.app.tempdir) / f"{bpy.path.clean_name(f'wayfarer {title}').lower()}.html"
    write_whole(path, html_page(title, lead, sections).encode())
    show_page(path)
    return path


def show_page(path: Path) -> None:
    """Open a page in the browser, unless there is no window to come back to."""
    if not bpy.app.background:
        bpy.ops.wm.url_open(url=path.resolve().as_uri())
