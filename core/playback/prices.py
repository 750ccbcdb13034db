"""Prices of links: how much longer a character would rather walk than take them.

A price is in milliseconds, a whole number, so that sums are exact. It is the time that a segment lasts, and more for
what an onlooker notices: an unlike transition, an edit of the root, standing about, turning back, the same again.
"""

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from ..embedding.embedding import Embedding
from ..embedding.footprint import path_length
from ..errors import WalkError
from ..motion.body_size import relative_size
from .pace import TURN_TIME, idle_frames
from .spikes import graph_roughness, segment_spikes

#: Metres by which an edit of the heading by one radian counts, beside an edit of the place.
HEADING_LEVER = 0.5

#: Metres over which an edit is spread at least: over less than a step, a metre says little.
EDIT_LENGTH = 0.5


@dataclass(frozen=True)
class PriceSettings:
    """Seconds that a character would rather walk longer, for each of what an onlooker notices.

    Attributes
    ----------
    cost : float
        For one rad^2 of transition cost.
    edit : float
        For one metre of edit, of place and heading (:func:`link_edits`), for a character of a person's size.
    bend : float
        For the square of the edit by metre of path, in times of ``noticeable_bend``.
    noticeable_bend : float
        Metres by metre.
    idle : float
        For a second of standing, turning on the spot or shuffling, beside that second.
    back : float
        For one radian that two segments, or one, turn by beyond ``free_turn`` within two seconds.
    free_turn : float
        Radians.
    again : float
        For a segment that has just been played.
    rough : float
        For each spike of the clip itself, see :func:`.spikes.segment_spikes`.
    """

    cost: float = 10.0
    edit: float = 20.0
    bend: float = 5.0
    noticeable_bend: float = 0.08
    idle: float = 8.0
    back: float = 30.0
    free_turn: float = float(np.radians(80))
    again: float = 2.0
    rough: float = 2.0

    def times(self, factor: float) -> "PriceSettings":
        """Return the same, with everything but time weighing ``factor`` times as much."""
        names = ("cost", "edit", "bend", "idle", "back", "again", "rough")
        return replace(self, **{name: factor * getattr(self, name) for name in names})

    def __post_init__(self):
        weights = (self.cost, self.edit, self.bend, self.idle, self.back, self.free_turn, self.again, self.rough)
        if not (np.isfinite(weights).all() and min(weights) >= 0 and self.noticeable_bend > 0):
            raise WalkError("The prices of links must be zero or more seconds.")


class LinkPrices:
    """The prices of all links of an embedding.

    Attributes
    ----------
    embedding : Embedding
    of_segment : (S,) int array
        Milliseconds for playing each segment.
    of_stencil : (K,) int array
        For the edit of each stencil.
    of_link : (L,) int array
        For the transition of each link of the motion graph.
    """

    def __init__(self, embedding: Embedding, settings: PriceSettings | None = None):
        settings = settings or PriceSettings()
        graph, stencils = embedding.graph, embedding.unrolling.stencils
        segments = graph.segments
        # Paths without clips are a person's.
        size = relative_size(graph.clips[0].skeleton) if graph.clips else 1.0
        duration = np.array([segment.duration for segment in segments])
        turn = np.array([segment.path[-1, 2] for segment in segments])
        idle = duration * [idle_frames(segment.path, graph.frame_rate, size).mean() for segment in segments]
        length = np.array([path_length(segment) for segment in segments]) / size
        first, second = graph.links.T
        self.embedding = embedding
        spikes = segment_spikes(graph, graph_roughness(graph)) if graph.clips else np.zeros(len(segments))
        turned = settings.back * _beyond(turn, duration, settings)
        self.of_segment = _ticks(duration + settings.idle * idle + turned + settings.rough * spikes)
        moved = np.linalg.norm(stencils.position_error, axis=1) / size
        share = moved / np.maximum(length[stencils.segment], EDIT_LENGTH) / settings.noticeable_bend
        self.of_stencil = _ticks(settings.edit * link_edits(embedding) / size + settings.bend * share**2)
        both = _beyond(turn[first] + turn[second], duration[first] + duration[second], settings)
        self.of_link = _ticks(
            settings.cost * graph.link_costs + settings.back * both + settings.again * (first == second)
        )
        self._keys = first * len(segments) + second

    @property
    def usual(self) -> float:
        """Milliseconds that a link costs for each frame, as a rule."""
        graph, stencils = self.embedding.graph, self.embedding.unrolling.stencils
        frames = np.array([segment.n_frames - 1 for segment in graph.segments])[stencils.segment]
        playing = self.of_segment[stencils.segment] + self.of_stencil
        return float(np.median(playing / frames) + np.median(self.of_link) / np.median(frames))

    def with_segments(self, of_segment: np.ndarray) -> "LinkPrices":
        """Return the same prices, but others for playing each segment."""
        other = copy(self)
        other.of_segment = of_segment
        return other

    def of(self, before: np.ndarray, stencils: np.ndarray) -> np.ndarray:
        """Return (n,) milliseconds for links by (n,) stencils after the segments (n,) ``before``."""
        segment = self.embedding.unrolling.stencils.segment[stencils]
        link = np.searchsorted(self._keys, before * len(self.of_segment) + segment)
        return self.of_segment[segment] + self.of_stencil[stencils] + self.of_link[link]


def link_edits(embedding: Embedding) -> np.ndarray:
    """Return (K,) metres by which each stencil edits its segment's end: place and heading together."""
    stencils = embedding.unrolling.stencils
    return np.hypot(np.hypot(*stencils.position_error.T), HEADING_LEVER * stencils.heading_error)


def _beyond(turn: np.ndarray, duration: np.ndarray, settings: PriceSettings) -> np.ndarray:
    """Return (n,) radians that turns take beyond what is free within ``TURN_TIME``; of longer ones, a share."""
    return np.maximum(np.abs(turn) * np.minimum(TURN_TIME / duration, 1.0) - settings.free_turn, 0.0)


def _ticks(seconds: np.ndarray) -> np.ndarray:
    return np.rint(1000 * seconds).astype(np.int64)
