"""Styles of walks: the ways to choose one, each with the settings that it heeds and the generator that plans it.

:data:`STYLES` is the only list of them: the interface's choice and its panel, the operators and the command line are
derived from it.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import LinkReader, Node
from ..embedding.node_set import NodeSet
from ..errors import EvaluationError, WalkError
from ..evaluation.goals import goal_in_cells
from ..evaluation.segment_groups import segments_of_clip, segments_with_tag
from ..progress import Progress, portion
from .curve import CurveSettings, walk_along_steps
from .destination import destination
from .directed import walk_through_steps
from .loop import loop_steps
from .near_cheapest import STARTS, NearCheapest
from .performance import continued, perform_steps
from .walk import (
    Walk,
    WalkSettings,
    nearest_node,
    random_node,
    random_walk_steps,
    refuse_bad_duration,
    refuse_too_long,
)
from .wandering import wandering_walk_steps
from .weighted import Weighting, uniform

Place = tuple[float, float]


@dataclass(frozen=True)
class WalkRequest:
    """A walk that is asked for. A style heeds the seed and what belongs to its settings.

    Attributes
    ----------
    style : key of :data:`STYLES`
    seed : int
    duration : float
        Seconds; of styles that arrive somewhere, only if they wander on.
    walk_on : bool
        Wander on after arriving.
    weighting : Weighting
    start : world x, y (m) or None for anywhere
    goals : (name, place) of every place to go to, in their order
    smoothness : float
        0 to 1, of directed walks: 0 for the quickest way, see :func:`.directed.trail_steps`.
    nearness : float
        Metres from a goal's place to the root that is there.
    heading : float or None
        Radians: direction to face at the last goal; None for any.
    heading_tolerance : float
        Radians.
    curve : (n, 2) float array or None
        World x, y (m) of the polyline to follow.
    width : float
        Metres to either side of the curve.
    clip, tag : str
        The clip that is performed; or, if it is not empty, the tag of the frames that are.
    """

    style: str
    seed: int = 0
    duration: float = 60.0
    walk_on: bool = False
    weighting: Weighting = uniform
    start: Place | None = None
    goals: tuple[tuple[str, Place], ...] = ()
    smoothness: float = 0.5
    nearness: float = 0.0
    heading: float | None = None
    heading_tolerance: float = 0.0
    curve: np.ndarray | None = None
    width: float = 0.5
    clip: str = ""
    tag: str = ""


@dataclass(frozen=True)
class WalkStyle:
    """A way to choose a walk.

    Attributes
    ----------
    label, description : str
        For people.
    settings : tuple of str
        What it heeds beside the seed, in the order in which a person is asked for it: "duration", "weighting",
        "start", "target" or "waypoints" (the goals), "nearness", "facing", "smoothness", "curve", "action" (clip or
        tag).
    plan : function of an embedding, a :class:`WalkRequest` and a random generator
        Generator that yields progress and returns the Walk.
    closed : bool
        The walk ends at the node that it starts from.
    """

    label: str
    description: str
    settings: tuple[str, ...]
    plan: Callable[[Embedding, WalkRequest, np.random.Generator], Generator[Progress, None, Walk]]
    closed: bool = False

    @property
    def arrives(self) -> bool:
        """The walk ends where it is to go, not when its time is up."""
        return "duration" not in self.settings


def walk_steps(embedding: Embedding, request: WalkRequest) -> Generator[Progress, None, Walk]:
    """Plan the walk that a request asks for.

    Raises
    ------
    WalkError
        There is no such walk; the message says why.
    """
    style, rng = STYLES[request.style], np.random.default_rng(request.seed)
    if request.walk_on or not style.arrives:
        refuse_bad_duration(request.duration)
        refuse_too_long(embedding, request.duration)
    yield Progress(0.0, "Finding a start")
    goes_on = request.walk_on and style.arrives
    walk = yield from portion(style.plan(embedding, request, rng), 0.05, 0.7 if goes_on else 1.0)
    left = request.duration - walk.duration
    if goes_on and left > 0:
        x, y, heading, segment = walk.states[-1].tolist()
        nx, ny = embedding.shape[:2]
        settings = WalkSettings(left, (x % nx, y % ny, heading, segment))
        further = yield from portion(wandering_walk_steps(embedding, rng, settings), 0.7, 1.0)
        walk = continued(walk, further)
    return walk


def _wander(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    return wandering_walk_steps(embedding, rng, _settings(embedding, request, rng))


def _random(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    return random_walk_steps(embedding, rng, _near_cheapest(embedding, request, rng))


def _loop(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    return loop_steps(embedding, rng, _near_cheapest(embedding, request, rng))


def _through(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    goals = []
    for number, (name, place) in enumerate(request.goals, 1):
        heading = request.heading if number == len(request.goals) else None
        try:
            goals.append(destination(embedding, place, request.nearness, heading, request.heading_tolerance))
        except WalkError as error:
            raise WalkError(f"'{name}': {error}") from error
    start = _start_nodes(embedding, request, rng)
    return walk_through_steps(embedding, start, goals, smoothness=request.smoothness)


def _along(embedding: Embedding, request: WalkRequest, _: np.random.Generator):
    if request.curve is None:
        raise WalkError("Choose a curve to follow first.")
    return walk_along_steps(embedding, request.curve, CurveSettings(width=request.width))


def _perform(embedding: Embedding, request: WalkRequest, rng: np.random.Generator):
    try:
        if request.tag:
            segments = segments_with_tag(embedding.graph, request.tag)
        else:
            segments = segments_of_clip(embedding.graph, request.clip)
    except EvaluationError as error:
        raise WalkError(str(error)) from error
    start, (_, place) = _start_nodes(embedding, request, rng), request.goals[0]
    tag, smoothness = request.tag or None, request.smoothness
    steps = perform_steps(embedding, start, segments, place, request.nearness, tag, smoothness=smoothness)
    return (yield from steps).walk


def _settings(embedding: Embedding, request: WalkRequest, rng: np.random.Generator) -> WalkSettings:
    start = None if request.start is None else nearest_node(embedding, request.start, rng)
    return WalkSettings(request.duration, start, request.weighting)


def _near_cheapest(embedding: Embedding, request: WalkRequest, rng: np.random.Generator) -> WalkSettings:
    """Prefer what is cheap, and start from the best of some nodes."""
    likely = NearCheapest(embedding, request.weighting)
    starts = [_settings(embedding, request, rng).start or random_node(embedding, rng) for _ in range(STARTS)]
    return WalkSettings(request.duration, likely.best_of(LinkReader(embedding), starts), likely)


def _start_nodes(embedding: Embedding, request: WalkRequest, rng: np.random.Generator) -> Node | NodeSet:
    """Return one node by chance, or all of the cell nearest to the start, of which the best is found."""
    if request.start is None:
        return random_node(embedding, rng)
    x, y, _, _ = nearest_node(embedding, request.start, rng)
    cells = np.zeros(embedding.shape[:2], dtype=bool)
    cells[x, y] = True
    return goal_in_cells(embedding, cells, "The start")


#: Every style by the name that files keep, in the order in which a person chooses; files count on that, too.
STYLES = {
    "WANDER": WalkStyle("Wander", "From place to place, all parts of the floor alike", ("start", "duration"), _wander),
    "RANDOM": WalkStyle("Random", "Link after link by chance", ("weighting", "start", "duration"), _random),
    "PLACE": WalkStyle(
        "To a Place",
        "To the 3D cursor or to an object, quickly or smoothly",
        ("target", "nearness", "facing", "smoothness", "start"),
        _through,
    ),
    "WAYPOINTS": WalkStyle(
        "Waypoints",
        "Past all objects of a collection, in the order of their names, quickly or smoothly",
        ("waypoints", "nearness", "facing", "smoothness", "start"),
        _through,
    ),
    "CURVE": WalkStyle(
        "Along a Curve", "As near to a curve as possible, from its start to its end", ("curve",), _along
    ),
    "LOOP": WalkStyle(
        "Loop",
        "Back to where the walk starts, to be repeated without a seam",
        ("weighting", "start", "duration"),
        _loop,
        closed=True,
    ),
    "PERFORM": WalkStyle(
        "Perform",
        "To where a motion can be played at a place, quickly or smoothly, and it",
        ("action", "target", "nearness", "smoothness", "start"),
        _perform,
    ),
}
