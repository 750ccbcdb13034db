"""Loops: walks that return to the very node they started from, to be played again and again."""

from collections.abc import Generator

import numpy as np

from ..embedding.embedding import Embedding
from ..evaluation.wavefront import NEVER
from ..progress import Progress, portion
from .cheapest import cheapest_way_steps
from .directed import TimeGuide
from .prices import LinkPrices
from .time_to_go import TimeToGo, time_to_go_steps
from .walk import Trail, Walk, WalkSettings, begin
from .wandering import CHANCE
from .weighted import Memory, Weighting, probabilities

#: Seconds of the way home, and the share of the loop that it is at the most.
HOMEWARD, HOMEWARD_SHARE = 18.0, 0.5


def loop_steps(
    embedding: Embedding, rng: np.random.Generator, settings: WalkSettings
) -> Generator[Progress, None, Walk]:
    """Walk by chance, and end at the node where the walk began, arriving by its segment.

    What follows its last frame is its first link: the loop closes with a transition like all others. The walker goes
    where the weighting leads, and then home by the cheapest way (:mod:`.prices`) of those that make the loop last as
    little longer than asked as possible; chance makes each segment up to ``CHANCE`` dearer for that. Longer loops are
    met to the frame, as a rule, while short ones may not exist at that node. A loop around an edge of a tiled ground
    ends in another tile, at the same place of it.

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
    trail = Trail(reader, node)
    until = wanted - int(min(HOMEWARD * embedding.graph.frame_rate, HOMEWARD_SHARE * wanted))
    _roam(time_to_go, trail, wanted, until, rng, settings.weighting)
    starts = np.array([trail.node])
    if trail.frames >= wanted and time_to_go.frames_at(0, starts)[0] == 0:
        return trail.walk()
    prices = LinkPrices(embedding)
    guide = TimeGuide(time_to_go, prices)
    chance = 1 + CHANCE * rng.random(len(prices.of_segment))
    prices = prices.with_segments(np.rint(chance * prices.of_segment).astype(np.int64))
    steps = cheapest_way_steps(reader, prices, guide, starts, NEVER - 1, at_least=wanted - trail.frames)
    _, way, _ = yield from portion(steps, 0.6, 1.0)
    for stencil in way:
        trail.take(stencil)
    return trail.walk()


def _roam(
    time_to_go: TimeToGo, trail: Trail, wanted: int, until: int, rng: np.random.Generator, weighting: Weighting
) -> None:
    """Walk until a frame, or until the quickest way home makes a loop that lasts as long as wanted.

    Links that still leave time, or make the time exact, go before those that make the loop longer than asked.
    """
    embedding, memory = time_to_go.embedding, Memory(trail.reader)
    durations = np.array([segment.n_frames - 1 for segment in embedding.graph.segments])
    total = 0
    while trail.frames < until and total < wanted:
        memory.pass_by(trail.node)
        crossing = memory.crossing(trail.node)
        totals = trail.frames + durations[crossing.ends[:, 3]]
        totals += time_to_go.frames_at(0, trail.reader.wrapped(crossing.ends))
        chance = probabilities(weighting, crossing)
        late = np.maximum(totals - wanted, 0)
        chance = np.where(late == late.min(), chance, 0.0)
        if not chance.any():
            chance = (late == late.min()).astype(float)
        choice = int(rng.choice(len(totals), p=chance / chance.sum()))
        trail.take(int(crossing.stencils[choice]))
        total = int(totals[choice])
