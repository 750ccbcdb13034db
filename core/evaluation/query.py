"""Questions to an embedding: how long does it take to get to, or from, a place, a tag or a clip?"""

from collections.abc import Generator
from dataclasses import dataclass
from enum import Enum

from ..embedding.embedding import Embedding
from ..embedding.node_set import NodeSet
from ..errors import EvaluationError
from ..progress import Progress
from ..wording import place
from .goals import goal_after, goal_at, goal_in_region, goal_to_begin, goal_with_tag
from .reach import PAPER_TIMES, ReachField, time_from_steps, time_to_reach_steps
from .segment_groups import segments_of_clip


class GoalKind(Enum):
    """The kinds of goals that a question can be about."""

    CURSOR = "cursor"
    OBJECT = "object"
    REGION = "region"
    TAG = "tag"
    CLIP = "clip"


@dataclass(frozen=True)
class Query:
    """A question.

    Attributes
    ----------
    kind : GoalKind
    name : str
        Of the object, region, tag or clip.
    place : (x, y) in metres
        Of the cursor or object.
    radius : float
        Metres around it that count as being there.
    forwards : bool
        False: how long it takes to the goal. True: from it.
    times : tuple of float
        Seconds, ascending, by which the answer is given.
    """

    kind: GoalKind = GoalKind.CURSOR
    name: str = ""
    place: tuple[float, float] = (0.0, 0.0)
    radius: float = 0.25
    forwards: bool = False
    times: tuple[float, ...] = PAPER_TIMES

    @property
    def words(self) -> str:
        """The goal in words: "region 'Door'"."""
        if self.kind is GoalKind.CURSOR:
            return place(*self.place)
        if self.kind is GoalKind.CLIP:
            return f"the {'end' if self.forwards else 'start'} of '{self.name}'"
        return f"{self.kind.value} '{self.name}'"

    @property
    def title(self) -> str:
        """ "Time to region 'Door'"."""
        return f"Time {'from' if self.forwards else 'to'} {self.words}"


def query_nodes(embedding: Embedding, query: Query) -> NodeSet:
    """Return the nodes that a question is about; EvaluationError, with what there is to choose, if there are none.

    A tag is reached right after doing it. A clip is reached where it can begin, and left where it has ended.
    """
    if query.kind in (GoalKind.OBJECT, GoalKind.REGION, GoalKind.TAG, GoalKind.CLIP) and not query.name:
        raise EvaluationError(f"No {query.kind.value} is chosen; choose one in the Queries panel.")
    if query.kind is GoalKind.REGION:
        return goal_in_region(embedding, query.name)
    if query.kind is GoalKind.TAG:
        return goal_with_tag(embedding, query.name)
    if query.kind is GoalKind.CLIP:
        segments, name = segments_of_clip(embedding.graph, query.name), f"the clip '{query.name}'"
        return goal_after(embedding, segments, name) if query.forwards else goal_to_begin(embedding, segments, name)
    return goal_at(embedding, query.place, query.radius)


def query_steps(embedding: Embedding, query: Query) -> Generator[Progress, None, ReachField]:
    """Find exact times from everywhere to what a question is about, or from there to everywhere."""
    steps = time_from_steps if query.forwards else time_to_reach_steps
    return (yield from steps(embedding, query_nodes(embedding, query)))
