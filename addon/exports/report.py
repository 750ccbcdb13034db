"""The report of a scene: what is asked, and put into words for its reader."""

import contextlib
from collections.abc import Generator

from ...core.errors import EvaluationError
from ...core.evaluation.query import query_nodes
from ...core.progress import Progress
from ...core.report.scene_report import Goal, ReportOptions, SceneReport, examine_scene_steps
from ..results.state import embedding_of


def scene_report_steps(scene, thorough: bool) -> Generator[Progress, None, SceneReport]:
    """Examine the scene's embedding; times count to what the panel Queries asks for, if that can be reached."""
    embedding, query = embedding_of(scene), scene.wayfarer.queries.to_query()
    goal = None
    with contextlib.suppress(EvaluationError):
        goal = Goal(query.words, query_nodes(embedding, query))
    character = scene.wayfarer.character
    title = f"{character.name} in {scene.name}" if character is not None else scene.name
    settings = scene.wayfarer.evaluation
    options = ReportOptions(
        title,
        thorough=thorough,
        goal=goal,
        seed=settings.seed,
        n_pairs=settings.n_pairs,
        allowed_loss=settings.allowed_loss / 100,
    )
    return (yield from examine_scene_steps(embedding, options))
