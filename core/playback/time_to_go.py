"""Times to go: the least time from everywhere through some goals, in their order."""

from collections.abc import Generator, Sequence

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.link_reader import PlaneBits
from ..embedding.node_set import NodeSet
from ..errors import WalkError
from ..evaluation.reach import exit_frames_steps
from ..evaluation.wavefront import NEVER
from ..progress import Progress, portion


class TimeToGo:
    """Goals to pass in order. Layer i means: goals 0 to i - 1 are passed, goal i is next.

    Parameters
    ----------
    goals : sequence of NodeSet
    tables : sequence of (n_merges, n_headings, nx, ny) uint16 arrays
        For each goal, the least frames of the ways by at least one link that pass this goal and all later ones.
    """

    def __init__(self, embedding: Embedding, goals: Sequence[NodeSet], tables: Sequence[np.ndarray]):
        network = embedding.network
        self.embedding = embedding
        self.n_goals = len(goals)
        self._tables = tables
        self._goals = [PlaneBits(goal.planes, network.layout.n_bytes) for goal in goals]
        self._exit_group_of = np.array(network.exit_group_of)

    def passes(self, goal: int, nodes: np.ndarray) -> np.ndarray:
        """Test which of (n, 4) nodes are in a goal; places may be unwrapped."""
        nx, ny, n_headings, _ = self.embedding.shape
        bit = self.embedding.unrolling.layout.bit(nodes[:, 0] % nx, nodes[:, 1] % ny)
        return self._goals[goal].at(nodes[:, 3] * n_headings + nodes[:, 2], bit)

    def frames_at(self, layer: int, nodes: np.ndarray) -> np.ndarray:
        """Return (n,) least frames from (n, 4) nodes through all goals from ``layer`` on; NEVER if there is no way."""
        if layer == self.n_goals:
            return np.zeros(len(nodes), dtype=int)
        nx, ny = self.embedding.shape[:2]
        x, y, heading, segment = nodes.T
        frames = self._tables[layer][self._exit_group_of[segment], heading, x % nx, y % ny].astype(int)
        here = np.flatnonzero(self.passes(layer, nodes))
        if len(here):
            frames[here] = np.minimum(frames[here], self.frames_at(layer + 1, nodes[here]))
        return frames

    def advanced(self, layer: np.ndarray, nodes: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Return (n,) layers of nodes in ``layer``, with their least ``frames``, after passing goals that they are in.

        A goal is passed as soon as that costs no time: whatever can follow then could follow before, too.
        """
        layer = layer.copy()
        for goal in range(self.n_goals):
            here = np.flatnonzero(layer == goal)
            here = here[self.passes(goal, nodes[here])]
            layer[here[self.frames_at(goal + 1, nodes[here]) == frames[here]]] += 1
        return layer


def time_to_go_steps(
    embedding: Embedding, goals: Sequence[NodeSet], last: int | None = None
) -> Generator[Progress, None, TimeToGo]:
    """Compute the times to go through goals in their order; ways of more than ``last`` frames count as none.

    The times to the last goal come first; those to each goal before it begin, at every node of the goal, with what is
    left from there.
    """
    if not goals:
        raise WalkError("There is nowhere to go; give at least one goal.")
    goals = [goal & embedding.nodes for goal in goals]
    for number, goal in enumerate(goals, 1):
        if not goal:
            which = f"goal {number}" if len(goals) > 1 else "the goal"
            raise WalkError(f"No walk of the embedding ever stands at {which}; choose a place inside the covered area.")
    network = embedding.network
    nothing = network.empty
    tables: list[np.ndarray] = []
    for index in range(len(goals) - 1, -1, -1):
        done = len(tables) / len(goals)
        if not tables:
            steps = exit_frames_steps(embedding, goals[index], last)
        else:
            rest = TimeToGo(embedding, goals[index + 1 :], tables)
            rows = rows_of(embedding, goals[index])
            left = rest.frames_at(0, rows)
            able = left <= (NEVER - 1 if last is None else last)
            steps = exit_frames_steps(embedding, nothing, last, (rows[able], left[able]))
        table = yield from portion(steps, done, done + 1 / len(goals))
        tables.insert(0, table)
    return TimeToGo(embedding, goals, tables)


def rows_of(embedding: Embedding, nodes: NodeSet) -> np.ndarray:
    """List (n, 4) x, y, heading, segment of a set's nodes in the embedding; by segment, heading, x, y."""
    n_headings = embedding.shape[2]
    kept = nodes & embedding.nodes
    rows = [np.empty((0, 4), dtype=int)]
    for index, plane in enumerate(kept.planes):
        if plane:
            cells = embedding.unrolling.layout.cells(plane)
            segment, heading = divmod(index, n_headings)
            rows.append(np.column_stack([cells, np.broadcast_to([heading, segment], cells.shape)]))
    return np.concatenate(rows)
