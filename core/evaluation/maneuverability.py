"""Local maneuverability: how soon an action can begin, from wherever the character is.

Reitsma & Pollard 2007, "Evaluating motion graphs for character animation". An action is a segment, a clip or a tag;
the time counts from the end of the segment that is being played to the start of the action's first segment.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from .. import wording
from ..embedding.embedding import Embedding
from ..errors import EvaluationError
from ..progress import Progress, portion
from .goals import goal_to_begin
from .reach import NEVER, time_to_reach_steps
from .segment_groups import Grouping, SegmentGroup, segment_groups

#: Seconds that a player waits without minding.
PROMPT = 1.0


@dataclass(frozen=True)
class Maneuverability:
    """Times until an action can begin.

    Attributes
    ----------
    action : SegmentGroup
    floor : (nx, ny) float array
        Seconds to its beginning in the mean over all nodes of a cell; not a number where there is no node.
    mean, worst : float
        Seconds over all nodes; infinite if it cannot be played at all.
    at_once, promptly : float
        Share of the nodes from which it can begin at once, and within one second; 0 to 1.
    """

    action: SegmentGroup
    floor: np.ndarray
    mean: float
    worst: float
    at_once: float
    promptly: float

    def describe(self) -> str:
        subject = f"{self.action.kind.value.capitalize()} '{self.action.name}'"
        if not np.isfinite(self.mean):
            return f"{subject} can begin nowhere in this scene."
        return (
            f"{subject} can begin after {wording.time(self.mean)} on average, {wording.time(self.worst)} at worst; "
            f"from {wording.share(self.at_once)} of the nodes at once, from {wording.share(self.promptly)} within "
            f"{wording.exact(PROMPT)} s."
        )


def maneuverability_steps(embedding: Embedding, action: SegmentGroup) -> Generator[Progress, None, Maneuverability]:
    """Measure how soon an action can begin, exactly and over all nodes; EvaluationError if the embedding is empty."""
    if not embedding.n_nodes:
        raise EvaluationError("The embedding is empty: there is nothing that an action could begin from.")
    nx, ny, n_headings, n_segments = embedding.shape
    if not any(any(embedding.planes[s * n_headings : (s + 1) * n_headings]) for s in action.segments):
        return Maneuverability(action, np.full((nx, ny), np.nan), np.inf, np.inf, 0.0, 0.0)
    # A node of the action was arrived at on a link from a node: there it can begin.
    field = yield from time_to_reach_steps(embedding, goal_to_begin(embedding, action.segments))
    rate = embedding.graph.frame_rate
    total, n_nodes = np.zeros((nx, ny)), np.zeros((nx, ny), dtype=int)
    n_at_once = n_prompt = worst = 0
    for segment in range(n_segments):
        frames = field.frames_of(segment)
        # An embedding is strongly connected: whatever has a node has a way.
        nodes = frames != NEVER
        n_nodes += np.count_nonzero(nodes, axis=2)
        total += np.where(nodes, frames, 0).sum(axis=2)
        worst = max(worst, int(frames[nodes].max(initial=0)))
        n_at_once += int(np.count_nonzero(frames == 0))
        n_prompt += int(np.count_nonzero(frames <= PROMPT * rate))
    floor = np.divide(total, n_nodes * rate, out=np.full((nx, ny), np.nan), where=n_nodes > 0)
    n = embedding.n_nodes
    return Maneuverability(action, floor, float(total.sum()) / n / rate, worst / rate, n_at_once / n, n_prompt / n)


def maneuverabilities_steps(
    embedding: Embedding, kind: Grouping = Grouping.CLIP
) -> Generator[Progress, None, list[Maneuverability]]:
    """Measure how soon each segment, clip or tag can begin, in their order; see :func:`maneuverability_steps`."""
    actions = segment_groups(embedding.graph, kind)
    found = []
    for done, action in enumerate(actions):
        steps = maneuverability_steps(embedding, action)
        found.append((yield from portion(steps, done / len(actions), (done + 1) / len(actions))))
    return found
