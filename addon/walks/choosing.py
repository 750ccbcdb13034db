"""Choosing among walks: several seeds are tried, and the one whose motion has the fewest defects is taken."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace

from ...core.embedding.embedding import Embedding
from ...core.playback.walk import Walk
from ...core.progress import Progress, portion
from .motion import MotionRequest, motion_steps
from .planning import walk_steps
from .request import WalkRequest


@dataclass(frozen=True)
class TriedWalk:
    """A walk that was tried.

    Attributes
    ----------
    seed : int
    defects : float
        As :attr:`core.playback.quality.WalkQuality.defects` counts them, after the feet were held.
    crosses : bool
        Whether it plays what the regions ask for, such as a step over; True if they ask for nothing.
    """

    seed: int
    defects: float
    crosses: bool


def tried_walks_steps(
    embedding: Embedding, request: WalkRequest, motion_request: MotionRequest, seeds: Sequence[int]
) -> Generator[Progress, None, list[TriedWalk]]:
    """Walk with each of some seeds; the best first: those that cross what there is to cross, then by their defects."""
    tried = []
    for number, seed in enumerate(seeds):
        done, next_done = number / len(seeds), (number + 1) / len(seeds)
        middle = (done + next_done) / 2
        walk = yield from portion(walk_steps(embedding, replace(request, seed=seed)), done, middle)
        motion = yield from portion(motion_steps(walk, motion_request), middle, next_done)
        tried.append(TriedWalk(seed, motion.after.defects, _crosses(walk)))
    return sorted(tried, key=lambda found: (not found.crosses, found.defects, found.seed))


def _crosses(walk: Walk) -> bool:
    tags, segments = walk.embedding.environment.tags, walk.embedding.graph.segments
    known = tags & {tag for segment in segments for tag in segment.tags}
    return not known or any(known & set(segments[s].tags) for s in set(walk.segments.tolist()))
