"""From a request to a walk: which of the core's ways of walking answers it."""

from collections.abc import Generator

import numpy as np

from ...core.embedding.embedding import Embedding
from ...core.embedding.link_reader import Node
from ...core.embedding.network import Nodes
from ...core.errors import EvaluationError, WalkError
from ...core.evaluation.goals import goal_in_cells, segments_of_clip, segments_with_tag
from ...core.playback.curve import CurveSettings, walk_along_steps
from ...core.playback.destination import destination
from ...core.playback.directed import walk_through_steps
from ...core.playback.loop import loop_steps
from ...core.playback.performance import continued, perform_steps
from ...core.playback.walk import Walk, WalkSettings, nearest_node, random_node, random_walk_steps
from ...core.playback.wandering import wandering_walk_steps
from ...core.progress import Progress, portion
from ..properties.walk import ARRIVING, ActionKind, WalkStyle
from .request import WalkRequest


def walk_steps(embedding: Embedding, request: WalkRequest) -> Generator[Progress, None, Walk]:
    """The walk that a request asks for, as a generator; WalkError says why there is none, if so."""
    rng = np.random.default_rng(request.seed)
    yield Progress(0.0, "Finding a start")
    goes_on = request.walk_on and request.style in ARRIVING
    walk = yield from portion(_STYLES[request.style](embedding, request, rng), 0.05, 0.7 if goes_on else 1.0)
    left = request.duration - walk.duration
    if goes_on and left > 0:
        x, y, heading, segment = walk.states[-1].tolist()
        nx, ny = embedding.shape[:2]
        start = x % nx, y % ny, heading, segment
        further = yield from portion(wandering_walk_steps(embedding, rng, WalkSettings(left, start)), 0.7, 1.0)
        walk = continued(walk, further)
    return walk


def _wander(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    return wandering_walk_steps(embedding, rng, WalkSettings(request.duration, _start_node(embedding, request, rng)))


def _random(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    start = _start_node(embedding, request, rng)
    return random_walk_steps(embedding, rng, WalkSettings(request.duration, start, request.weighting))


def _loop(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    start = _start_node(embedding, request, rng)
    return loop_steps(embedding, rng, WalkSettings(request.duration, start, request.weighting))


def _through(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    goals = []
    for number, (name, place) in enumerate(request.goals, 1):
        last = number == len(request.goals)
        heading = request.heading if last else None
        try:
            goals.append(destination(embedding, place, request.nearness, heading, request.heading_tolerance))
        except WalkError as error:
            raise WalkError(f"'{name}': {error}") from error
    return walk_through_steps(embedding, _start_nodes(embedding, request, rng), goals)


def _along(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    if request.curve is None:
        raise WalkError("Choose a curve to follow first.")
    return walk_along_steps(embedding, request.curve, CurveSettings(width=request.width))


def _perform(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    kind, name = request.action
    try:
        segments = (segments_of_clip if kind is ActionKind.CLIP else segments_with_tag)(embedding.graph, name)
    except EvaluationError as error:
        raise WalkError(str(error)) from error
    tag = name if kind is ActionKind.TAG else None
    start, (_, place) = _start_nodes(embedding, request, rng), request.goals[0]
    performance = yield from perform_steps(embedding, start, segments, place, request.nearness, tag)
    return performance.walk


_STYLES = {
    WalkStyle.WANDER: _wander,
    WalkStyle.RANDOM: _random,
    WalkStyle.PLACE: _through,
    WalkStyle.WAYPOINTS: _through,
    WalkStyle.CURVE: _along,
    WalkStyle.LOOP: _loop,
    WalkStyle.PERFORM: _perform,
}


def _start_node(embedding: Embedding, request: WalkRequest, rng: np.random.Generator) -> Node | None:
    return None if request.start is None else nearest_node(embedding, request.start, rng)


def _start_nodes(embedding: Embedding, request: WalkRequest, rng: np.random.Generator) -> Node | Nodes:
    """One node by chance, or all of the cell nearest to where the walk is to start: the best of them is found."""
    if request.start is None:
        return random_node(embedding, rng)
    x, y, _, _ = nearest_node(embedding, request.start, rng)
    cells = np.zeros(embedding.shape[:2], dtype=bool)
    cells[x, y] = True
    return goal_in_cells(embedding, cells, "The start")
