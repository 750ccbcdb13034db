"""Loops: walks that return to the very node they started from, to be played again and again."""

from collections.abc import Generator

import numpy as np

from ..embedding.embedding import Embedding
from ..progress import Progress, portion
from .directed import quickest_trail_steps
from .time_to_go import TimeToGo, time_to_go_steps
from .walk import Trail, Walk, WalkSettings, begin
from .weighted import Memory, Weighting, probabilities

#: Walks tried until one lasts exactly as long as asked.
ATTEMPTS = 60


def loop_steps(
    embedding: Embedding, rng: np.random.Generator, settings: WalkSettings
) -> Generator[Progress, None, Walk]:
    """Walk by chance, and end at the node where the walk began, arriving by its segment.

    What follows its last frame is its first link: the loop closes with a transition like all others. The walker goes
    where the weighting leads while there is time, and then home by the quickest way. Several such walks are tried, and
    the one that lasts the least longer than asked is returned: longer loops are met to the frame, as a rule, while
    short ones may not exist at that node. A loop around an edge of a tiled ground ends in another tile, at the same
    place of it.

    Raises
    ------
    WalkError
        The embedding is empty, or the start is no node of it.
    """
    reader, node = begin(embedding, rng, settings.start)
    wanted = int(np.ceil(settings.duration * embedding.graph.frame_rate - 1e-6))
    x, y, heading, segment = reader.wrapped(np.array([node]))[0].tolist()
    home = embedding.network.node(segment, heading, x, y)
    time_to_go = yield from portion(time_to_go_steps(embedding, [home]), 0.0, 0.6)
    best: Trail | None = None
    for attempt in range(ATTEMPTS):
        yield Progress(0.6 + 0.4 * attempt / ATTEMPTS, "Closing the loop")
        trail = _roam(time_to_go, Trail(reader, node), wanted, rng, settings.weighting)
        if not np.array_equal(reader.wrapped(np.array([trail.node]))[0], [x, y, heading, segment]):
            way = yield from portion(quickest_trail_steps(reader, time_to_go, np.array([trail.node])), 0.6, 1.0)
            for stencil in way.stencils:
                trail.take(stencil)
        if best is None or trail.frames < best.frames:
            best = trail
        if best.frames == wanted:
            break
    assert best is not None
    return best.walk()


def _roam(time_to_go: TimeToGo, trail: Trail, wanted: int, rng: np.random.Generator, weighting: Weighting) -> Trail:
    """Walk until the quickest way home makes a loop that lasts long enough.

    Links that still leave time, or make the time exact, go before those that make the loop longer than asked.
    """
    embedding, memory = time_to_go.embedding, Memory(trail.reader)
    durations = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
    while True:
        memory.pass_by(trail.node)
        crossing = memory.crossing(trail.node)
        total = trail.frames + durations[crossing.ends[:, 3]]
        total += time_to_go.frames_at(0, trail.reader.wrapped(crossing.ends))
        chance = probabilities(weighting, crossing)
        late = np.maximum(total - wanted, 0)
        chance = np.where(late == late.min(), chance, 0.0)
        if not chance.any():
            chance = (late == late.min()).astype(float)
        choice = int(rng.choice(len(total), p=chance / chance.sum()))
        trail.take(int(crossing.stencils[choice]))
        if total[choice] >= wanted:
            return trail
